"""What is remembered of stuck robots, and for how long."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.formation import Formation, FormationPlanner
from cavalcade.formation.stuck_recovery import StuckRecovery
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

ROOM = OccupancyMap.empty((8.0, 5.0), 0.05)
ONE = Formation.line(1, 1.0)
GOAL = (4.0, 2.5, math.pi)


@pytest.fixture
def at(tools):
    """Whether a watch sends a robot that stands across its slot away, at some time."""
    watch = StuckRecovery(robot_model("go1"))

    def update(time: float) -> dict[int, np.ndarray]:
        cycle = tools.cycle_of(ROOM, ONE, [[4.0, 2.5, 0.0]], GOAL, time)
        cycle.final, cycle.roles, cycle.away = True, np.zeros(1, int), np.zeros(1)
        watch.update(cycle)
        return cycle.detours

    update.watch = watch
    return update


def test_patience_lasts_two_seconds(at):
    assert not any(at(time) for time in (0.0, 1.0, 1.9))
    assert at(2.1)


def test_time_without_cycles_counts_for_nothing(at):
    assert not at(0.0)
    assert not at(1.0)
    at.watch.go_on()
    assert not at(61.0)
    assert not at(61.9)
    assert at(62.1)
    at.watch.go_on()
    assert at(100.0)
    assert at(109.0)


def test_a_map_in_another_frame_makes_it_forget(monkeypatch):
    restarts = []
    restart = StuckRecovery.restart
    monkeypatch.setattr(
        StuckRecovery, "restart", lambda self: (restarts.append(self), restart(self))
    )
    planner = FormationPlanner(ROOM, ONE)
    planner.set_goal((1.0, 1.0, 0.0))
    planner.step([[1.0, 1.0, math.pi]], 0.0)
    restarts.clear()
    planner.update_map(OccupancyMap(ROOM.grid, 0.05, (-0.2, 0.0, 0.0)))
    assert len(restarts) == 1
    planner.step([[1.0, 1.0, math.pi]], 0.05)
    assert planner.status.goal == pytest.approx([1.0, 1.0, 0.0])
