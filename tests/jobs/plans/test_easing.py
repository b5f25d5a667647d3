"""Plans as legs can follow them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.speed_profile import (
    GRAIN,
    LegLimits,
    rate_profile,
    relief_along,
    rounded_headings,
)
from cavalcade.execution.time_scaling import WALKING
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.robots import MODELS
from cavalcade.world import generate_terrain

LIMITS = LegLimits()
BRAKE = 1.3


def bends(rates, span=1.5, speed=0.75, step=0.025):
    """A robot that walks with one yaw rate after another, without a moment in between."""
    count = round(span / step)
    turn = np.repeat(np.array(rates, dtype=float), count)
    yaw = np.concatenate([[0.0], np.cumsum(turn * step)])
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    x, y = (np.concatenate([[0.0], np.cumsum(speed * step * f(middle))]) for f in (np.cos, np.sin))
    time = step * np.arange(len(yaw))
    velocity = np.column_stack([speed * np.cos(yaw), speed * np.sin(yaw), 0.0 * yaw])
    zero = np.zeros(len(yaw), dtype=np.int8)
    return Trajectory(time, np.column_stack([x, y, 0.0 * x]), velocity, yaw, zero)


def test_a_steady_bend_stays_what_it_is():
    path = bends([1.0])
    eased = rounded_headings(path, LIMITS.window)
    np.testing.assert_allclose(eased.yaw, path.yaw, atol=1e-12)
    inside = slice(10, -20)  # it begins and ends at full speed
    np.testing.assert_allclose(rate_profile(eased, LIMITS, BRAKE)[inside], 1.0)


@pytest.mark.parametrize("rates", [(0.0, 1.2), (1.2, -1.2), (-1.2, 0.0)])
def test_corners_are_off_by_an_eighth_of_the_change_and_the_window(rates):
    path = bends(rates)
    eased = rounded_headings(path, LIMITS.window)
    off = np.abs(eased.yaw - path.yaw)
    assert off.max() == pytest.approx(abs(rates[1] - rates[0]) * LIMITS.window / 8.0, rel=0.05)
    far = np.abs(path.time - 1.5) > 0.5 * LIMITS.window + 1e-9
    assert off[far].max() < 1e-9
    assert eased.position is path.position
    np.testing.assert_allclose(eased.yaw[[0, -1]], path.yaw[[0, -1]], atol=1e-12)


@pytest.mark.parametrize("rates", [(0.0, 1.2), (1.2, -1.2)])
def test_at_its_profile_a_robot_keeps_to_the_limits(rates):
    path = rounded_headings(bends(rates), LIMITS.window)
    profile = rate_profile(path, LIMITS, BRAKE)
    inside = profile[20:-30]  # it begins and ends at full speed
    assert inside.min() == pytest.approx(profile[round(1.5 / GRAIN)], abs=1e-9)
    assert 0.3 < inside.min() < 0.9
    # Follow it in small steps of time, as robots speed up and brake.
    dt, at, pace, moments = 0.002, 0.5, 1.0, []
    while at < path.duration - 0.5:
        moments.append(at)
        most = float(np.interp(at, GRAIN * np.arange(len(profile)), profile))
        pace = min(most, pace + BRAKE * dt)
        at += dt * pace
    yaw = path.poses_at(np.array(moments))[:, 2]
    window = round(0.1 / dt)
    rate = (yaw[window:] - yaw[:-window]) / (window * dt)
    change = np.abs(rate[window:] - rate[:-window]) / (window * dt)
    # In a bend, a change of pace is one of the yaw rate as well.
    assert change.max() < LIMITS.turning_acceleration + 1.2 * BRAKE
    # Unslowed it would be more.
    assert abs(rates[1] - rates[0]) / LIMITS.window > LIMITS.turning_acceleration + 1.2 * BRAKE


def test_robots_brake_in_time_for_slow_places():
    profile = rate_profile(rounded_headings(bends([1.2, -1.2]), LIMITS.window), LIMITS, BRAKE)
    falling = np.diff(profile**2) / GRAIN
    assert falling.min() >= -2.0 * BRAKE - 1e-9


def test_speeds_beyond_what_legs_do_are_passed_more_slowly():
    path = bends([0.0], speed=2.0)
    assert rate_profile(path, LIMITS, BRAKE)[20] == pytest.approx(LIMITS.ahead / 2.0)


def test_a_robot_that_stands():
    path = bends([0.0], speed=0.0)
    np.testing.assert_array_equal(rounded_headings(path, 0.25).yaw, path.yaw)
    np.testing.assert_allclose(rate_profile(path, LIMITS, BRAKE), 1.0)
    single = replace(
        path, **{n: getattr(path, n)[:1] for n in ("time", "position", "velocity", "yaw", "phase")}
    )
    assert rounded_headings(single, 0.25) is single
    assert (rate_profile(single, LIMITS, BRAKE) == 1.0).all()


def test_the_follower_slows_down_at_corners_and_not_elsewhere():
    path, model = bends([1.2, -1.2]), MODELS["go1"]
    start, goal = path.poses_at(np.array([0.0, path.duration]))
    follower = PlanFollower([path], [model], [start], [goal], 20.0, None, WALKING)
    eased = rounded_headings(path, LIMITS.window)
    rates, progress = [], [0.0]
    for k in range(60):
        # A robot that is where it is sent.
        pose = eased.poses_at(np.array([progress[-1]]))
        follower.step(pose, 0.05 * k, np.array([0.05 * k]))
        progress.append(float(follower.progress[0]))
        rates.append((progress[-1] - progress[-2]) / 0.05)
    there = np.array(progress[1:])
    assert min(np.array(rates)[np.abs(there - 1.5) < 0.2]) < 0.8
    assert (np.array(rates)[(there > 0.5) & (there < 1.0)] > 0.99).all()


def test_relief_is_what_departs_from_a_plane():
    poses = np.array([[3.0, 2.0, 0.3], [3.0, 1.5, -1.0]])
    slope = generate_terrain("slope", (6.0, 4.0), angle=0.2)
    np.testing.assert_allclose(relief_along(slope, poses), 0.0, atol=1e-9)
    step = generate_terrain("step", (6.0, 4.0), height=0.2)
    across = np.column_stack([np.linspace(1.0, 5.0, 81), np.full(81, 2.0), np.zeros(81)])
    relief = relief_along(step, across)
    # What a plane through a step leaves of it, and nothing away from it.
    assert 0.1 < relief.max() < 0.2
    assert relief[[0, -1]].max() < 1e-9


def test_rough_ground_is_passed_more_slowly():
    rough = generate_terrain("rough", (6.0, 4.0), seed=1, height=0.25)
    path = bends([0.0], span=6.0)
    path = replace(path, position=path.position + np.array([0.5, 2.0, 0.0]))
    level, there = (rate_profile(path, LIMITS, BRAKE, ground) for ground in (None, rough))
    assert (there <= level + 1e-12).all()
    relief = relief_along(rough, path.poses_at(GRAIN * np.arange(len(there))))
    most = np.interp(relief, LIMITS.relief, (LIMITS.ahead, LIMITS.rough_ahead))
    assert (there[10:-30] * 0.75 <= most[10:-30] + 1e-6).all()
    assert there[10:-30].min() < 0.7
