import json
import math
import re
from dataclasses import dataclass

import pytest

from cavalcade.campaign.report import write_report
from cavalcade.errors import InputError, OutputError


@dataclass(frozen=True)
class Bare:
    """A suite of which only this is known."""

    suite: str = "bare"
    about: str = ""


def pages(folder):
    return [(folder / name).read_text(encoding="utf-8") for name in ("report.md", "report.html")]


def test_a_whole_report(tmp_path, make_lines, suite):
    lines = make_lines(40)
    files = write_report(
        tmp_path, suite, lines, command="cavalcade campaign made-up --out /tmp/runs/here"
    )
    assert [file.name for file in files[:3]] == ["report.md", "report.html", "trials.parquet"]
    assert all(file.stat().st_size > 500 for file in files)
    assert sorted(p.name for p in (tmp_path / "figures").iterdir()) == [
        "curves-clutter.png",
        "curves-forest.png",
        "spread.png",
        "success.png",
        "variants.png",
    ]
    text, page = pages(tmp_path)
    assert "# Campaign `made-up`" in text
    assert "**Trials:** 240 (80 worlds × 3 variants)" in text
    assert "cavalcade campaign made-up --out here" in text
    assert "no difference shown" in text
    done = sum(
        line["success"]
        for line in lines
        if line["scenario"] == "clutter" and line["variant"] == "published"
    )
    assert re.search(rf"\| `clutter` \| `published` \| 40 \| \d+ \| {done} \|", text)
    for named in re.findall(r"\(figures/([^)]+)\)", text):
        assert (tmp_path / "figures" / named).exists()
    assert "http://" not in page
    assert "https://" not in page
    assert "/tmp/" not in text + page
    data = json.loads(re.search(r'application/json">(.*?)</script>', page, re.S)[1])
    assert len(data["rows"]) == 240
    assert not list(tmp_path.glob(".*"))


def test_the_order_of_lines_does_not_matter(tmp_path, make_lines, suite):
    found = []
    for name, lines in (("a", make_lines(8)), ("b", make_lines(8)[::-1])):
        folder = tmp_path / name
        folder.mkdir()
        files = write_report(folder, suite, lines)
        found.append({file.relative_to(folder): file.read_bytes() for file in files})
    assert found[0] == found[1]


def test_disturbances_and_a_picture_that_an_earlier_report_left(tmp_path, make_lines, suite):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "worst-old.png").write_bytes(b"old")
    lines = make_lines(10, ("clutter",), ("none", "late"), ("cavalcade",))
    write_report(tmp_path, suite, lines)
    text, _ = pages(tmp_path)
    assert "## Disturbances compared on the same worlds" in text
    assert "## Variants compared" not in text
    assert not (tmp_path / "figures" / "worst-old.png").exists()


def test_many_rows_are_drawn_scenario_by_scenario(tmp_path, make_lines, suite, monkeypatch):
    for module in ("canvas", "document"):
        monkeypatch.setattr(f"cavalcade.campaign.report.{module}.MOST_ROWS", 3)
    write_report(tmp_path, suite, make_lines(3, ("a", "b"), variants=("cavalcade", "published")))
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    assert {"success-a.png", "success-b.png", "spread-a.png", "variants.png"} <= names
    assert "success.png" not in names


def nothing(lines):
    return []


def crashes_only(lines):
    return [
        {**line, "outcome": "crashed", "success": False, "summary": {}, "measured": {}}
        for line in lines
    ]


def hopeless_only(lines):
    return [
        {**line, "feasible": False, "success": False, "outcome": "infeasible"} for line in lines
    ]


def one(lines):
    return lines[:1]


def without_level(lines):
    return [{**line, "level": None, "level_name": None} for line in lines]


def not_numbers(lines):
    return [
        {
            **line,
            "level": math.nan,
            "measured": {"time_ratio": math.inf},
            "summary": {**line["summary"], "min_footprint_gap_m": math.nan, "makespan_s": None,
                        "formation_error_m": None, "cycle_ms": {"p50": None}, "versions": None},
        }
        for line in lines
    ]  # fmt: skip


def only_names(lines):
    return [{"trial": line["trial"]} for line in lines]


def odd_names(lines):
    return [
        {**line, "scenario": "a|b <i>", "variant": "`x`**", "detail": "<b>|`"} for line in lines
    ]


@pytest.mark.parametrize(
    "change",
    [nothing, crashes_only, hopeless_only, one, without_level, not_numbers, only_names, odd_names],
)
def test_poor_campaigns_have_reports_too(tmp_path, make_lines, change):
    files = write_report(tmp_path, Bare(), change(make_lines(4, ("clutter",))))
    assert len(files) >= 3
    text, page = pages(tmp_path)
    for bad in ("nan", "inf ", "None"):
        assert not re.search(
            rf"(?<![\w-]){bad}(?![\w-])", text + re.sub(r"base64,[^\"]*", "", page)
        )
    assert "<i>" not in page


def test_without_pictures_no_folder_of_figures(tmp_path, make_lines, suite):
    files = write_report(tmp_path, suite, make_lines(3), pictures=False)
    assert [file.name for file in files] == ["report.md", "report.html", "trials.parquet"]
    assert not (tmp_path / "figures").exists()


def test_a_bare_crash_is_told_without_its_paths(tmp_path, bare_line):
    write_report(
        tmp_path, Bare(), [bare_line], replay=lambda line: pytest.fail("nothing to repeat")
    )
    text, page = pages(tmp_path)
    assert "ValueError: pid died (planner.py:12)" in text
    assert "4321" not in text
    assert "/opt" not in text + page
    assert "cavalcade trial . clutter.0000.cavalcade --out worst/clutter.0000.cavalcade" in text


def test_a_trial_that_cannot_be_repeated_is_remarked(tmp_path, make_lines, suite):
    def replay(line):
        raise InputError(f"no data in /tmp/{line['trial']}")

    write_report(tmp_path, suite, make_lines(2), replay=replay)
    text, _ = pages(tmp_path)
    assert "It could not be drawn: InputError." in text
    assert "/tmp" not in text


def test_a_folder_that_cannot_be_written_is_an_output_error(tmp_path, make_lines, suite):
    with pytest.raises(OutputError):
        write_report(tmp_path / "missing", suite, make_lines(1))


def test_many_cells_are_summed_up_over_all_scenarios(tmp_path, make_lines, suite):
    lines = make_lines(2, ("a", "b", "c", "d", "e"), variants=("cavalcade", "published"))
    write_report(tmp_path, suite, lines, pictures=False)
    text, _ = pages(tmp_path)
    done = sum(line["success"] for line in lines if line["variant"] == "cavalcade")
    assert f"- all scenarios, `cavalcade`: {done} of " in text


def test_collisions_that_count_and_those_that_do_not_are_told_apart(tmp_path, make_lines, suite):
    lines = make_lines(8, ("clutter",), variants=("cavalcade",))
    excused = {"outcome": "collision", "success": True, "feasible": True, "contacts": 1}
    for line in lines[:7]:
        line |= {**excused, "avoidable": 0, "detail": "a lost robot was hit"}
    lines[7] |= {**excused, "success": False, "avoidable": 1, "detail": "it stood"}
    write_report(tmp_path, suite, lines, pictures=False)
    text, _ = pages(tmp_path)
    excuses = text.split("## Collisions that could not be avoided")[1].split("##")[0]
    assert "7 in 7 trials" in excuses
    assert "| a lost robot was hit | 7 |" in excuses
    assert "and 2 more" in excuses
    assert "it stood" not in excuses
    assert "contacts 1, avoidable 0 (a lost robot was hit)" in text
    assert "**1 with an avoidable collision** in 8 trials" in text


def test_without_such_collisions_nothing_is_said_of_them(tmp_path, make_lines, suite):
    write_report(tmp_path, suite, make_lines(3), pictures=False)
    text, _ = pages(tmp_path)
    assert "could not be avoided" not in text
    assert "**Disturbances** are known" not in text


def test_with_disturbances_it_is_said_what_the_planner_knows(tmp_path, make_lines, suite):
    lines = make_lines(3, ("clutter",), ("none", "late"), ("cavalcade",))
    write_report(tmp_path, suite, lines, pictures=False)
    assert "**Disturbances** are known" in pages(tmp_path)[0]
