from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cavalcade.execution.arrival import (
    IDEAL,
    PHYSICS,
    ArrivalMonitor,
    ArrivalTolerance,
    slot_poses,
    tolerance_of,
)

SLOTS = np.array([(0.5, 0.0), (-0.5, 0.0)])
GOAL = np.array([3.0, 2.0, np.pi / 2])
THERE = np.array([(3.0, 2.5, np.pi / 2), (3.0, 1.5, np.pi / 2)])
STILL = np.zeros((2, 3))


@pytest.fixture
def status(straight: Any, make_scenario: Any) -> Any:
    planner = straight(make_scenario(robots=2), None)
    return replace(planner.status, slots=SLOTS, goal=GOAL, roles=np.array([0, 1]), waypoint=1)


def arrived_after(monitor: ArrivalMonitor, poses: Any, velocities: Any, status: Any) -> float:
    """Seconds until the monitor agrees; inf if it does not within five."""
    for k in range(101):
        if monitor.update(0.05 * k, poses, velocities, status, 1):
            return 0.05 * k
    return np.inf


def test_slots_turn_with_the_goal(status: Any) -> None:
    assert slot_poses(status) == pytest.approx(THERE)
    exchanged = replace(status, roles=np.array([1, 0]))
    assert slot_poses(exchanged) == pytest.approx(THERE[::-1])
    assert slot_poses(replace(status, goal=None)) is None


def test_in_place_for_half_a_second(status: Any) -> None:
    assert arrived_after(ArrivalMonitor(), THERE, STILL, status) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("off", "speed", "arrives"),
    [
        ((0.099, 0.0, 0.0), 0.0, True),
        ((0.0, 0.101, 0.0), 0.0, False),
        ((0.08, 0.08, 0.0), 0.0, False),
        ((0.0, 0.0, 0.149), 0.0, True),
        ((0.0, 0.0, -0.151), 0.0, False),
        ((0.0, 0.0, 2 * np.pi), 0.0, True),
        ((0.0, 0.0, 0.0), 0.019, True),
        ((0.0, 0.0, 0.0), 0.02, False),
    ],
)
def test_the_tolerances(
    status: Any, off: tuple[float, float, float], speed: float, arrives: bool
) -> None:
    poses, velocities = THERE.copy(), STILL.copy()
    poses[1] += off
    velocities[1, 1] = speed
    assert np.isfinite(arrived_after(ArrivalMonitor(), poses, velocities, status)) == arrives


def test_a_moment_outside_starts_the_wait_anew(status: Any) -> None:
    monitor = ArrivalMonitor()
    assert not monitor.update(0.0, THERE, STILL, status, 1)
    assert not monitor.update(0.4, THERE + np.array((1.0, 0.0, 0.0)), STILL, status, 1)
    assert not monitor.update(0.5, THERE, STILL, status, 1)
    assert not monitor.update(0.95, THERE, STILL, status, 1)
    assert monitor.update(1.0, THERE, STILL, status, 1)


def test_only_the_last_goal_counts(status: Any) -> None:
    first = replace(status, waypoint=0)
    assert arrived_after(ArrivalMonitor(), THERE, STILL, first) == np.inf


def test_a_planner_that_forgets_its_goal_on_arrival(status: Any) -> None:
    monitor = ArrivalMonitor()
    monitor.update(0.0, THERE, STILL, status, 1)
    idle = replace(status, goal=None, state="inactive", arrived=True)
    assert monitor.update(0.5, THERE, STILL, idle, 1)


def test_before_any_goal_nobody_has_arrived(status: Any) -> None:
    monitor = ArrivalMonitor()
    assert not monitor.update(0.0, THERE, STILL, replace(status, goal=None), 0)


def test_a_robot_without_a_slot_is_not_waited_for(status: Any) -> None:
    lost = replace(status, roles=np.array([0, -1]))
    poses = THERE + np.array([(0.0, 0.0, 0.0), (2.0, 2.0, 1.0)])
    assert np.isfinite(arrived_after(ArrivalMonitor(), poses, STILL, lost))
    nobody = replace(status, roles=np.array([-1, -1]))
    assert arrived_after(ArrivalMonitor(), poses, STILL, nobody) == np.inf


def swaying(size: float, drift: float = 0.0, period: float = 0.4) -> Any:
    """Poses over time of robots that sway sideways, m, and drift, m/s."""

    def poses(time: float) -> np.ndarray:
        off = size * np.sin(2.0 * np.pi * time / period) + drift * time
        return THERE + np.array([(0.0, 0.0, 0.0), (off, 0.0, 0.0)])

    return poses


def arrived_on_the_way(tolerance: ArrivalTolerance, poses: Any, status: Any) -> float:
    """Seconds until robots at `poses(time)` have arrived; inf if they have not within five."""
    monitor = ArrivalMonitor(tolerance)
    for k in range(101):
        time = 0.05 * k
        speed = (poses(time + 1e-4) - poses(time - 1e-4)) / 2e-4
        if monitor.update(time, poses(time), speed, status, 1):
            return time
    return np.inf


def test_a_trunk_that_sways_in_place_has_arrived_in_physics(status: Any) -> None:
    assert arrived_on_the_way(PHYSICS, swaying(0.005), status) < 1.0
    assert arrived_on_the_way(IDEAL, swaying(0.005), status) == np.inf


@pytest.mark.parametrize(("drift", "arrives"), [(0.03, True), (0.06, False)])
def test_one_that_moves_on_has_not(status: Any, drift: float, arrives: bool) -> None:
    """Twice as far off as its drift takes it in half a second, it is still near enough."""
    near = swaying(0.0, drift)
    slow = arrived_on_the_way(PHYSICS, lambda time: near(time - 2.0), status)
    assert np.isfinite(slow) == arrives


@pytest.mark.parametrize(
    ("off", "arrives"),
    [
        ((0.149, 0.0, 0.0), True),
        ((0.151, 0.0, 0.0), False),
        ((0.0, 0.0, 0.199), True),
        ((0.0, 0.0, 0.201), False),
    ],
)
def test_the_tolerances_of_physics(status: Any, off: tuple[float, ...], arrives: bool) -> None:
    there = THERE + np.array([(0.0, 0.0, 0.0), off])
    after = arrived_on_the_way(PHYSICS, lambda time: there, status)
    assert after == pytest.approx(0.5) if arrives else after == np.inf


def test_the_backend_says_which_tolerances_hold(make_scenario: Any) -> None:
    assert tolerance_of(make_scenario()) == IDEAL
    assert tolerance_of(make_scenario(backend="mujoco")) == PHYSICS
    assert (PHYSICS.position, PHYSICS.heading, PHYSICS.speed) == (0.15, 0.2, 0.05)
