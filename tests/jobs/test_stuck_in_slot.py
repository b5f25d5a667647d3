"""A robot drove nose first into an alley too narrow to turn in, where it is to look back."""

from __future__ import annotations

import math

from cavalcade.jobs import JobResult, run
from cavalcade.scenario import parse_scenario


def alley(yaw: float, variant: str) -> JobResult:
    """One robot drives into a dead end 0.7 m wide, 0.9 m deep at its slot."""
    walls = [
        {"box": {"center": [4.5, 3.0 + side * 0.5], "size": [3.0, 0.3]}} for side in (1.0, -1.0)
    ]
    data = {
        "version": 1,
        "name": "alley",
        "world": {"empty": {"size": [6, 6]}, "obstacles": walls},
        "robots": [{"model": "go1", "start": [1.0, 3.0, 0.0]}],
        "task": {"formation": {"shape": "line", "spacing": 1.0}, "goals": [[3.9, 3.0, yaw]]},
        "planner": {"variant": variant},
        "execution": {"timeout": 40},
    }
    return run(parse_scenario(data))


def test_it_turns_outside_and_backs_in() -> None:
    result = alley(math.pi, "cavalcade")
    assert result.reason == "arrived"
    assert result.summary["min_footprint_gap_m"] > 0.0


def test_without_that_it_stays_stuck() -> None:
    assert alley(math.pi, "cavalcade-no-recovery").reason == "timeout"


def test_one_that_looks_the_right_way_takes_no_detour() -> None:
    result = alley(0.0, "cavalcade")
    assert result.reason == "arrived"
    assert result.recording.poses[:, 0, 0].max() < 3.95
    assert result.summary["sim_time_s"] < 12.0
