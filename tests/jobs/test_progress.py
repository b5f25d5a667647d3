from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from cavalcade.jobs.reporter import JobReporter, result_rows
from cavalcade.recording import Frame


def frame(time: float, *notes: str) -> Frame:
    nothing: Any = None
    status: Any = SimpleNamespace(state="partial")
    return Frame(time, nothing, nothing, nothing, status, notes=notes)


SUMMARY: dict[str, Any] = {
    "name": "a",
    "backend": "ideal",
    "robots": 4,
    "variant": "cavalcade",
    "reason": "stuck",
    "detail": "robots 1 and 2",
    "sim_time_s": 12.34,
    "makespan_s": None,
    "collisions": {"robot_robot": 1, "robot_obstacle": 0},
    "min_obstacle_distance_m": 0.31,
    "min_robot_distance_m": None,
    "min_footprint_gap_m": 0.05,
    "formation_error_m": {"mean": 0.1, "p95": 0.2, "max": 0.3},
    "leader_changes": 2,
    "role_changes": 3,
    "cycle_ms": {"p50": 1.5, "p99": 3.0, "max": 4.0},
    "wall_time_s": 5.0,
}


def test_plain_lines_every_ten_seconds_and_at_events(capsys: pytest.CaptureFixture[str]) -> None:
    with JobReporter("a [run]") as reporter:
        for k in range(251):
            note = "robot 1 [lost]" if k == 130 else ""
            reporter(frame(k / 10, *([note] if note else [])))
    lines = capsys.readouterr().out.splitlines()
    assert lines == ["  10.0 s  partial", "  13.0 s  robot 1 [lost]", "  20.0 s  partial"]


def test_quiet_is_quiet(capsys: pytest.CaptureFixture[str]) -> None:
    with JobReporter("a", quiet=True) as reporter:
        reporter(frame(20.0, "note"))
        reporter.say("hello")
        reporter.finish(SUMMARY, [Path("x")])
    assert capsys.readouterr() == ("", "")


def test_a_bar_on_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    with JobReporter("crossing") as reporter:
        for k in range(30):
            reporter(frame(k / 10))
        reporter.finish(SUMMARY, [])
    said = capsys.readouterr().out
    assert "crossing" in said
    assert "stuck (robots 1 and 2)" in said


def test_the_table_shows_what_is_known(capsys: pytest.CaptureFixture[str]) -> None:
    with JobReporter("a") as reporter:
        reporter.finish(SUMMARY, [Path("runs") / "a" / "summary.json"])
    said = capsys.readouterr().out
    assert "0.31 m (centre)" in said
    assert said.rstrip().endswith(str(Path("runs") / "a" / "summary.json"))
    rows = dict(result_rows(SUMMARY))
    assert rows["all in place after"] == "–"
    assert rows["collisions"] == "1 between robots, 0 with obstacles"
