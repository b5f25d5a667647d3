"""Planted breaches of every limit, and motion that keeps them all."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.checking.limits import exceeded, measure
from cavalcade.checking.tracks import Track
from cavalcade.robots import robot_model
from cavalcade.robots.motion import advance, limits_of

GO1 = robot_model("go1")


def moved(speed, heading, yaw=0.0, dt=0.05, count=40):
    time = dt * np.arange(count)
    step = speed * np.array([math.cos(heading), math.sin(heading)])
    return Track(time, np.column_stack((np.outer(time, step), np.full(count, yaw))))


def kinds(track):
    return [violation.kind for violation in exceeded(measure(track, GO1), GO1, 0)]


@pytest.mark.parametrize(
    ("speed", "heading", "yaw", "found"),
    [
        (0.50, 0.0, 0.0, []),
        (0.52, 0.0, 0.0, ["speed"]),
        (0.20, math.pi / 2, 0.0, []),
        (0.25, math.pi / 2, 0.0, ["speed"]),
        (0.50, math.pi / 2, math.pi / 2, []),
        (0.45, math.pi / 2, math.pi / 4, ["speed"]),
    ],
)
def test_the_ellipse_lies_in_the_body_frame(speed, heading, yaw, found):
    assert kinds(moved(speed, heading, yaw)) == found


def test_a_jump_of_speed_breaks_the_acceleration_limit_once():
    slow, fast = moved(0.0, 0.0), moved(0.45, 0.0)
    joined = np.vstack((slow.pose, slow.pose[-1] + fast.pose[1:]))
    track = Track(0.05 * np.arange(len(joined)), joined)
    (violation,) = exceeded(measure(track, GO1), GO1, 3)
    assert violation.kind == "acceleration"
    assert violation.robots == (3,)
    assert violation.value == pytest.approx(0.45 / 0.05)
    assert violation.time == pytest.approx(39 * 0.05)


@pytest.mark.parametrize(("rate", "found"), [(1.19, []), (1.3, ["yaw-rate"])])
def test_yaw_rate(rate, found):
    track = moved(0.0, 0.0)
    pose = track.pose.copy()
    pose[:, 2] = rate * track.time
    assert kinds(Track(track.time, pose)) == found


def test_yaw_acceleration():
    track = moved(0.0, 0.0)
    pose = track.pose.copy()
    pose[:, 2] = 0.5 * np.maximum(track.time - 1.0, 0.0)
    assert kinds(Track(track.time, pose)) == ["yaw-acceleration"]


def test_a_teleport_is_found():
    track = moved(0.3, 0.0)
    pose = track.pose.copy()
    pose[20:, 1] += 0.5
    assert set(kinds(Track(track.time, pose))) == {"speed", "acceleration"}


@pytest.mark.parametrize("dt", [0.05, 0.01])
def test_an_ideal_robot_under_wild_commands_passes(dt):
    rng = np.random.default_rng(7)
    limits = limits_of(GO1)
    state = np.zeros(6)
    poses = [state[:3]]
    command = np.zeros(3)
    for k in range(2000):
        if k % 7 == 0:
            command = rng.uniform(-1.0, 1.0, 3) * (0.8, 0.5, 2.0)
        for _ in range(round(dt / 0.01)):
            state = np.array(advance(tuple(state), tuple(command), 0.01, limits))
        poses.append(state[:3])
    track = Track(dt * np.arange(len(poses)), np.array(poses))
    assert kinds(track) == []


def test_one_sample_has_no_speed():
    assert kinds(Track(np.zeros(1), np.zeros((1, 3)))) == []
