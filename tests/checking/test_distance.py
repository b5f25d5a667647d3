"""The exact distances against a slow and obvious reference."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.checking import distance

HALF = np.array([0.325, 0.14])
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
BAY = np.array([[-1, -1], [1, -1], [1, 1], [0.8, 1], [0.8, -0.8], [-0.8, -0.8], [-0.8, 1], [-1, 1]])


def outline(corners, count=400):
    """Points along the closed outline."""
    ends = np.roll(corners, -1, axis=0)
    part = np.linspace(0.0, 1.0, count)[:, None, None]
    return (corners + part * (ends - corners)).reshape(-1, 2)


def holds(corners, points):
    """Whether the closed outline winds around the points."""
    towards = corners[None] - points[:, None]
    angle = np.unwrap(np.arctan2(towards[..., 1], towards[..., 0]), axis=1)
    last = np.arctan2(towards[:, 0, 1], towards[:, 0, 0])
    closing = (last - angle[:, -1] + np.pi) % (2 * np.pi) - np.pi
    return np.abs(angle[:, -1] + closing - angle[:, 0]) > np.pi


def reference(corners):
    """Distance of the polygon from the rectangle, by points of both outlines."""
    body = HALF * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    one, two = outline(body, 60), outline(corners)
    if holds(corners, one).any() or holds(body, two).any():
        return 0.0
    return np.sqrt(((one[:, None] - two[None]) ** 2).sum(axis=-1)).min()


coordinate = st.floats(-2.0, 2.0)


@settings(max_examples=150, deadline=None)
@given(x=coordinate, y=coordinate, yaw=st.floats(-3.2, 3.2), shape=st.sampled_from([SQUARE, BAY]))
def test_polygons_agree_with_the_reference(x, y, yaw, shape):
    pose = np.array([[x, y, yaw]])
    seen = distance.seen_from(pose, shape[None])
    found = float(distance.to_polygons(HALF, seen)[0])
    slow = reference(seen[0])
    assert found <= slow + 1e-9
    assert slow - found < 0.01


@settings(max_examples=100, deadline=None)
@given(x=coordinate, y=coordinate, yaw=st.floats(-3.2, 3.2))
def test_two_rectangles_see_each_other_at_the_same_distance(x, y, yaw):
    one, two = np.array([[x, y, yaw]]), np.array([[0.3, -0.2, 1.1]])
    forth = distance.to_polygons(HALF, distance.seen_from(one, distance.corners(two, HALF)))
    back = distance.to_polygons(HALF, distance.seen_from(two, distance.corners(one, HALF)))
    np.testing.assert_allclose(forth, back, atol=1e-12)


@pytest.mark.parametrize(
    ("point", "expected"),
    [((0, 0), 0.0), ((0.325, 0.14), 0.0), ((1.325, 0.0), 1.0), ((0.325 + 3, 0.14 + 4), 5.0)],
)
def test_points(point, expected):
    assert distance.to_points(HALF, np.array(point)) == pytest.approx(expected)


def test_a_polygon_around_the_rectangle_and_one_inside_it():
    big, small = 3.0 * SQUARE, 0.05 * SQUARE
    assert distance.to_polygons(HALF, np.stack((big, small))).tolist() == [0.0, 0.0]


def test_edges_along_the_axes_and_of_no_length():
    flat = np.array([[[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 1.0]]])
    assert distance.to_polygons(HALF, flat)[0] == pytest.approx(0.675)


def test_seen_from_and_corners_undo_each_other():
    pose = np.array([[1.0, -2.0, 0.7]])
    local = distance.seen_from(pose, distance.corners(pose, HALF))
    np.testing.assert_allclose(np.abs(local[0]), np.broadcast_to(HALF, (4, 2)))
