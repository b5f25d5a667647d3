"""Laws of the ideal robot's motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.robots import robot_model
from cavalcade.robots.motion import advance, ellipse_scale, limits_of

GO1 = robot_model("go1")
LIMITS = limits_of(GO1)
DT = 0.01

speed = st.floats(-2.0, 2.0)
command = st.tuples(speed, speed, st.floats(-4.0, 4.0))


def drive(commands, steps=25):
    """States `(T, 6)` under each command for `steps` steps, from rest."""
    states = [np.zeros(6)]
    for cx, cy, cw in commands:
        for _ in range(steps):
            states.append(np.array(advance(tuple(states[-1]), (cx, cy, cw), DT, LIMITS)))
    return np.array(states)


@settings(max_examples=60, deadline=None)
@given(st.lists(command, min_size=1, max_size=8))
def test_no_command_breaks_a_limit(commands):
    states = drive(commands)
    c, s = np.cos(states[:, 2]), np.sin(states[:, 2])
    vx, vy = states[:, 3], states[:, 4]
    ellipse = np.hypot((c * vx + s * vy) / GO1.max_speed_x, (c * vy - s * vx) / GO1.max_speed_y)
    assert ellipse.max() <= 1.0 + 1e-9
    assert np.abs(states[:, 5]).max() <= GO1.max_yaw_rate + 1e-9
    change = np.diff(states[:, 3:], axis=0) / DT
    assert np.hypot(change[:, 0], change[:, 1]).max() <= GO1.max_acceleration * (1 + 1e-6)
    assert np.abs(change[:, 2]).max() <= GO1.max_yaw_acceleration * (1 + 1e-6)


@settings(max_examples=30, deadline=None)
@given(st.lists(command, min_size=1, max_size=4))
def test_a_mirrored_command_gives_mirrored_motion(commands):
    states = drive(commands)
    mirrored = drive([(cx, -cy, -cw) for cx, cy, cw in commands])
    np.testing.assert_allclose(mirrored, states * (1, -1, -1, 1, -1, -1), atol=1e-9)


def test_a_reachable_command_is_reached_and_held():
    states = drive([(0.3, 0.05, 0.0)], steps=200)
    np.testing.assert_allclose(states[-1, 3:], (0.3, 0.05, 0.0), atol=1e-12)


def test_zero_stops_it():
    states = drive([(0.5, 0.0, 1.0), (0.0, 0.0, 0.0)], steps=100)
    np.testing.assert_allclose(states[-1, 3:], 0.0, atol=1e-12)


@pytest.mark.parametrize("heading", np.linspace(0.0, 2.0 * math.pi, 9))
def test_scaling_lands_on_the_ellipse_and_keeps_the_direction(heading):
    vx, vy = 3.0 * math.cos(heading), 3.0 * math.sin(heading)
    scale = ellipse_scale(vx, vy, GO1.max_speed_x, GO1.max_speed_y)
    assert math.hypot(scale * vx / GO1.max_speed_x, scale * vy / GO1.max_speed_y) == pytest.approx(
        1
    )


def test_inside_the_ellipse_nothing_is_scaled():
    assert ellipse_scale(0.1, 0.05, 0.5, 0.2) == 1.0
