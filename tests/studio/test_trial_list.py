"""A campaign's trials: read, filtered and sorted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from cavalcade.campaign.table import read_table, write_table
from cavalcade.errors import InputError
from cavalcade.studio.study.trial_list import TrialList, outcomes

LINES: list[dict[str, Any]] = [
    {
        "trial": f"crowd.{seed:04d}.{variant}",
        "suite": "s",
        "scenario": "crowd",
        "variant": variant,
        "disturbance": "none",
        "seed": seed,
        "outcome": outcome,
        "success": outcome == "arrived",
        "feasible": True,
        "contacts": 0,
        "avoidable": 0,
        "detail": "",
        "violations": [],
        "measured": {},
        "summary": None if makespan is None else {"makespan_s": makespan, "robots": 4},
    }
    for seed, variant, outcome, makespan in (
        (0, "cavalcade", "arrived", 30.5),
        (0, "published", "collision", 41.0),
        (1, "cavalcade", "arrived", 28.0),
        (1, "published", "stuck", None),
        (10, "cavalcade", "arrived", 99.0),
    )
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    text = "".join(json.dumps(line) + "\n" for line in LINES)
    (tmp_path / "trials.jsonl").write_text(
        text + "not a line\n" + '{"trial": 3}\n' + '{"trial": "t'
    )
    return tmp_path


def names(trials: TrialList, *wanted: Any) -> list[str]:
    return [row["trial"].removeprefix("crowd.") for row in trials.chosen(*wanted)]


def test_lines_that_are_whole_are_listed_while_it_goes_on(folder: Path) -> None:
    trials = TrialList(folder)
    assert len(trials.rows) == len(LINES)
    assert {"trial", "outcome", "makespan_s", "variant", "seed"} <= set(trials.columns)
    assert "violations" not in trials.columns
    assert outcomes(trials.rows) == "3 arrived, 1 collision, 1 stuck"


def test_a_table_alone_is_the_same(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    other = tmp_path_factory.mktemp("seed=3")  # a folder whose name looks like a partition
    write_table(other, LINES)
    assert read_table(other)[1] == read_table(folder)[1]
    assert names(TrialList(other)) == names(TrialList(folder))


@pytest.mark.parametrize(
    ("wanted", "count"),
    [
        ("", 5),
        ("published", 2),
        ("CROWD", 5),
        ("outcome=arrived", 3),
        ("outcome!=arrived", 2),
        ("variant=published outcome=stuck", 1),
        ("makespan_s>30.5", 2),
        ("makespan_s>=30.5", 3),
        ("seed=1", 2),
        ("seed<=1 arrived", 2),
        ("success=true", 3),
        ("nothing-like-that", 0),
    ],
)
def test_words_and_conditions(folder: Path, wanted: str, count: int) -> None:
    assert len(TrialList(folder).chosen(wanted)) == count


def test_order_with_what_is_unknown_last(folder: Path) -> None:
    trials = TrialList(folder)
    rising = names(trials, "", "makespan_s")
    assert rising[:2] == ["0001.cavalcade", "0000.cavalcade"]
    assert rising[-1] == "0001.published"
    falling = names(trials, "", "makespan_s", True)
    assert falling == [*rising[3::-1], "0001.published"]


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ("makespan=3", "did you mean makespan_s"),
        ("makespan_s>soon", "expected a number"),
        ("makespan_s>nan", "expected a number"),
        ("outcome>arrived", "no number"),
    ],
)
def test_conditions_that_make_no_sense(folder: Path, wanted: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        TrialList(folder).chosen(wanted)


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" + bytes(40) + b"PAR1"])
def test_a_table_that_is_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "trials.parquet").write_bytes(content)
    with pytest.raises(InputError, match="parquet"):
        TrialList(tmp_path)


def test_a_campaign_that_has_just_begun_or_is_gone(tmp_path: Path) -> None:
    (tmp_path / "trials.jsonl").write_text("")
    assert TrialList(tmp_path).chosen() == []
    (tmp_path / "trials.jsonl").unlink()
    with pytest.raises(InputError, match=r"has neither trials\.jsonl nor trials\.parquet"):
        TrialList(tmp_path)
