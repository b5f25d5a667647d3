"""Robots were stuck between the pillars and the slanting walls of a small arena.

In one trial a robot could not turn in its slot, in the others one could not turn on its way.
"""

from __future__ import annotations

import pytest

from cavalcade.jobs.running import run
from cavalcade.scenario import parse_scenario

ALONE = [[-1.325, 1.625, 0.2574]]
NORTH = [[0.76978, 1.633759, -0.1143], [-0.025, 1.725, -0.1143], [-0.81978, 1.816241, -0.1143]]
SOUTH = [[0.774706, -1.753323, 0.0271], [-0.025, -1.775, 0.0271], [-0.824706, -1.796677, 0.0271]]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("starts", "goal"),
    [
        (SOUTH, [-0.425, 1.625, -0.0206]),
        (ALONE, [-0.775, -2.125, -2.3548]),
        (NORTH, [-1.625, -1.025, 2.3024]),
    ],
)
def test_they_turn_where_there_is_room(shared_data, starts, goal) -> None:
    shape = {"shape": "column", "spacing": 0.8} if len(starts) > 1 else {"shape": "line"}
    data = {
        "version": 1,
        "name": "pillars",
        "world": {"map": str(shared_data("ros_maps/nav2/tb3_sandbox.yaml"))},
        "robots": [{"model": "go1", "start": start} for start in starts],
        "task": {"formation": {"spacing": 1.0, **shape}, "goals": [goal]},
        "execution": {"timeout": 100},
    }
    result = run(parse_scenario(data))
    assert result.reason == "arrived"
    assert result.summary["min_footprint_gap_m"] > 0.0
