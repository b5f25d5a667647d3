"""Regression: an obstacle that an event adds at 0 s did not exist for the run."""

from __future__ import annotations

import pytest

from cavalcade.jobs.running import run
from cavalcade.scenario import parse_scenario


@pytest.mark.parametrize("at", [0.0, 0.01])
def test_a_wall_that_is_there_from_the_first_moment_bars_the_way(at: float) -> None:
    scenario = parse_scenario(
        {
            "version": 1,
            "name": "walled",
            "world": {"empty": {"size": [8, 4]}},
            "robots": [{"model": "go1", "start": [1.5, 2.0, 0.0]}],
            "task": {"formation": {"shape": "column", "spacing": 1.0}, "goals": [[6.5, 2.0, 0.0]]},
            "execution": {
                "timeout": 20,
                "events": [{"at": at, "add": {"box": {"center": [4, 2], "size": [0.2, 4]}}}],
            },
        }
    )
    result = run(scenario)
    assert not result.success
    assert result.reason == "infeasible"
    assert result.summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 0}
