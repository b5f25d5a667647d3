from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.geometry import transform_points
from cavalcade.world import Box, Circle, Polygon, distance_to_shapes, rasterise

ROWS, COLS, CELL = 7, 9, 0.5
STAR = Polygon(
    tuple(
        (2.4 + r * math.cos(a), 2.1 + r * math.sin(a))
        for a, r in zip(np.arange(10) * math.pi / 5, [1.9, 0.5] * 5, strict=True)
    )
)
place = st.tuples(st.floats(-1, 6), st.floats(-1, 5))
length = st.floats(0.01, 4)
angle = st.floats(-4, 4)
boxes = st.builds(Box, place, st.tuples(length, length), angle)
circles = st.builds(Circle, place, st.floats(0.01, 3))
stars = st.builds(lambda offset: STAR.moved(offset), st.tuples(st.floats(-3, 3), st.floats(-3, 3)))


def crosses(a, b, c, d):
    """Whether segments a-b and c-d have a point in common (not for parallel ones)."""
    (abx, aby), (cdx, cdy), (acx, acy) = (b - a).tolist(), (d - c).tolist(), (c - a).tolist()
    turn = abx * cdy - aby * cdx
    if turn == 0:
        return False
    s = (acx * cdy - acy * cdx) / turn
    t = (acx * aby - acy * abx) / turn
    return 0 <= s <= 1 and 0 <= t <= 1


def touches(shape, square):
    """Slow reference: whether a shape and a square, given by its corners, meet."""
    if isinstance(shape, Circle):
        return Polygon(tuple(map(tuple, square))).distance([shape.center])[0] <= shape.radius
    corners = shape.corners if isinstance(shape, Box) else shape.vertices
    if (shape.distance(square) == 0).any():
        return True
    if (Polygon(tuple(map(tuple, square))).distance(corners) == 0).any():
        return True
    edges = list(zip(corners, np.roll(corners, -1, axis=0), strict=True))
    sides = list(zip(square, np.roll(square, -1, axis=0), strict=True))
    return any(crosses(*edge, *side) for edge in edges for side in sides)


@settings(max_examples=25, deadline=None)
@given(st.one_of(boxes, circles, stars), st.tuples(st.floats(-1, 1), st.floats(-1, 1), angle))
def test_a_cell_is_occupied_if_and_only_if_the_shape_touches_it(shape, origin):
    grid = rasterise([shape], ROWS, COLS, CELL, origin)
    unit = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
    for row in range(ROWS):
        for col in range(COLS):
            # What is touched by a hair may fall either way, by the reference's own rounding.
            smaller, larger = (
                transform_points(origin, (np.array([col, row]) + 0.5 + unit * scale) * CELL)
                for scale in (1 - 1e-6, 1 + 1e-6)
            )
            if grid[row, col]:
                assert touches(shape, larger)
            else:
                assert not touches(shape, smaller)


def test_edges_on_cell_borders_stay_on_their_side():
    grid = rasterise([Box((1.5, 1.0), (1.0, 1.0))], 20, 30, 0.1)
    expected = np.zeros((20, 30), dtype=bool)
    expected[5:15, 10:20] = True
    assert (grid == expected).all()
    corners = ((1.0, 0.5), (2.0, 0.5), (2.0, 1.5), (1.0, 1.5))
    assert (rasterise([Polygon(corners)], 20, 30, 0.1) == expected).all()


def test_thin_and_tiny_shapes_are_not_lost():
    assert rasterise([Circle((0.26, 0.31), 1e-4)], 10, 10, 0.05).sum() == 1
    wall = rasterise([Box((0.5, 0.512), (2.0, 1e-3))], 20, 20, 0.05)
    assert wall[10].all()
    assert wall.sum() == 20
    sliver = rasterise([Polygon(((0.02, 0.01), (0.98, 0.97), (0.98, 0.971)))], 20, 20, 0.05)
    assert np.diag(sliver).all()


def test_concave_polygons_keep_their_bay_free():
    horseshoe = Polygon(((0, 0), (5, 0), (5, 4), (4, 4), (4, 1), (1, 1), (1, 4), (0, 4)))
    grid = rasterise([horseshoe], 5, 5, 1.0)
    assert not grid[1:4, 1:4].any()
    assert grid[:4, [0, 4]].all()


@pytest.mark.parametrize("shape", [Circle((-50, 0), 1), Box((0, 90), (1, 1)), STAR.moved((99, 0))])
def test_shapes_off_the_map_leave_it_free(shape):
    assert not rasterise([shape], 20, 30, 0.1).any()


def test_a_shape_around_the_map_fills_it():
    around = (Circle((1, 1), 50), Box((1, 1), (90, 90), 1.0))
    around += (Polygon(((-99, -99), (99, -99), (99, 99), (-99, 99))),)
    for shape in around:
        assert rasterise([shape], 20, 30, 0.1).all()


def test_the_union_is_the_or():
    shapes = [Circle((0.4, 0.4), 0.2), Box((1, 1), (0.5, 0.2), 0.3), STAR]
    each = [rasterise([shape], 40, 40, 0.1) for shape in shapes]
    assert (rasterise(shapes, 40, 40, 0.1) == np.logical_or.reduce(each)).all()


def test_free_cells_are_clear_at_their_centres():
    shapes = [Circle((3, 3), 0.7), Box((6, 2), (1.4, 0.4), 0.5), STAR]
    grid = rasterise(shapes, 100, 160, 0.05)
    rows, cols = np.nonzero(~grid)
    clearance = distance_to_shapes(shapes, (np.column_stack([cols, rows]) + 0.5) * 0.05)
    assert clearance.min() >= 0.025 - 1e-8
