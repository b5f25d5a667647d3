"""Late and lost commands and noisy poses: the team arrives without touching anything."""

from __future__ import annotations

import math

import pytest

from cavalcade.execution.formation_policy import expected_of
from cavalcade.jobs.running import run
from cavalcade.scenario import load_scenario, parse_scenario

NOISE = {"position": 0.02, "heading": math.radians(1.0)}


def crossing(planner: dict, **execution: object) -> dict:
    """Two robots change sides of a square between obstacles."""
    return {
        "version": 1,
        "name": "crossing",
        "world": {
            "empty": {"size": [7, 4]},
            "obstacles": [
                {"circle": {"center": [3.5, 1.0], "radius": 0.3}},
                {"box": {"center": [3.6, 3.1], "size": [0.5, 0.9], "yaw": 0.4}},
            ],
        },
        "robots": [
            {"model": "go1", "start": [1.2, y, 0.0]} for y in (1.5, 2.5)
        ],
        "task": {
            "formation": {"shape": "line", "spacing": 0.9},
            "goals": [[5.8, 2.0, math.pi]],
        },
        "planner": planner,
        "execution": {"timeout": 60, **execution},
    }  # fmt: skip


@pytest.mark.parametrize("delay", [0.1, 0.3])
def test_a_team_arrives_through_noise_delay_and_loss(delay: float) -> None:
    data = crossing({}, noise=NOISE, delay={"mean": delay, "drop": 0.1})
    summary = run(parse_scenario(data)).summary
    assert summary["reason"] == "arrived"
    assert summary["min_footprint_gap_m"] > 0.02


def test_the_planner_is_told_what_its_robots_are_like_unless_the_file_says_otherwise() -> None:
    execution = {"noise": NOISE, "delay": {"mean": 0.2, "jitter": 0.01, "drop": 0.1}}
    told = expected_of(parse_scenario(crossing({}, **execution)))
    assert (told.position, told.heading) == (0.02, NOISE["heading"])
    assert (told.delay, told.jitter, told.drop) == (0.2, 0.01, 0.1)
    untold = {"expect": {"noise": {}, "delay": {"mean": 0.05}}}
    told = expected_of(parse_scenario(crossing(untold, **execution)))
    assert (told.position, told.heading, told.delay, told.drop) == (0.0, 0.0, 0.05, 0.0)
    assert expected_of(load_scenario("square-clutter")).none
