"""A robot that does not do as commanded is named; it took 65 s until the team was stuck."""

from __future__ import annotations

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.fleet import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.formation.robot_monitor import FollowingMonitor
from cavalcade.robots import robot_model

GO1 = robot_model("go1")
PERIOD = 0.05
ROOM = cv.OccupancyMap.empty((8.0, 5.0), 0.05)
SQUARE = cv.Formation.square()
STARTS = np.column_stack([SQUARE.placed((1.5, 2.5, 0.0)), np.zeros(4)])


def named_at(
    noise: float, delay: float, share: float, since: float, seconds: float, drop: float = 0.0
) -> float | None:
    """When robot 2 is named, s, that from `since` on does a share of what it is told."""
    expected = cv.Imperfections(position=noise, delay=delay, drop=drop)
    planner = cv.FormationPlanner(ROOM, SQUARE, expected=expected)
    planner.set_goal((6.2, 2.5, 0.0))
    fleet = IdealFleet(
        (GO1,) * 4, STARTS, noise=LocalisationNoise(noise), delay=CommandDelay(delay, 0.0, drop)
    )
    for _ in range(round(seconds / PERIOD)):
        seen = fleet.observe()
        commands = planner.step(seen.poses, seen.time, seen.stamps)
        if planner.status.involved:
            assert planner.status.involved == (2,)
            assert "robot 2" in planner.status.message
            return seen.time
        commands[2] *= share if seen.time >= since else 1.0
        fleet.send(commands)
        fleet.advance(PERIOD)
    return None


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("since", [0.0, 2.5])
def test_a_robot_that_stands_is_named_within_three_seconds(delay, noise, since):
    at = named_at(noise, delay, 0.0, since, since + 6.0)
    assert at is not None
    assert at - since <= 3.0


@pytest.mark.parametrize("delay", [0.0, 0.3])
@pytest.mark.parametrize("drop", [0.0, 0.2])
@pytest.mark.parametrize("share", [1.0, 0.9, 0.6])
def test_robots_that_slip_or_are_reached_badly_are_not(delay, drop, share):
    assert named_at(0.01, delay, share, 0.0, 16.0, drop) is None


def judged(commands, motion, seconds: float = 3.0, model=GO1) -> list[float]:
    """When a robot that moves by `motion` m/s, rad/s while commanded otherwise is named, s."""
    monitor = FollowingMonitor(model, 1, PERIOD, cv.Imperfections())
    pose, found = np.zeros(3), []
    for cycle in range(round(seconds / PERIOD)):
        monitor.update(pose[None].copy(), cycle * PERIOD)
        monitor.commanded(np.array([commands], dtype=float))
        pose = pose + PERIOD * np.array(motion)
        found += [cycle * PERIOD] if monitor.deaf else []
    return found


@pytest.mark.parametrize(
    ("commands", "motion", "named"),
    [
        ((0.1, 0.0, 0.0), (0.0, 0.0, 0.0), True),
        ((0.0, 0.1, 0.0), (0.0, 0.0, 0.0), True),
        ((0.02, 0.0, 0.0), (0.0, 0.0, 0.0), False),  # legs need not answer so small a one
        ((0.0, 0.0, 0.4), (0.0, 0.0, 0.0), True),
        ((0.0, 0.0, 0.4), (0.0, 0.0, -0.4), True),
        ((0.0, 0.0, 0.4), (0.0, 0.0, 0.3), False),
        ((0.3, 0.0, 0.0), (-0.3, 0.0, 0.0), True),
        ((0.3, 0.0, 0.0), (0.0, 0.3, 0.0), True),
        ((0.3, 0.0, 0.0), (0.06, 0.0, 0.0), True),
        ((0.3, 0.0, 0.0), (0.1, 0.0, 0.0), False),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), False),
        ((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), False),
    ],
)
def test_what_counts_as_not_following(commands, motion, named):
    assert bool(judged(commands, motion)) == named


def test_a_robot_that_speeds_up_slowly_follows():
    slow = robot_model("go1").with_limits(max_acceleration=0.02)
    monitor = FollowingMonitor(slow, 1, PERIOD, cv.Imperfections())
    for cycle in range(200):
        time = cycle * PERIOD
        monitor.update(np.array([[0.01 * time * time, 0.0, 0.0]]), time)
        monitor.commanded(np.array([[0.5, 0.0, 0.0]]))
        assert not monitor.deaf


def test_it_is_named_until_it_follows():
    monitor = FollowingMonitor(GO1, 1, PERIOD, cv.Imperfections())
    x, said = 0.0, []
    for cycle in range(160):
        monitor.update(np.array([[x, 0.0, 0.0]]), cycle * PERIOD)
        monitor.commanded(np.array([[0.3, 0.0, 0.0]]))
        x += PERIOD * 0.3 * (cycle > 80)
        said.append(bool(monitor.deaf))
    assert said[80]
    assert not said[-1]
    assert np.count_nonzero(np.diff(said)) == 2
