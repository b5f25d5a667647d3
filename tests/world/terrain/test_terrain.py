"""The terrain as a whole: what is accepted, where values lie, how long it takes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cavalcade.errors import MapError
from cavalcade.world import OccupancyMap, Terrain
from cavalcade.world.terrain.terrain import MAX_CELLS


def _hills(rows: int = 12, cols: int = 16, seed: int = 0) -> Terrain:
    heights = np.random.default_rng(seed).uniform(0.0, 0.2, (rows, cols))
    return Terrain.from_heights(heights, 0.05, (3.0, -1.0, 0.5))


def test_arrays_are_read_only_copies() -> None:
    heights = np.zeros((4, 5))
    terrain = Terrain.from_heights(heights)
    heights[0, 0] = 7.0
    assert terrain.height[0, 0] == 0.0
    for layer in (terrain.height, terrain.smooth, terrain.normals, terrain.traversability):
        with pytest.raises(ValueError, match="read-only"):
            layer[0] = 0.0


def test_size_and_equality() -> None:
    terrain = _hills()
    assert (terrain.rows, terrain.cols) == (12, 16)
    assert terrain.size == pytest.approx((0.8, 0.6))
    assert terrain == _hills()
    assert hash(terrain) == hash(_hills())
    assert terrain != _hills(seed=1)
    assert terrain != "hills"
    assert "12 x 16 cells" in repr(terrain)


def test_values_are_taken_in_the_map_frame() -> None:
    terrain = _hills()
    grid = OccupancyMap(np.zeros((12, 16), dtype=bool), 0.05, (3.0, -1.0, 0.5))
    cells = np.stack(np.meshgrid(np.arange(12), np.arange(16)), axis=-1).reshape(-1, 2)
    points = grid.centers(cells)
    for values, layer in (
        (terrain.heights_at(points), terrain.height),
        (terrain.smooth_at(points), terrain.smooth),
        (terrain.traversability_at(points), terrain.traversability),
    ):
        assert values == pytest.approx(layer[cells[:, 0], cells[:, 1]])
    assert not terrain.in_hole(points).any()


def test_a_hole_is_where_no_foot_may_stand() -> None:
    heights = np.zeros((20, 20))
    heights[10, 10] = np.nan
    terrain = Terrain.from_heights(heights)
    found = terrain.in_hole([(0.525, 0.525), (0.475, 0.575), (0.61, 0.525), (0.9, 0.1), (99, 99)])
    assert found.tolist() == [True, True, False, False, False]


def test_an_occupied_map_is_level_ground_with_holes() -> None:
    occupied = np.zeros((10, 12), dtype=bool)
    occupied[4, 5] = True
    map = OccupancyMap(occupied, 0.05, (1.0, 2.0, 0.3))
    terrain = Terrain.from_map(map)
    assert terrain.origin == map.origin
    assert (terrain.height == 0.0).all()
    assert (terrain.traversability == 0.0).sum() == 9
    with pytest.raises(MapError, match="all are nan"):
        Terrain.from_map(OccupancyMap(np.ones((4, 4), dtype=bool), 0.05))


_BIG = np.broadcast_to(np.float32(0.0), (5000, 5000))


@pytest.mark.parametrize(
    ("heights", "cell", "message"),
    [
        ([[1.0]], 0.05, "heights: 1 x 1 cells are no terrain; expected at least 2 x 2"),
        (np.zeros((1, 9)), 0.05, "1 x 9 cells are no terrain"),
        (np.zeros((0, 4)), 0.05, "0 x 4 cells are no terrain"),
        (np.full((4, 4), np.nan), 0.05, "heights: expected at least one height; all are nan"),
        ([[1.0, np.inf], [0.0, 0.0]], 0.05, "expected finite heights or nan for holes"),
        ([[1.0, 1e9], [0.0, 0.0]], 0.05, "expected heights within ±10000 m"),
        (np.zeros((2, 2, 2)), 0.05, "expected two dimensions (rows, cols), not 3"),
        ([[1.0], [1.0, 2.0]], 0.05, "expected a grid of numbers"),
        ([["a", "b"], ["c", "d"]], 0.05, "expected a grid of numbers"),
        (np.zeros((4, 4)), 0.001, "resolution: expected cells of 0.02 to 0.2 m for terrain"),
        (np.zeros((4, 4)), 1.0, "resolution: expected cells of 0.02 to 0.2 m for terrain"),
        (np.zeros((4, 4)), True, "resolution: expected cells of 0.02 to 0.2 m for terrain"),
        (np.zeros((4, 4)), np.nan, "resolution: expected cells of 0.02 to 0.2 m for terrain"),
        (_BIG, 0.05, "heights: 5000 x 5000 cells are too many, at most 4 million are allowed"),
    ],
)
def test_bad_heights_are_one_clear_line(heights: Any, cell: Any, message: str) -> None:
    with pytest.raises(MapError) as caught:
        Terrain.from_heights(heights, cell)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"smooth": np.zeros((3, 3))}, "smooth: expected (4, 4), not (3, 3)"),
        ({"normals": np.zeros((4, 4))}, "normals: expected 3 dimensions, not 2"),
        ({"height": np.full((4, 4), np.nan)}, "height: expected finite numbers"),
        ({"height": np.full((4, 4), 1e5)}, "height: expected heights within ±10000 m"),
        ({"traversability": np.full((4, 4), 1.5)}, "traversability: expected values from 0 to 1"),
        ({"origin": (0.0, 0.0)}, "origin: expected three numbers: x, y, yaw"),
        ({"smooth": "flat"}, "smooth: expected a grid of numbers"),
    ],
)
def test_bad_layers_are_one_clear_line(changes: dict[str, Any], message: str) -> None:
    level = Terrain.from_heights(np.zeros((4, 4)))
    names = ("height", "smooth", "normals", "traversability", "resolution", "origin")
    with pytest.raises(MapError) as caught:
        Terrain(**{name: getattr(level, name) for name in names} | changes)
    assert message in str(caught.value)


def test_a_hectare_is_taken() -> None:
    heights = np.random.default_rng(0).uniform(0.0, 0.3, (600, 600))
    heights[100:130, 200:260] = np.nan
    assert Terrain.from_heights(heights).height.shape == (600, 600)
    assert MAX_CELLS >= 360_000
