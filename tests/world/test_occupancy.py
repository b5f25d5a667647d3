from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cavalcade.errors import MapError
from cavalcade.world import Box, Circle, OccupancyMap

POSE = (-3.0, 2.0, 0.6)
GRID = np.array([[0, 100, -1, 64], [65, 1, 99, 0]], dtype=np.int8)


def test_what_is_an_obstacle():
    assert OccupancyMap(GRID, 0.1).occupied.tolist() == [
        [False, True, True, False],
        [True, False, True, False],
    ]
    assert OccupancyMap(GRID, 0.1, unknown="free").occupied.tolist() == [
        [False, True, False, False],
        [True, False, True, False],
    ]


def test_bool_grids():
    occupancy = OccupancyMap(np.array([[True, False]]), 0.1)
    assert occupancy.grid.tolist() == [[100, 0]]
    assert occupancy.grid.dtype == np.int8


def test_size_and_shape():
    occupancy = OccupancyMap(GRID, 0.5)
    assert (occupancy.rows, occupancy.cols) == (2, 4)
    assert occupancy.size == pytest.approx((2.0, 1.0))


def test_the_map_cannot_change_behind_its_back():
    grid = GRID.copy()
    occupancy = OccupancyMap(grid, 0.1)
    grid[:] = 100
    assert occupancy.grid[0, 0] == 0
    for array in (occupancy.grid, occupancy.occupied):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1


@given(st.integers(0, 1), st.integers(0, 3), st.floats(0.01, 0.99), st.floats(0.01, 0.99))
def test_points_fall_into_their_cells(row, col, u, v):
    occupancy = OccupancyMap(GRID, 0.25, POSE)
    point = occupancy.to_map([[(col + u) * 0.25, (row + v) * 0.25]])
    assert occupancy.cell_of(point).tolist() == [[row, col]]
    assert occupancy.contains(point).all()
    assert np.abs(occupancy.centers([[row, col]]) - point).max() <= 0.25 * math.sqrt(0.5)


@given(st.floats(-100, 100), st.floats(-100, 100))
def test_frames_there_and_back(x, y):
    occupancy = OccupancyMap(GRID, 0.25, POSE)
    assert occupancy.to_map(occupancy.to_local([[x, y]]))[0] == pytest.approx((x, y), abs=1e-9)


def test_a_turned_origin_by_hand():
    occupancy = OccupancyMap(GRID, 1.0, (10.0, 0.0, math.pi / 2))
    # Columns run along the map's y axis, rows against its x axis.
    assert occupancy.centers([[0, 3]])[0] == pytest.approx((9.5, 3.5))
    assert occupancy.cell_of([[8.5, 0.5]]).tolist() == [[1, 0]]
    assert occupancy.contains([[8.5, 0.5], [10.5, 0.5]]).tolist() == [True, False]


def test_points_outside_and_nan():
    occupancy = OccupancyMap(GRID, 1.0)
    assert occupancy.cell_of([[-0.5, 7.5]]).tolist() == [[7, -1]]
    assert occupancy.cell_of([[1e300, -1e300]]).shape == (1, 2)
    assert occupancy.contains([[math.nan, 0.5], [math.inf, 0.5]]).tolist() == [False, False]
    with pytest.raises(MapError, match="finite"):
        occupancy.cell_of([[math.nan, 0.5]])


@pytest.mark.parametrize("origin", [(0, 0, 0), POSE])
def test_with_shapes_marks_in_the_map_frame(origin):
    occupancy = OccupancyMap(np.full((60, 60), -1, dtype=np.int8), 0.05, origin)
    center = occupancy.to_map([[1.5, 1.5]])[0]
    marked = occupancy.with_shapes([Circle(tuple(center), 0.5)])
    inside = np.hypot(*(occupancy.centers(np.argwhere(marked.grid == 100)) - center).T)
    assert inside.max() < 0.5 + 0.05 * math.sqrt(0.5)
    assert (marked.grid == 100).sum() * 0.05**2 == pytest.approx(math.pi * 0.25, rel=0.15)
    assert (marked.grid != 100).sum() == (marked.grid == -1).sum()
    assert (occupancy.grid == -1).all()


def test_a_box_along_a_turned_grid_fits_its_cells():
    occupancy = OccupancyMap(np.zeros((40, 40), dtype=np.int8), 0.1, POSE)
    center = occupancy.to_map([[2.0, 1.0]])[0]
    marked = occupancy.with_shapes([Box(tuple(center), (1.0, 0.4), POSE[2])])
    assert (marked.grid == 100).sum() == 40
    assert marked.occupied[8:12, 15:25].all()


def test_equal_by_value():
    one = OccupancyMap(GRID, 0.1, POSE)
    assert one == OccupancyMap(GRID.astype(int), 0.1, list(POSE))
    assert hash(one) == hash(OccupancyMap(GRID.copy(), 0.1, POSE))
    assert one != OccupancyMap(GRID, 0.1, POSE, unknown="free")
    assert one != OccupancyMap(GRID, 0.2, POSE)
    assert one != OccupancyMap(GRID, 0.1)
    assert one != OccupancyMap(GRID[:, ::-1], 0.1, POSE)
    assert one != 3


def test_empty_worlds_have_all_their_cells():
    for size, shape in [((14, 10), (200, 280)), ((9.5, 6.5), (130, 190)), ((0.15, 0.1), (2, 3))]:
        assert OccupancyMap.empty(size, 0.05).grid.shape == shape
    assert OccupancyMap.empty((1.03, 0.5), 0.1).grid.shape == (5, 10)


def test_huge_maps_are_refused_before_memory_is_taken():
    hundred_million = np.broadcast_to(np.int8(0), (10_000, 10_000))
    with pytest.raises(MapError, match="64 million"):
        OccupancyMap(hundred_million, 0.05)
    with pytest.raises(MapError, match="64 million"):
        OccupancyMap.empty((1e5, 1e5), 0.05)


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        ((np.zeros(4, dtype=int), 0.1), "grid"),
        ((np.zeros((0, 3), dtype=int), 0.1), "grid"),
        ((np.zeros((2, 2)), 0.1), "grid"),
        ((np.full((2, 2), 101), 0.1), "grid"),
        ((np.full((2, 2), -2), 0.1), "grid"),
        (([[1, 2], [3]], 0.1), "grid"),
        ((GRID, 0.0), "resolution"),
        ((GRID, math.nan), "resolution"),
        ((GRID, "x"), "resolution"),
        ((GRID, 0.1, (0, 0)), "origin"),
        ((GRID, 0.1, (0, math.inf, 0)), "origin"),
        ((GRID, 0.1, 7), "origin"),
        ((GRID, 0.1, (0, 1e9, 0)), "origin"),
        ((GRID, 0.1, (0, 0, 0), "maybe"), "unknown"),
    ],
)
def test_bad_maps_name_their_key(arguments, key):
    with pytest.raises(MapError) as caught:
        OccupancyMap(*arguments)
    assert caught.value.key == key


@pytest.mark.parametrize("size", [3, (1,), (0, 1), (1, math.nan), ("a", 1), (1e7, 1)])
def test_bad_sizes(size):
    with pytest.raises(MapError, match="size"):
        OccupancyMap.empty(size)
