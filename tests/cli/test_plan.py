from __future__ import annotations

import json

import pytest

from cavalcade.cli import main

SHUT_OFF = """
version: 1
name: shut-off
world:
  empty: {size: [8, 4]}
  obstacles: [{box: {center: [4, 2], size: [0.4, 4]}}]
robots: [{model: spirit, start: [1, 2, 0], goal: [7, 2, 0]}]
task: {goals: individual}
"""


def test_a_plan_is_made(tmp_path, capsys):
    out = tmp_path / "plan"
    assert main(["plan", "head-on", "--out", str(out), "--method", "cbs", "--seed", "2"]) == 0
    said = capsys.readouterr()
    assert "solved" in said.out
    assert str(out / "replay.html") in said.out
    assert said.err == ""
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["method"], summary["seed"]) == ("cbs", 2)
    assert main(["check", str(out)]) == 0


def test_json_is_the_summary_and_nothing_else(tmp_path, capsys):
    out = tmp_path / "plan"
    assert main(["plan", "head-on", "--out", str(out), "--json", "--quiet"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads((out / "summary.json").read_text())


def test_no_plan_is_exit_code_1_with_the_reason_in_one_line(tmp_path, capsys):
    file = tmp_path / "shut-off.yaml"
    file.write_text(SHUT_OFF)
    assert main(["plan", str(file), "--out", str(tmp_path / "p"), "--quiet"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("cavalcade: shut-off: no plan: infeasible (")
    assert said.err.count("\n") == 1
    assert json.loads((tmp_path / "p" / "summary.json").read_text())["success"] is False


def test_a_run_without_a_plan_ends_with_its_reason(tmp_path, capsys):
    file = tmp_path / "shut-off.yaml"
    file.write_text(SHUT_OFF)
    assert main(["run", str(file), "--out", str(tmp_path / "r"), "--quiet"]) == 1
    assert capsys.readouterr().err.startswith("cavalcade: shut-off: not achieved: infeasible (")
    summary = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert summary["reason"] == "infeasible"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["square-clutter"], "task.goals: plan is for robots with goals of their own"),
        (["head-on", "--method", "magic"], "unknown method 'magic'"),
        (["head-on", "--set", "planner.method=formation"], "formation"),
        (["no-such-thing"], "no-such-thing"),
    ],
)
def test_bad_input_is_exit_code_2_and_one_line(tmp_path, capsys, words, said):
    assert main(["plan", *words, "--out", str(tmp_path / "p")]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not (tmp_path / "p").exists()
