"""Dynamic obstacles as rectangles in the grid's frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import DynamicObstacle
from cavalcade.formation.dynamic_obstacles import obstacle_boxes
from cavalcade.geometry import transform_points
from cavalcade.world import Box, Circle, Polygon

SHAPES = [
    Circle((1.0, 2.0), 0.3),
    Box((1.0, 2.0), (0.8, 0.3), 0.6),
    Polygon(((0.5, 1.0), (1.5, 1.2), (0.9, 2.0))),
]


def test_nothing_moves():
    boxes = obstacle_boxes([], (0.0, 0.0, 0.0))
    assert [part.shape for part in boxes] == [(0, 3), (0, 2), (0, 2)]


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(SHAPES),
    st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)),
    st.integers(0, 2**32 - 1),
)
def test_the_rectangle_encloses_the_shape_wherever_the_map_lies(tools, shape, origin, seed):
    boxes = obstacle_boxes([DynamicObstacle(shape, (0.3, -0.1))], origin)
    x0, y0, x1, y1 = shape.bounds
    points = np.random.default_rng(seed).uniform((x0, y0), (x1, y1), (200, 2))
    inside = points[shape.distance(points) == 0.0]
    ((x, y, yaw),) = boxes.poses
    centre = transform_points(origin, np.array([[x, y]]))  # back into the map's frame
    pose = np.array([*centre[0], yaw + origin[2]])
    away = tools.distance_to_rectangle(inside, pose, *(2.0 * boxes.half[0]))
    assert away.max(initial=0.0) < 1e-9
    # Velocities turn with the frame and keep their size.
    turned = transform_points((0.0, 0.0, origin[2]), boxes.velocities)
    assert turned[0] == pytest.approx((0.3, -0.1))


def test_a_box_keeps_its_heading():
    boxes = obstacle_boxes([DynamicObstacle(SHAPES[1], (0.0, 0.0))], (0.0, 0.0, 0.0))
    np.testing.assert_allclose(boxes.poses, [[1.0, 2.0, 0.6]])
    np.testing.assert_allclose(boxes.half, [[0.4, 0.15]])
