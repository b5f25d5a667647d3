"""Robots that are located too long ago are stopped, and the team with them."""

from __future__ import annotations

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.fleet import CommandDelay, IdealFleet
from cavalcade.formation import VARIANTS
from cavalcade.formation.estimation import VelocityTracker
from cavalcade.robots import robot_model

GO1 = robot_model("go1")
PERIOD = 0.05
ROOM = cv.OccupancyMap.empty((8.0, 5.0), 0.05)
SQUARE = cv.Formation.square()
STARTS = np.column_stack([SQUARE.placed((1.5, 2.5, 0.0)), np.zeros(4)])


def planner_of(**values) -> cv.FormationPlanner:
    planner = cv.FormationPlanner(ROOM, SQUARE, **values)
    planner.set_goal((6.2, 2.5, 0.0))
    return planner


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("robot", [0, 2])
def test_a_robot_whose_stamps_stop_is_not_driven_on_blind(robot, delay):
    """With 10 % of slip bodies overlapped after 12 s, and the team "arrived"."""
    planner = planner_of(expected=cv.Imperfections(position=0.01, delay=delay))
    fleet = IdealFleet((GO1,) * 4, STARTS, delay=CommandDelay(delay))
    last: np.ndarray | None = None
    for cycle in range(400):
        seen = fleet.observe()
        poses, stamps = seen.poses.copy(), seen.stamps.copy()
        if cycle >= 60:
            last = seen.poses[robot].copy() if last is None else last
            poses[robot], stamps[robot] = last, 60 * PERIOD
        commands = planner.step(poses, seen.time, stamps)
        status = planner.status
        if cycle > 70:
            assert not commands.any()
            assert (status.state, status.involved) == ("stale", (robot,))
            assert f"robot {robot}" in status.message
            assert not status.arrived
        else:
            assert status.state != "stale"
        fleet.send(0.9 * commands)
        fleet.advance(PERIOD)
    assert np.abs(fleet.true_velocities()).max() < 1e-6
    # It is located again: on they go, and arrive.
    for _ in range(600):
        seen = fleet.observe()
        fleet.send(planner.step(seen.poses, seen.time, seen.stamps))
        fleet.advance(PERIOD)
        if planner.status.arrived:
            break
    assert planner.status.arrived


@pytest.mark.parametrize("slid", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("gap", [0.55, 3.0])
def test_a_robot_that_is_located_again_elsewhere_does_not_move_fast(slid, gap):
    """It seemed to drive at 3 m/s, and the safety filter kept the others off its path."""
    tracker = VelocityTracker(GO1, PERIOD)
    stamps, poses = np.zeros(4), STARTS.copy()
    for cycle in range(round(gap / PERIOD) + 6):
        now = cycle * PERIOD
        stamps = np.where(np.arange(4) == 1, 0.0, now)
        if now > gap - 1e-9:
            stamps[1], poses[1, 0] = now, STARTS[1, 0] + slid
        _, velocities = tracker.update(poses.copy(), now, stamps)
        tracker.commanded(np.zeros((4, 3)))
        assert np.abs(velocities).max() < 1e-9


@pytest.mark.parametrize("limit", [0.2, 0.5, 2.0])
@pytest.mark.parametrize(("beyond", "stopped"), [(-0.01, False), (0.0, False), (0.01, True)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_limit_of_the_age(limit, beyond, stopped, sign):
    planner = planner_of(expected=cv.Imperfections(position=0.01, max_age=limit))
    stamps = np.full(4, 100.0)
    planner.step(STARTS, 100.0, stamps)
    stamps = stamps + PERIOD
    stamps[1] -= sign * (limit + beyond)
    commands = planner.step(STARTS + [0.001, 0.0, 0.0], 100.0 + PERIOD, stamps)
    assert (planner.status.state == "stale") == stopped
    assert commands.any() != stopped
    assert planner.status.involved == ((1,) if stopped else ())


@pytest.mark.parametrize("variant", VARIANTS)
def test_robots_that_are_too_near_are_stopped_as_well(variant):
    """The safety filter moved them apart, by poses that nobody could rely on."""
    close = STARTS.copy()
    close[1, :2] = close[0, :2] + [0.0, 0.30]
    planner = planner_of(variant=variant)
    planner.set_dynamic_obstacles([cv.DynamicObstacle(cv.Circle((0.0, 2.5), 0.3), (1.0, 0.0))])
    for cycle in range(5):
        commands = planner.step(close, 10.0 + cycle * PERIOD, np.array([9.0, 10.2, 10.2, 10.2]))
        assert planner.status.state == "stale"
        assert not commands.any()


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_variant_looks_at_stamps_that_it_is_given(variant):
    planner = planner_of(variant=variant)
    assert not planner.step(STARTS, 10.0, np.array([10.0, 10.0, 10.0, 3.0])).any()
    assert planner.status.involved == (3,)
    assert planner.step(STARTS, 10.05, np.full(4, 10.05)).any()


def test_stamps_of_another_clock_are_named():
    planner = planner_of()
    for cycle in range(3):
        planner.step(STARTS, cycle * PERIOD, np.full(4, 1e3 * cycle * PERIOD + 1e6))
        assert "robots 0, 1, 2, 3 is stamped later" in planner.status.message


def test_a_lost_robot_may_be_as_old_as_it_likes():
    planner = planner_of()
    planner.lose(1)
    commands = planner.step(STARTS, 10.0, np.array([10.0, 0.0, 10.0, 10.0]))
    assert planner.status.state != "stale"
    assert commands[0].any()
    planner.rejoin(1)
    planner.step(STARTS, 10.05, np.array([10.05, 0.0, 10.05, 10.05]))
    assert planner.status.involved == (1,)


def test_arrival_needs_fresh_poses():
    planner = planner_of()
    there = np.column_stack([SQUARE.placed((6.2, 2.5, 0.0)), np.zeros(4)])
    for cycle in range(20):
        planner.step(there, cycle * PERIOD, np.full(4, cycle * PERIOD))
    assert planner.status.arrived
    planner.step(there, 1.0, np.array([1.0, 0.4, 1.0, 1.0]))
    assert not planner.status.arrived
    planner.step(there, 1.05, np.full(4, 1.05))
    assert planner.status.arrived


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "soon", None])
def test_a_limit_that_is_none_is_refused(value):
    with pytest.raises(cv.InputError, match="max_age"):
        cv.Imperfections(max_age=value)
