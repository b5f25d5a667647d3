"""Laws of angles, poses and rectangles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cavalcade.geometry import (
    inverse_transform_points,
    rectangle_corners,
    rotation,
    transform_points,
    wrap_angle,
)

number = st.floats(-100.0, 100.0)
poses = st.tuples(number, number, number)
points = hnp.arrays(float, st.tuples(st.integers(0, 5), st.just(2)), elements=number)


@given(number)
def test_a_wrapped_angle_is_the_same_direction(angle):
    wrapped = float(wrap_angle(angle))
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1.0)


@given(poses, points)
def test_there_and_back(pose, given_points):
    there = transform_points(pose, given_points)
    np.testing.assert_allclose(inverse_transform_points(pose, there), given_points, atol=1e-9)


@given(number, number)
def test_rotations_add_up(one, two):
    np.testing.assert_allclose(rotation(one) @ rotation(two), rotation(one + two), atol=1e-9)


@given(poses)
def test_a_rectangle_keeps_its_sides_and_its_sense(pose):
    corners = rectangle_corners(pose, 0.65, 0.28)
    sides = np.roll(corners, -1, axis=0) - corners
    np.testing.assert_allclose(np.hypot(*sides.T), [0.65, 0.28, 0.65, 0.28], atol=1e-9)
    x, y = corners.T
    area = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert area == pytest.approx(0.65 * 0.28)


def test_yaw_turns_counter_clockwise():
    np.testing.assert_allclose(transform_points((1, 2, math.pi / 2), [[1, 0]]), [[1, 3]])
