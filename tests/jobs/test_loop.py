"""Whole runs, with a planner that drives straight on."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.fleet import IdealFleet
from cavalcade.jobs.running import run
from cavalcade.scenario import load_scenario

KEYS = {
    "name",
    "version",
    "seed",
    "method",
    "variant",
    "backend",
    "robots",
    "success",
    "reason",
    "sim_time_s",
    "wall_time_s",
    "makespan_s",
    "min_obstacle_distance_m",
    "min_robot_distance_m",
    "min_footprint_gap_m",
    "collisions",
    "falls",
    "formation_error_m",
    "leader_changes",
    "role_changes",
    "cycle_ms",
    "planning_time_s",
    "path_length_m",
    "lower_bound_m",
    "duration_s",
    "goal_error_m",
    "goal_moved_m",
    "versions",
}
FLEETING = ("wall_time_s", "planning_time_s", "cycle_ms", "versions")


def test_a_run_that_arrives(go: Callable[..., Any], tmp_path: Path) -> None:
    result = go(tmp_path / "r")
    assert result.success
    assert result.reason == "arrived"
    summary = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert summary == result.summary
    assert set(summary) >= KEYS
    assert summary["success"] is True
    assert summary["robots"] == 4
    assert summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 0}
    assert summary["falls"] == 0
    # 3 m at 0.5 m/s, and the last part slower.
    assert 6.0 < summary["makespan_s"] < summary["sim_time_s"] < 9.0
    assert summary["sim_time_s"] >= summary["makespan_s"] + 0.5
    assert summary["duration_s"] == [summary["makespan_s"]] * 4
    assert summary["path_length_m"] == pytest.approx([3.0] * 4, abs=0.02)
    assert summary["lower_bound_m"] == pytest.approx([3.0] * 4)
    assert max(summary["goal_error_m"]) < 0.02
    assert summary["goal_moved_m"] == 0.0
    assert summary["min_robot_distance_m"] == pytest.approx(1.0)
    assert summary["min_footprint_gap_m"] == pytest.approx(1.0 - 0.65)
    assert summary["min_obstacle_distance_m"] == pytest.approx(1.5)
    assert summary["formation_error_m"]["max"] < 1e-6
    assert summary["leader_changes"] == summary["role_changes"] == 0
    assert set(summary["versions"]) == {"cavalcade", "python", "numpy", "numba", "scipy"}
    assert sorted(file.name for file in (tmp_path / "r").iterdir()) == [
        "recording.mcap",
        "scenario.yaml",
        "summary.json",
    ]
    assert load_scenario(tmp_path / "r" / "scenario.yaml").name == "straight"


def test_the_last_command_is_zero_and_nothing_before(go: Callable[..., Any]) -> None:
    recording = go().recording
    assert np.array_equal(recording.commands[-1], np.zeros((4, 3)))
    assert np.any(recording.commands[0] != 0.0)
    assert np.allclose(np.diff(recording.time), 0.05)


def test_same_seed_same_summary(go: Callable[..., Any]) -> None:
    noisy = {"noise": {"position": 0.02, "heading": 0.02}, "delay": {"mean": 0.05, "drop": 0.1}}

    def figures(seed: int) -> dict[str, Any]:
        summary = go(seed=seed, **noisy).summary
        assert summary["seed"] == seed
        return {key: value for key, value in summary.items() if key not in FLEETING}

    assert figures(1) == figures(1)
    assert figures(1) != figures(2)


def test_time_runs_out(go: Callable[..., Any]) -> None:
    summary = go(timeout=2.0).summary
    assert (summary["reason"], summary["success"]) == ("timeout", False)
    assert summary["sim_time_s"] == pytest.approx(2.0)
    assert summary["makespan_s"] is None
    assert summary["duration_s"] == [None] * 4
    assert min(summary["goal_error_m"]) > 1.0


@pytest.mark.parametrize("budget", [{"iterations": 10}, {"seconds": 1e-9}])
def test_the_budget_runs_out(go: Callable[..., Any], budget: dict[str, float]) -> None:
    summary = go(planner={"budget": budget}).summary
    assert (summary["reason"], summary["success"]) == ("budget", False)
    assert summary["sim_time_s"] == pytest.approx(0.05 * (budget.get("iterations", 1) - 1))


@pytest.mark.parametrize("state", ["stuck", "infeasible"])
def test_a_planner_that_gives_up(go: Callable[..., Any], state: str) -> None:
    def change(planner: Any) -> None:
        step = planner.step

        def giving_up(poses: Any, time: float, stamps: Any) -> Any:
            commands = step(poses, time)
            if time >= 1.0:
                planner.status = replace(
                    planner.status, state=state, involved=(1, 2), message="robots 1 and 2 wait"
                )
                commands[:] = 0.0
            return commands

        planner.step = giving_up

    summary = go(change=change).summary
    assert (summary["reason"], summary["success"]) == (state, False)
    assert summary["detail"] == "robots 1 and 2 wait"
    assert summary["involved"] == [1, 2]
    assert summary["sim_time_s"] == pytest.approx(1.0)


def test_a_task_that_cannot_be_done_at_all(go: Callable[..., Any], tmp_path: Path) -> None:
    def change(planner: Any) -> None:
        planner.status = replace(
            planner.status, state="infeasible", roles=np.full(4, -1), message="no way"
        )
        planner.step = lambda poses, time, stamps: np.zeros((4, 3))

    summary = go(tmp_path / "r", change=change).summary
    assert (summary["reason"], summary["success"]) == ("infeasible", False)
    assert summary["sim_time_s"] == 0.0
    for key in ("lower_bound_m", "goal_error_m", "duration_s"):
        assert summary[key] == [None] * 4
    assert summary["goal_moved_m"] is None
    assert summary["formation_error_m"] == {"mean": None, "p95": None, "max": None}
    assert json.loads((tmp_path / "r" / "summary.json").read_text()) == summary


def test_giving_up_waits_for_what_may_still_change(go: Callable[..., Any]) -> None:
    def change(planner: Any) -> None:
        step = planner.step

        def until_changed(poses: Any, time: float, stamps: Any) -> Any:
            commands = step(poses, time)
            if not planner.called("update_map"):
                planner.status = replace(planner.status, state="stuck")
                commands[:] = 0.0
            return commands

        planner.step = until_changed

    obstacle = {"circle": {"center": [7.0, 1.0], "radius": 0.2}}
    assert go(change=change, events=[{"at": 2.0, "add": obstacle}]).reason == "arrived"


def test_a_collision_is_counted_and_ends_in_no_success(go: Callable[..., Any]) -> None:
    obstacle = {"circle": {"center": [3.5, 3.5], "radius": 0.2}}
    summary = go(world={"obstacles": [obstacle]}).summary
    assert (summary["reason"], summary["success"]) == ("collision", False)
    # Robots 0 and 1 come by one after the other.
    assert summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 2}
    assert summary["min_footprint_gap_m"] == 0.0
    assert summary["sim_time_s"] > 6.0


def test_a_robot_that_falls_silent_stops_the_run(go: Callable[..., Any]) -> None:
    class Failing(IdealFleet):
        def advance(self, dt: float) -> None:
            super().advance(dt)
            if self.time >= 2.0:
                self.silence(3)

    result = go(fleet=lambda scenario: Failing(scenario.models, scenario.starts))
    summary = result.summary
    assert (summary["reason"], summary["success"]) == ("stopped", False)
    assert summary["detail"] == "watchdog: stale: robot 3 (0.55 s old)"
    assert summary["involved"] == [3]
    assert summary["sim_time_s"] < 4.0
    assert any("stale: robot 3" in text for _, text in result.recording.notes)
    last = np.diff(result.recording.poses[-2:], axis=0)
    assert np.abs(last[..., :2]).max() < 0.002


def test_events_of_the_task_are_waited_for(go: Callable[..., Any]) -> None:
    result = go(events=[{"at": 12.0, "goals": [[2.0, 3.0, 0.0]]}], timeout=40)
    assert result.reason == "arrived"
    assert result.summary["sim_time_s"] > 18.0
    assert result.recording.poses[-1, 0, 0] == pytest.approx(2.5, abs=0.1)
    assert (12.0, "new goal") in result.recording.notes


def test_a_lost_robot_is_not_waited_for(go: Callable[..., Any]) -> None:
    result = go(events=[{"at": 2.0, "lose": 2}])
    summary = result.summary
    assert summary["reason"] == "arrived"
    assert summary["duration_s"][2] is None
    assert summary["goal_error_m"][2] is None
    assert summary["makespan_s"] == max(summary["duration_s"][k] for k in (0, 1, 3))
    assert result.recording.roles[-1].tolist() == [0, 1, -1, 3]


def test_a_moving_obstacle_reaches_the_recording(go: Callable[..., Any], tmp_path: Path) -> None:
    move = {"circle": {"center": [1.0, 1.0], "radius": 0.2}, "to": [4.0, 1.0], "speed": 0.5}
    result = go(tmp_path / "r", events=[{"at": 1.0, "move": move}])
    (track,) = result.recording.obstacles
    assert track.time.tolist() == [1.0, 7.0]
    # The lower robots go at y = 2.5 m, so they are never nearer than 1.3 m to its surface.
    assert 1.3 <= result.summary["min_obstacle_distance_m"] < 1.4


def test_waypoints_lengthen_the_lower_bound(go: Callable[..., Any]) -> None:
    result = go(events=[{"at": 0.0, "goals": [[5, 3, 0], [2, 3, 0]]}], timeout=60)
    assert result.reason == "arrived"
    assert result.summary["lower_bound_m"] == pytest.approx([6.0] * 4, abs=0.01)


def test_no_way_at_all_leaves_the_bound_open(go: Callable[..., Any]) -> None:
    wall = {"box": {"center": [4.0, 3.0], "size": [0.2, 6.0]}}
    summary = go(world={"obstacles": [wall]}, timeout=1.0).summary
    assert summary["lower_bound_m"] == [None] * 4


def test_wall_time_is_kept(go: Callable[..., Any], make_scenario: Any, straight: Any) -> None:
    result = run(make_scenario(timeout=0.5), planner=straight, realtime=True)
    assert 0.45 < result.summary["wall_time_s"] < 1.5


def test_the_loop_itself_takes_little_time(go: Callable[..., Any]) -> None:
    """All but the planner: below a millisecond per cycle for four robots."""
    best = math.inf
    for _ in range(3):
        result = go()
        spent = result.summary["wall_time_s"] - result.summary["planning_time_s"]
        best = min(best, spent / len(result.recording.time))
    assert best < 1e-3


def test_one_robot_alone(go: Callable[..., Any]) -> None:
    summary = go(robots=1).summary
    assert summary["reason"] == "arrived"
    assert summary["min_robot_distance_m"] is None
    assert summary["formation_error_m"] == {"mean": 0.0, "p95": 0.0, "max": 0.0}
