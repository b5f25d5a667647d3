"""The layers that legs need: filled holes, smoothed ground, normals, traversability."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.geometry import Array
from cavalcade.world import Terrain
from cavalcade.world.terrain.filters import (
    disc,
    filled,
    find_pits,
    mean_within,
    normals_within,
)

CELL = 0.05


def _around(field: Array, row: int, col: int, radius: float) -> tuple[Array, Array, Array]:
    """x, y and z of the cells within a radius (in cells), seen from a cell: the slow way."""
    rows, cols = np.indices(field.shape)
    near = (rows - row) ** 2 + (cols - col) ** 2 <= radius**2 + 1e-9
    return (cols - col)[near] * CELL, (rows - row)[near] * CELL, field[near]


def _plane(field: Array, row: int, col: int, radius: float) -> Array:
    x, y, z = _around(field, row, col, radius)
    (a, b, _), *_ = np.linalg.lstsq(np.c_[x, y, np.ones_like(x)], z, rcond=None)
    normal = np.array([-a, -b, 1.0])
    return normal / np.linalg.norm(normal)


@pytest.mark.parametrize("radius", [0.0, 1.0, 1.5, 3.0, 4.0])
def test_means_and_normals_are_those_of_the_slow_way(radius: float) -> None:
    field = np.random.default_rng(0).uniform(0.0, 0.3, (9, 7))
    means = mean_within(field, disc(radius))
    normals = normals_within(field, disc(radius), CELL)
    for row in range(field.shape[0]):
        for col in range(field.shape[1]):
            assert means[row, col] == pytest.approx(_around(field, row, col, radius)[2].mean())
            if radius > 0.0:
                assert normals[row, col] == pytest.approx(_plane(field, row, col, radius))
            else:
                assert normals[row, col] == pytest.approx([0.0, 0.0, 1.0])


def test_a_line_of_cells_is_level_across() -> None:
    normals = normals_within(np.arange(5.0)[None, :] * CELL, disc(2.0), CELL)
    assert normals[0] == pytest.approx(np.tile([-1.0, 0.0, 1.0], (5, 1)) / np.sqrt(2.0))


@given(
    st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.floats(-5.0, 5.0), st.sampled_from([0.02, 0.2])
)
@settings(deadline=None, max_examples=30)
def test_planes_have_their_own_normal(a: float, b: float, c: float, cell: float) -> None:
    y, x = (np.indices((6, 8)) + 0.5) * cell
    layers = Terrain.from_heights(a * x + b * y + c, cell)
    normal = np.array([-a, -b, 1.0]) / np.sqrt(a * a + b * b + 1.0)
    # Smoothing tilts a plane at the grid's edge, where the means are one-sided.
    assert normals_within(a * x + b * y + c, disc(2.0), cell) == pytest.approx(
        np.broadcast_to(normal, (6, 8, 3)), abs=1e-9
    )
    assert np.linalg.norm(layers.normals, axis=2) == pytest.approx(np.ones((6, 8)))


def test_level_ground_is_all_good() -> None:
    layers = Terrain.from_heights(np.full((5, 9), 1.7), CELL)
    assert (layers.height == 1.7).all()
    assert layers.smooth == pytest.approx(layers.height)
    assert layers.normals == pytest.approx(np.broadcast_to([0.0, 0.0, 1.0], (5, 9, 3)))
    assert layers.traversability == pytest.approx(np.ones((5, 9)))


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 3.0))
@settings(deadline=None, max_examples=30)
def test_traversability_is_the_formula_of_the_layers(seed: int, size: float) -> None:
    heights = np.random.default_rng(seed).uniform(0.0, 0.1 * size, (12, 10))
    layers = Terrain.from_heights(heights, CELL)
    normal = normals_within(heights, disc(3.0), CELL)
    rough, slope = np.abs(heights - layers.smooth), np.arccos(normal[..., 2])
    ground = 0.5 * (1.0 - rough / 0.1) + 0.5 * (1.0 - slope / 0.4)
    expected = np.minimum(np.maximum(ground, 0.0) + 0.02, 1.0)
    assert layers.traversability == pytest.approx(expected)
    assert layers.traversability.min() >= 0.02


def test_the_higher_the_ground_moves_the_same_it_stays() -> None:
    heights = np.random.default_rng(1).uniform(0.0, 0.3, (20, 20))
    one, other = Terrain.from_heights(heights, CELL), Terrain.from_heights(heights + 100.0, CELL)
    assert other.smooth - 100.0 == pytest.approx(one.smooth)
    assert other.traversability == pytest.approx(one.traversability, abs=1e-6)


@pytest.mark.parametrize("flip", [(1, -1), (-1, 1), (-1, -1)])
def test_mirrored_ground_has_mirrored_layers(flip: tuple[int, int]) -> None:
    heights = np.random.default_rng(2).uniform(0.0, 0.9, (30, 24))
    heights[3:6, 4:9] = np.nan
    view = (slice(None, None, flip[0]), slice(None, None, flip[1]))
    one, other = Terrain.from_heights(heights, CELL), Terrain.from_heights(heights[view], CELL)
    assert other.smooth == pytest.approx(one.smooth[view], abs=1e-2)
    assert (other.traversability == 0.0).tolist() == (one.traversability[view] == 0.0).tolist()


def test_no_foot_stands_in_a_hole_or_beside_it() -> None:
    heights = np.zeros((9, 9))
    heights[4, 4] = np.nan
    layers = Terrain.from_heights(heights, CELL)
    beside = np.zeros((9, 9), dtype=bool)
    beside[3:6, 3:6] = True  # 0.075 m reach to the diagonal neighbours of 0.05 m cells
    assert ((layers.traversability == 0.0) == beside).all()
    assert layers.height == pytest.approx(np.zeros((9, 9)))


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.95))
@settings(deadline=None, max_examples=40)
def test_what_fills_holes_lies_between_what_is_known(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    heights = rng.uniform(-1.0, 1.0, (11, 13))
    holes = rng.uniform(size=heights.shape) < share
    holes[rng.integers(11), rng.integers(13)] = False
    whole = filled(np.where(holes, np.nan, heights), holes)
    assert (whole[~holes] == heights[~holes]).all()
    assert np.isfinite(whole).all()
    assert whole.min() >= heights[~holes].min() - 1e-12
    assert whole.max() <= heights[~holes].max() + 1e-12


def test_a_slope_goes_on_through_a_hole() -> None:
    heights = np.tile(np.arange(20.0) * 0.02, (20, 1))
    holes = np.zeros(heights.shape, dtype=bool)
    holes[6:14, 7:12] = True
    whole = filled(np.where(holes, np.nan, heights), holes)
    assert whole == pytest.approx(heights, abs=5e-3)


class TestPits:
    """Narrow and deep is a hole, whatever the file says of it."""

    def test_a_deep_trench_is_one_and_the_smoothed_ground_goes_over_it(self) -> None:
        heights = np.zeros((40, 60))
        heights[:, 26:34] = -1.0
        layers = Terrain.from_heights(heights, CELL)
        assert find_pits(heights, CELL).sum() == 40 * 8
        assert (layers.height == heights).all()
        assert layers.smooth == pytest.approx(np.zeros((40, 60)))
        assert (layers.traversability[:, 25:35] == 0.0).all()
        assert layers.traversability[:, :25] == pytest.approx(np.ones((40, 25)))

    @pytest.mark.parametrize(("depth", "width"), [(0.4, 8), (2.0, 30)])
    def test_shallow_or_wide_ground_is_none(self, depth: float, width: int) -> None:
        heights = np.zeros((40, 80))
        heights[:, 20 : 20 + width] = -depth
        assert not find_pits(heights, CELL).any()

    def test_ground_between_a_wall_and_the_border_is_none(self) -> None:
        heights = np.zeros((40, 40))
        heights[10:30, 10:30] = 0.8
        assert not find_pits(heights, CELL).any()

    def test_high_ground_is_none(self) -> None:
        heights = np.zeros((40, 40))
        heights[:, 18:22] = 1.0
        assert not find_pits(heights, CELL).any()
