"""Speed limits against equations 7 to 9 of the paper."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation._shaping import limit_speeds

V_X, V_Y, V_MIN, SLOWDOWN = 0.50, 0.20, 0.10, 0.40
FREE, FAR = 1.0, math.inf

finite = st.floats(-3.0, 3.0)


def limited(velocity, yaw=0.0, w=FREE, to_goal=FAR, v_min=V_MIN):
    changed = np.array([velocity], dtype=float)
    limit_speeds(
        changed, np.array([yaw]), np.array([w]), np.array([to_goal]),
        (V_X, V_Y, v_min, SLOWDOWN),
    )  # fmt: skip
    return changed[0]


def reference(velocity, yaw, w, to_goal):
    """The three limits on their own, then equation 7."""
    vx, vy = velocity
    speed = math.hypot(vx, vy)
    if speed == 0.0:
        return np.zeros(2)
    theta = math.atan2(vy, vx) - yaw
    v_theta = V_X * V_Y / math.sqrt((math.sin(theta) * V_X) ** 2 + (math.cos(theta) * V_Y) ** 2)
    v_w = V_MIN + w * (V_X - V_MIN)
    v_goal = to_goal / SLOWDOWN * V_X
    return np.array(velocity) * min(speed, v_theta, v_w, v_goal) / speed


@settings(max_examples=150, deadline=None)
@given(
    st.tuples(finite, finite),
    st.floats(-4.0, 4.0),
    st.floats(0.0, 1.0),
    st.floats(0.0, 2.0) | st.just(math.inf),
)
def test_kernel_and_reference_agree(velocity, yaw, w, to_goal):
    np.testing.assert_allclose(
        limited(velocity, yaw, w, to_goal), reference(velocity, yaw, w, to_goal), atol=1e-9
    )


@pytest.mark.parametrize(
    ("heading", "yaw", "top"),
    [(0.0, 0.0, 0.5), (math.pi, 0.0, 0.5), (math.pi / 2, 0.0, 0.2), (math.pi / 2, math.pi / 2, 0.5),
     (0.3, 0.3 - math.pi / 2, 0.2)],
)  # fmt: skip
def test_the_axes_of_the_ellipse_turn_with_the_body(heading, yaw, top):
    fast = 2.0 * np.array([math.cos(heading), math.sin(heading)])
    np.testing.assert_allclose(limited(fast, yaw), fast / 2.0 * top, atol=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))
def test_a_fast_velocity_ends_on_the_ellipse(heading, yaw):
    v = limited((3.0 * math.cos(heading), 3.0 * math.sin(heading)), yaw)
    along = math.cos(yaw) * v[0] + math.sin(yaw) * v[1]
    across = math.cos(yaw) * v[1] - math.sin(yaw) * v[0]
    assert math.hypot(along / V_X, across / V_Y) == pytest.approx(1.0)


@pytest.mark.parametrize(("w", "top"), [(0.0, 0.10), (0.25, 0.20), (0.5, 0.30), (1.0, 0.50)])
def test_v_w_by_itself(w, top):
    """On slow ground: from v_min at W = 0 to v_max_x at W = 1."""
    assert limited((0.5, 0.0), w=w)[0] == pytest.approx(top)


@pytest.mark.parametrize("w", [0.0, 0.3, 1.0])
def test_the_experiments_v_min_makes_v_w_inert(w):
    np.testing.assert_allclose(limited((0.5, 0.0), w=w, v_min=V_X), (0.5, 0.0))


@pytest.mark.parametrize(("away", "top"), [(0.0, 0.0), (0.1, 0.125), (0.2, 0.25), (0.4, 0.5)])
def test_v_goal_slows_down_to_a_stand_without_a_floor(away, top):
    assert limited((0.5, 0.0), to_goal=away)[0] == pytest.approx(top)


def test_a_slow_velocity_stays_as_it_is():
    np.testing.assert_array_equal(limited((0.03, -0.02)), (0.03, -0.02))


@pytest.mark.parametrize("to_goal", [0.0, 0.1, math.inf])
def test_a_zero_velocity_stays_zero(to_goal):
    found = limited((0.0, 0.0), w=0.0, to_goal=to_goal)
    np.testing.assert_array_equal(found, (0.0, 0.0))


def test_robots_do_not_meet_in_it():
    velocity = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 0.1]])
    limit_speeds(
        velocity, np.zeros(3), np.array([1.0, 0.0, 1.0]), np.full(3, np.inf),
        (V_X, V_Y, V_MIN, SLOWDOWN),
    )  # fmt: skip
    np.testing.assert_allclose(velocity, [[0.5, 0.0], [0.0, 0.0], [0.0, 0.1]])
