"""Occupied cells as few rectangles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cavalcade.fleet.mujoco._rectangles import cover
from cavalcade.fleet.mujoco.ground import blocks_of_map, blocks_of_shape
from cavalcade.fleet.mujoco.ground_spec import clusters
from cavalcade.geometry import inverse_transform_points
from cavalcade.world import Box, Circle, OccupancyMap, Polygon

GRIDS = hnp.arrays(bool, hnp.array_shapes(min_dims=2, max_dims=2, max_side=12))


def inside(block, points):
    """Whether points `(N, 2)` lie in a block or on its edge."""
    local = inverse_transform_points(block.pose, points)
    if block.kind == "cylinder":
        return np.hypot(*local.T) <= block.half[0]
    return (np.abs(local) <= np.array(block.half) + 1e-9).all(axis=1)


def beside_free(grid, row, col):
    rows, cols = grid.shape
    around = [(r, c) for r in range(row - 1, row + 2) for c in range(col - 1, col + 2)]
    return any(0 <= r < rows and 0 <= c < cols and not grid[r, c] for r, c in around)


@settings(deadline=None)
@given(GRIDS)
def test_rectangles_are_occupied_and_hold_every_cell_that_can_be_touched(grid):
    covered = np.zeros_like(grid)
    for low, high, left, right in cover(grid):
        assert low < high
        assert left < right
        assert grid[low:high, left:right].all()
        covered[low:high, left:right] = True
    for row, col in np.argwhere(grid):
        if beside_free(grid, row, col):
            assert covered[row, col]


@settings(deadline=None)
@given(GRIDS)
def test_every_rectangle_is_needed_by_a_cell_of_its_own_when_it_is_made(grid):
    assert len(cover(grid)) <= grid.sum()


def test_simple_grids_take_as_few_as_they_can():
    assert len(cover(np.zeros((5, 5), bool))) == 0
    wall = np.zeros((9, 9), bool)
    wall[4, :] = True
    assert cover(wall).tolist() == [[4, 5, 0, 9]]
    wall[:, 4] = True
    assert len(cover(wall)) == 2
    ring = np.ones((9, 9), bool)
    ring[2:7, 2:7] = False
    assert len(cover(ring)) == 4


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.0])
def test_blocks_of_a_map_fill_its_occupied_cells_and_leave_the_free_ones(yaw):
    random = np.random.default_rng(1)
    grid = random.random((12, 17)) < 0.3
    map = OccupancyMap(grid, 0.1, (1.0, -2.0, yaw))
    blocks = blocks_of_map(map)
    cells = np.argwhere(np.ones_like(grid))
    hit = np.any([inside(block, map.centers(cells)) for block in blocks], axis=0)
    edge = np.array([beside_free(grid, *cell) for cell in cells]).reshape(grid.shape)
    assert not hit.reshape(grid.shape)[~grid].any()
    assert hit.reshape(grid.shape)[grid & edge].all()


def test_walls_stand_around_a_map():
    map = OccupancyMap.empty((4.0, 3.0), 0.05)
    blocks = blocks_of_map(map)
    assert len(blocks) == 4
    beyond = np.array([[-0.1, 1.0], [4.1, 1.0], [2.0, -0.1], [2.0, 3.1], [-0.1, -0.1], [4.1, 3.1]])
    within = np.array([[0.02, 1.0], [3.98, 2.98], [2.0, 1.5]])
    assert np.any([inside(block, beyond) for block in blocks], axis=0).all()
    assert not np.any([inside(block, within) for block in blocks], axis=0).any()


def test_boxes_and_circles_are_exact():
    (box,) = blocks_of_shape(Box((1.0, 2.0), (0.4, 0.2), 0.3))
    assert (box.kind, box.pose, box.half) == ("box", (1.0, 2.0, 0.3), (0.2, 0.1))
    (circle,) = blocks_of_shape(Circle((1.0, 2.0), 0.3))
    assert (circle.kind, circle.pose[:2], circle.half) == ("cylinder", (1.0, 2.0), (0.3, 0.3))


def test_a_polygon_is_filled_to_within_a_cell():
    polygon = Polygon(((0.0, 0.0), (1.0, 0.2), (0.4, 0.4), (0.3, 1.1)))
    blocks = blocks_of_shape(polygon, 0.05)
    points = np.random.default_rng(2).uniform(-0.3, 1.4, (3000, 2))
    hit = np.any([inside(block, points) for block in blocks], axis=0)
    away = polygon.distance(points)
    assert hit[away == 0.0].mean() > 0.99  # all but what lies deep inside
    assert not hit[away > 0.05 * math.sqrt(2.0)].any()


@settings(deadline=None)
@given(st.integers(0, 400), st.integers(0, 2**31))
def test_clusters_are_all_blocks_in_few_groups(count, seed):
    random = np.random.default_rng(seed)
    blocks = [
        blocks_of_shape(Circle((float(x), float(y)), 0.1))[0]
        for x, y in random.uniform(0.0, 20.0, (count, 2))
    ]
    groups = clusters(blocks)
    assert sorted(b.pose for group in groups for b in group) == sorted(b.pose for b in blocks)
    assert len(groups) <= 128
    assert max((len(group) for group in groups), default=0) <= max(3, math.ceil(count / 50))
