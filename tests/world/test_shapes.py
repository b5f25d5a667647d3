from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.world import Box, Circle, Polygon, distance_to_shapes
from cavalcade.world.shapes import MAX_COORDINATE

L_SHAPE = Polygon(((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)))
SHAPES = [Box((1.0, 2.0), (2.0, 0.5), 0.7), Circle((1.0, -1.0), 0.4), L_SHAPE]
near = st.floats(-5, 5)


def test_distances_by_hand():
    points = [[0, 0], [2, 0], [2, 2], [0, 3]]
    box = Box((0, 0), (2, 4))
    assert box.distance(points) == pytest.approx([0, 1, 1, 1])
    circle = Circle((0, 0), 1)
    assert circle.distance(points) == pytest.approx([0, 1, 2 * math.sqrt(2) - 1, 2])
    assert L_SHAPE.distance([[0.5, 1.5], [1.5, 1.5], [2, 2], [-3, -4]]) == pytest.approx(
        [0, 0.5, 1.0, 5]
    )


def test_turned_box_by_hand():
    box = Box((0, 0), (2 * math.sqrt(2), 2 * math.sqrt(2)), math.pi / 4)
    assert box.distance([[2, 0], [3, 0], [2, 2]]) == pytest.approx([0, 1, math.sqrt(2)])
    assert box.bounds == pytest.approx((-2, -2, 2, 2))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@given(x=near, y=near, dx=near, dy=near)
def test_distance_is_lipschitz_and_moves_along(shape, x, y, dx, dy):
    here, there = shape.distance([[x, y], [x + dx, y + dy]])
    assert abs(here - there) <= math.hypot(dx, dy) + 1e-9
    assert shape.moved((dx, dy)).distance([[x + dx, y + dy]])[0] == pytest.approx(here, abs=1e-9)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_bounds_are_tight(shape):
    x0, y0, x1, y1 = shape.bounds
    line = np.linspace(-1, 1, 4001)
    for x, y in ((x0, None), (x1, None), (None, y0), (None, y1)):
        along = np.column_stack(
            [np.full(4001, x), (y0 + y1) / 2 + line * (y1 - y0) / 2]
            if y is None
            else [(x0 + x1) / 2 + line * (x1 - x0) / 2, np.full(4001, y)]
        )
        assert shape.distance(along).min() < 1e-3
        outward = np.array(
            [
                0 if x is None else np.sign(x - x0) * 2 - 1,
                0 if y is None else np.sign(y - y0) * 2 - 1,
            ]
        )
        assert shape.distance(along + 0.01 * outward).min() > 0.0099


@given(st.lists(st.tuples(near, near), min_size=1, max_size=5), near)
def test_polygon_and_box_agree(points, yaw):
    box = Box((0.3, -0.2), (2.0, 0.7), yaw)
    polygon = Polygon(tuple((float(x), float(y)) for x, y in box.corners))
    assert polygon.distance(points) == pytest.approx(box.distance(points), abs=1e-9)
    reverse = Polygon(polygon.points[::-1])
    assert reverse.distance(points) == pytest.approx(polygon.distance(points), abs=1e-12)


def test_polygon_drops_a_closing_vertex():
    assert Polygon(((0, 0), (1, 0), (0, 1), (0, 0))) == Polygon(((0, 0), (1, 0), (0, 1)))


def test_nearest_of_several():
    assert distance_to_shapes(SHAPES, [[1, -1]])[0] == 0.0
    assert distance_to_shapes([], [[1, -1], [0, 0]]).tolist() == [math.inf, math.inf]


def test_shapes_are_values():
    assert Box([1, 2], [3, 4]) == Box((1.0, 2.0), (3.0, 4.0), 0.0)
    assert len({Circle((0, 0), 1), Circle(np.array([0.0, 0.0]), 1.0)}) == 1


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: Box((0, 0), (1, 0)), "box.size"),
        (lambda: Box((0, 0), (1, -1)), "box.size"),
        (lambda: Box((0, math.nan), (1, 1)), "box.center"),
        (lambda: Box((0, 0, 0), (1, 1)), "box.center"),
        (lambda: Box("ab", (1, 1)), "box.center"),
        (lambda: Box((0, 0), (1, 1), math.inf), "box.yaw"),
        (lambda: Circle((0, 0), 0), "circle.radius"),
        (lambda: Circle((0, 0), True), "circle.radius"),
        (lambda: Circle((0, 0), "1"), "circle.radius"),
        (lambda: Circle((0, 0), 10**400), "circle.radius"),
        (lambda: Circle((2 * MAX_COORDINATE, 0), 1), "circle.center"),
        (lambda: Polygon(((0, 0), (1, 0))), "polygon.points"),
        (lambda: Polygon(3), "polygon.points"),
        (lambda: Polygon(((0, 0), (1, 0), (2, 0))), "polygon.points"),
        (lambda: Polygon(((0, 0), (1, 1), (1, 0), (0, 1))), "polygon.points"),
        (lambda: Polygon(((0, 0), (0, 0), (1, 0), (0, 1))), "polygon.points"),
        (lambda: Polygon(((0, 0), (2, 0), (1, 0), (1, 1))), "polygon.points"),
        (lambda: Polygon(((0, 0), (4, 0), (4, 4), (2, 0), (0, 4))), "polygon.points"),
        (lambda: Polygon(((0, 0), (1, 0), (0, math.nan))), "polygon.points[2]"),
        (lambda: Polygon(tuple((i, i * i) for i in range(10_001))), "polygon.points"),
    ],
)
def test_bad_shapes_name_their_key(make, key):
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.key == key


@pytest.mark.parametrize("points", [[1, 2], [[1, 2, 3]], [[math.nan, 0]]])
def test_bad_points(points):
    for shape in SHAPES:
        with pytest.raises(InputError, match="points"):
            shape.distance(points)
