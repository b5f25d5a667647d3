from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cavalcade.jobs.reporter import JobReporter, result_rows
from cavalcade.jobs.share import ShareDone
from cavalcade.recording import Frame
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import load_scenario


def frame(time: float, *notes: str) -> Frame:
    nothing: Any = None
    status: Any = SimpleNamespace(state="partial", goal=None, eta=np.zeros(0))
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
        reporter.complete()
        reporter.finish(SUMMARY, [])
    said = capsys.readouterr().out
    assert "crossing" in said
    assert "stuck (robots 1 and 2)" in said


def test_a_bar_ended_at_20_percent(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs end long before their time limit, and then their bar is full."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    wall = 0.0
    with JobReporter("cone", now=lambda: wall) as reporter:
        reporter.expect(load_scenario("cone"))
        for k in range(201):
            reporter(on_the_way(k / 200, time=k / 10))
            wall += 0.05
            if k == 100:
                assert reporter._bar is not None
                reporter._bar.refresh()
        halfway = capsys.readouterr().out
        reporter.complete()
    assert "50 %, 10.0 s simulated, partial, 5 s left" in halfway
    assert "100 %, 20.0 s simulated, partial" in capsys.readouterr().out


def on_the_way(share: float, time: float) -> Frame:
    """Of a team that follows its leader's path, 8 m long, to the only goal of `cone`."""
    goal = np.array(load_scenario("cone").task.goals[0], dtype=float)
    start = goal[:2] - (8.0, 0.0)
    poses = np.tile([*(start + (8.0 * share, 0.0)), 0.0], (2, 1))
    ahead = np.linspace(poses[0, :2], goal[:2], 20)
    status = PlannerStatus(
        state="partial",
        leader=0,
        roles=np.array([0, 1]),
        goals=poses[:, :2] + (1.0, 0.0),
        goal=goal,
        paths=(ahead, np.zeros((0, 2))),
        eta=np.full(2, np.inf),
    )
    return Frame(time, poses, poses, np.zeros((2, 3)), status)


@pytest.mark.parametrize("limit", [20.0, 90.0, 86_400.0])
def test_the_share_of_a_formation_is_that_of_its_way(limit: float) -> None:
    share = ShareDone(limit, load_scenario("cone").task.goals)
    for k in range(201):
        said = share(on_the_way(k / 200, time=k / 10))
        assert said == pytest.approx(k / 200, abs=0.01)
    assert said == 1.0


def test_goals_to_come_count() -> None:
    goal = np.array(load_scenario("cone").task.goals[0], dtype=float)
    share = ShareDone(1000.0, [goal, goal + (0.0, 8.0, 0.0)])
    said = [share(on_the_way(k / 200, time=k / 10)) for k in range(201)]
    assert said[100] == pytest.approx(0.25, abs=0.01)
    assert said[200] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("left", [[3.0, 6.0], [0.0, 6.0]])
def test_plans_and_commands_say_how_long_they_take(left: list[float]) -> None:
    def at(time: float) -> Frame:
        eta = np.maximum(np.array(left) - time, 0.0)
        status = replace(on_the_way(0.0, 0.0).status, goal=None, eta=eta, state="final")
        return replace(on_the_way(0.0, 0.0), time=time, status=status)

    share = ShareDone(180.0)
    assert [share(at(time)) for time in (0.0, 1.5, 3.0, 6.0)] == [0.0, 0.25, 0.5, 1.0]


def test_a_share_never_falls_and_a_run_that_stands_goes_towards_its_limit() -> None:
    share = ShareDone(100.0, load_scenario("cone").task.goals)
    said = [share(on_the_way(0.4 if k < 50 else 0.2, time=float(k))) for k in range(101)]
    assert all(a <= b for a, b in pairwise(said))
    assert said[-1] == 1.0
    nothing = replace(on_the_way(0.0, 0.0).status, goal=None, state="inactive")
    share = ShareDone(100.0)
    assert share(replace(on_the_way(0.0, 25.0), status=nothing)) == 0.25


def test_the_table_shows_what_is_known(capsys: pytest.CaptureFixture[str]) -> None:
    with JobReporter("a") as reporter:
        reporter.finish(SUMMARY, [Path("runs") / "a" / "summary.json"])
    said = capsys.readouterr().out
    assert "0.31 m (centre)" in said
    assert said.rstrip().endswith(str(Path("runs") / "a" / "summary.json"))
    rows = dict(result_rows(SUMMARY))
    assert rows["all in place after"] == "–"
    assert rows["collisions"] == "1 between robots, 0 with obstacles"
