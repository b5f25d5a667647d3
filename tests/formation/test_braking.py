"""What the safety filter counts on: how ideal robots brake."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.robots import robot_model
from cavalcade.robots.motion import advance, limits_of

GO1 = robot_model("go1")
LIMITS = limits_of(GO1)
STOP = (0.0, 0.0, 0.0)


def braked(state, dt=0.01, seconds=1.0):
    states = [np.array(state, dtype=float)]
    for _ in range(round(seconds / dt)):
        states.append(np.array(advance(tuple(states[-1]), STOP, dt, LIMITS)))
    return np.array(states)


@pytest.mark.parametrize("speed", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_straight_ahead_it_takes_the_distance_that_the_textbook_says(speed, heading):
    c, s = math.cos(heading), math.sin(heading)
    states = braked((0.0, 0.0, heading, c * speed, s * speed, 0.0))
    assert np.hypot(*states[-1, :2]) == pytest.approx(
        speed**2 / (2 * GO1.max_acceleration), abs=1e-3
    )
    np.testing.assert_allclose(states[-1, 3:], 0.0, atol=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(0.0, 1.0), st.floats(-1.2, 1.2))
def test_braking_is_steady_and_keeps_the_limits(heading, pace, rate):
    states = braked((0, 0, 0, pace * 0.5 * math.cos(heading), pace * 0.2 * math.sin(heading), rate))
    speed = np.hypot(states[:, 3], states[:, 4])
    assert (np.diff(speed) <= 1e-9).all()
    change = np.diff(states[:, 3:5], axis=0) / 0.01
    assert np.hypot(change[:, 0], change[:, 1]).max() <= GO1.max_acceleration * (1 + 1e-6)
    assert speed[-1] < 1e-9
    assert abs(states[-1, 5]) < 1e-9


@settings(max_examples=30, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(-1.2, 1.2), st.sampled_from([0.005, 0.0125, 0.025]))
def test_the_length_of_the_time_step_hardly_matters(heading, rate, dt):
    """The filter predicts with other steps than the fleet moves with."""
    state = (0, 0, 0, 0.5 * math.cos(heading), 0.2 * math.sin(heading), rate)
    fine, coarse = braked(state, 0.001)[-1], braked(state, dt)[-1]
    np.testing.assert_allclose(coarse[:3], fine[:3], atol=0.01)
