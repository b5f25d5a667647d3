"""`cavalcade campaign` and `cavalcade trial` as a user meets them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cavalcade.cli import main

_SCENARIO = """\
version: 1
name: short
world: {empty: {size: [6, 4]}}
robots:
  - {model: go1, start: [1.0, 2.5, 0.0]}
  - {model: go1, start: [1.0, 1.5, 0.0]}
task:
  formation: {shape: line, spacing: 1.0}
  goals: [[2.5, 2.0, 0.0]]
"""

_SUITE = """\
version: 1
suite: tiny
about: Two robots go one and a half metres.
worlds:
  - {name: short, sampler: shipped, scenario: SCENARIO, seeds: 2}
  - {name: late, sampler: shipped, scenario: LATE, seeds: 1}
"""


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    scenario, late, path = (tmp_path / name for name in ("short.yaml", "late.yaml", "tiny.yaml"))
    scenario.write_text(_SCENARIO, encoding="utf-8")
    late.write_text(_SCENARIO + "execution: {timeout: 1.0}\n", encoding="utf-8")
    path.write_text(
        _SUITE.replace("SCENARIO", str(scenario)).replace("LATE", str(late)), encoding="utf-8"
    )
    return path


def _command(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "cavalcade", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )


def _refused(arguments: list[object], capsys: pytest.CaptureFixture[str]) -> str:
    assert main([str(word) for word in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("cavalcade: ")
    assert err.count("\n") == 1
    return err


def test_a_campaign_then_its_trials(
    suite: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "runs" / "a"
    # In a process of its own, and with one more for a worker.
    # Failures are what a campaign is for: its exit code is 0 whatever the rates.
    done = _command("campaign", suite, "--out", out, "--workers", 1)
    assert (done.returncode, done.stderr) == (0, "")
    assert "tiny: 3 trials" in done.stdout
    assert "outcomes: 2 arrived, 1 timeout" in done.stdout
    there = set(os.listdir(out))
    assert there >= {"campaign.json", "trials.jsonl", "trials.parquet", "report.md", "report.html"}
    lines = [json.loads(line) for line in (out / "trials.jsonl").read_text().splitlines()]
    assert {line["trial"]: line["success"] for line in lines} == {
        "short.0000.cavalcade": True,
        "short.0001.cavalcade": True,
        "late.0000.cavalcade": False,
    }
    assert "--resume" in _refused(["campaign", suite, "--out", out], capsys)

    assert main(["campaign", str(suite), "--out", str(out), "--resume", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["trials"], said["success"]) == (3, 2)
    assert str(out / "report.md") in said["files"]

    again = tmp_path / "again"
    assert main(["trial", str(out), "short.0001.cavalcade", "--out", str(again)]) == 0
    said_by_trial = capsys.readouterr()
    assert said_by_trial.err == ""
    assert said_by_trial.out.endswith(
        "short.0001.cavalcade: arrived, clean; the same as in the campaign\n"
    )
    assert {"recording.mcap", "replay.html", "figures"} <= set(os.listdir(again))
    assert main(["check", str(again), "--quiet"]) == 0

    over = ["trial", out, "short.0001.cavalcade", "--out", out, "--force"]
    assert "holds the campaign itself" in _refused(over, capsys)
    assert set(os.listdir(out)) == there

    late = ["trial", str(out), "late.0000.cavalcade", "--out", str(tmp_path / "late"), "--json"]
    assert main(late) == 1
    out_text, err = capsys.readouterr()
    assert json.loads(out_text)["outcome"] == "timeout"
    assert err == "cavalcade: late.0000.cavalcade: not achieved: timeout (1 s are over)\n"

    said_of_id = _refused(["trial", out, "shirt.0001.cavalcade", "--out", tmp_path / "x"], capsys)
    assert "no such trial: 'shirt.0001.cavalcade'; did you mean short.0001.cavalcade" in said_of_id
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["cluter"], "cluter: no such file or shipped suite; did you mean clutter?"),
        (["clutter", "--engine", "rey"], "--engine: unknown engine 'rey'; did you mean ray?"),
        (["clutter", "--workers", "0"], "--workers: expected a whole number from 1 on"),
        (["clutter", "--seed", "-1"], "--seed: expected a whole number from 0 to"),
        (["clutter", "--seeds", "0"], "--seeds: expected a whole number from 1 to"),
        (["clutter", "--set", "planner.variant=publisht"], "did you mean published?"),
        (["clutter", "--set", "planner.lookahed=1"], "--set planner.lookahed: unknown key"),
        (["clutter", "--set", "planner"], "expected KEY=VALUE"),
        (["clutter", "--backend", "gazebo"], "execution.backend"),
        (["clutter", "--data", "nowhere"], "no such folder: nowhere"),
        (["clutter", "--wokers", "2"], "No such option"),
    ],
)
def test_bad_input_before_anything_is_done(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "runs" / "a"
    assert message in _refused(["campaign", *words, "--out", out], capsys)
    assert os.listdir(tmp_path) == []


def test_a_bad_suite_file(suite: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    suite.write_text(suite.read_text().replace("about:", "abuot:"))
    said = _refused(["campaign", suite, "--out", tmp_path / "a"], capsys)
    assert "tiny.yaml: abuot: unknown key; did you mean about?" in said
    assert not (tmp_path / "a").exists()


def test_absent_data_is_one_line_and_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CAVALCADE_DATA", raising=False)
    out = tmp_path / "a"
    (tmp_path / "empty").mkdir()
    words = ["campaign", "barn", "--out", str(out), "--data", str(tmp_path / "empty")]
    assert main(words) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("cavalcade: barn: ")
    assert said.err.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    "words", [["physics-walk"], ["clutter", "--backend", "mujoco"]], ids=["suite", "backend"]
)
def test_absent_mujoco_is_one_line_and_one(
    words: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    out = tmp_path / "a"
    assert main(["campaign", *words, "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"cavalcade: {words[0]}: ")
    assert "pip install 'cavalcade[physics]'" in said.err
    assert said.err.count("\n") == 1
    assert not out.exists()


def test_a_trial_that_was_lost_in_the_campaign(
    suite: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from cavalcade.campaign.definition import define_campaign
    from cavalcade.campaign.store import Store
    from cavalcade.campaign.trial import failure_line

    definition = define_campaign(suite)
    with Store(tmp_path / "c", definition) as store:
        store.append(failure_line(definition.trials[0], "overtime", "not done within 120 s"))
    words = ["trial", tmp_path / "c", definition.trials[0].id, "--out", tmp_path / "t", "--quiet"]
    assert main([str(word) for word in words]) == 0
    assert capsys.readouterr().err == (
        "cavalcade: warning: not as in the campaign: there it was overtime: not done within 120 s\n"
    )


@pytest.mark.parametrize("what", ["missing", "empty", "broken", "nonsense"])
def test_a_trial_of_no_campaign(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "c"
    if what != "missing":
        folder.mkdir()
    if what == "broken":
        (folder / "campaign.json").write_text('{"suite": {}}')
    if what == "nonsense":
        said = {"suite": "abc", "overrides": [], "version": "1", "data": None}
        (folder / "campaign.json").write_text(json.dumps(said))
    line = _refused(["trial", folder, "a.0000.cavalcade", "--out", tmp_path / "t"], capsys)
    assert "campaign" in line
    assert not (tmp_path / "t").exists()


def test_campaigns_do_not_slow_the_other_commands() -> None:
    code = (
        "import sys; from cavalcade.cli import commands; "
        "heavy = {'pebble', 'ray', 'duckdb', 'numba', 'numpy', 'cavalcade.campaign.definition'}; "
        "print(heavy & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout == "set()\n"
