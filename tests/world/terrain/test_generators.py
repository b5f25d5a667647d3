"""Generated terrains are what their options say, and the same for the same seed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import label

from cavalcade.errors import InputError
from cavalcade.world import TERRAINS, Terrain, generate_terrain

SIZE = (9.0, 4.0)


@pytest.mark.parametrize("kind", TERRAINS)
def test_the_same_seed_gives_the_same_terrain(kind: str) -> None:
    one, other = (generate_terrain(kind, SIZE, 3) for _ in range(2))
    assert one == other
    assert one.size == pytest.approx(SIZE)
    assert one.origin == (0.0, 0.0, 0.0)
    differs = generate_terrain(kind, SIZE, 4) != one
    assert differs == (kind in ("blocks", "rough", "stepping-stones"))


@pytest.mark.parametrize("kind", TERRAINS)
def test_the_ground_at_both_ends_is_level_and_good(kind: str) -> None:
    terrain = generate_terrain(kind, SIZE, 1)
    for columns in (terrain.height[:, :14], terrain.height[:, -14:]):
        assert np.ptp(columns) == pytest.approx(0.0, abs=1e-12)
    assert (terrain.traversability[:, :12] > 0.9).all()
    assert (terrain.traversability[:, -12:] > 0.9).all()


@pytest.mark.parametrize("kind", ["gap", "slope", "stairs", "step"])
def test_what_lies_across_spans_the_whole_width(kind: str) -> None:
    terrain = generate_terrain(kind, SIZE, 1)
    assert (terrain.height == terrain.height[0]).all()
    for layer in (terrain.smooth[8:-8], terrain.traversability[8:-8]):  # less of a disc at edges
        assert layer == pytest.approx(np.tile(layer[0], (len(layer), 1)), abs=1e-9)


@pytest.mark.parametrize("width", [0.2, 0.4, 0.6])
def test_a_gap_is_as_wide_and_deep_as_asked(width: float) -> None:
    terrain = generate_terrain("gap", SIZE, width=width, depth=1.5, at=3.0)
    row = terrain.height[0]
    pit = np.flatnonzero(row < -1.0) * 0.05
    assert row.min() == -1.5
    assert len(pit) * 0.05 == pytest.approx(width)
    assert pit[0] == pytest.approx(3.0 - width / 2.0)
    # As in the published planner, feet stay a cell away on both sides.
    assert (terrain.traversability[0] == 0.0).sum() * 0.05 == pytest.approx(width + 0.1)
    assert terrain.smooth == pytest.approx(np.zeros(terrain.smooth.shape))


@pytest.mark.parametrize("height", [0.1, 0.25, -0.2])
def test_a_step_is_as_high_as_asked(height: float) -> None:
    row = generate_terrain("step", SIZE, height=height, at=5.0).height[0]
    assert (row[:100] == 0.0).all()
    assert (row[100:] == height).all()


def test_stairs_have_their_steps() -> None:
    row = generate_terrain("stairs", SIZE, steps=4, height=0.15, tread=0.5).height[0]
    jumps = np.flatnonzero(np.diff(row) > 1e-9)
    assert np.diff(row)[jumps] == pytest.approx([0.15] * 4)
    assert np.diff(jumps).tolist() == [10, 10, 10]
    assert row[-1] == pytest.approx(0.6)


def test_a_slope_is_as_steep_as_asked() -> None:
    terrain = generate_terrain("slope", SIZE, angle=-0.3, length=3.0)
    assert terrain.height[0, -1] == pytest.approx(-3.0 * math.tan(0.3))
    assert terrain.normals[40, 90] == pytest.approx([math.sin(0.3), 0.0, math.cos(0.3)])
    assert terrain.traversability[40, 90] == pytest.approx(0.5 + 0.5 * (1 - 0.3 / 0.4) + 0.02)


def test_rough_ground_has_its_height() -> None:
    terrain = generate_terrain("rough", (10.0, 8.0), 1, height=0.25)
    assert terrain.height.min() == 0.0
    assert 0.2 < terrain.height.max() <= 0.25
    assert (terrain.traversability > 0.0).all()


def test_blocks_are_level_and_side_by_side() -> None:
    terrain = generate_terrain("blocks", (6.0, 2.0), 1, 0.05, height=0.05, side=0.25, zone=1.0)
    inside = terrain.height[:, 20:-20].reshape(8, 5, 16, 5)
    assert (inside == inside[:, :1, :, :1]).all()
    blocks = inside[:, 0, :, 0]
    assert len(np.unique(blocks)) == blocks.size
    assert 0.0 <= blocks.min() < 0.01 < 0.04 < blocks.max() <= 0.05
    assert (terrain.height[:, :20] == 0.0).all()
    assert (terrain.height[:, -20:] == 0.0).all()


def test_stones_are_islands() -> None:
    terrain = generate_terrain("stepping-stones", SIZE, 2)
    islands, count = label(terrain.traversability > 0.0)
    assert count > 10
    assert islands[40, 0] != islands[40, -1]
    assert terrain.height.min() == -1.0
    assert np.ptp(terrain.height[terrain.traversability > 0.0]) <= 0.05


@pytest.mark.parametrize(
    ("kind", "size", "options", "message"),
    [
        ("hills", SIZE, {}, "kind: unknown kind 'hills' (one of: blocks, gap, rough"),
        ("gap", SIZE, {"height": 1.0}, "height: gap has no such option (one of: width, depth, at)"),
        ("gap", SIZE, {"width": -0.1}, "width: expected a number of at least 0"),
        ("gap", SIZE, {"at": 20.0}, "at: expected a number of at least 0.2 and at most 8.8"),
        ("gap", (0.3, 4.0), {}, "size: 0.3 m are too short for what lies across"),
        ("stairs", SIZE, {"steps": 100}, "size: 9 m are too short for what lies across"),
        ("stairs", SIZE, {"steps": 2.5}, "steps: expected an integer from 1 to 1000"),
        ("slope", SIZE, {"angle": 2.0}, "angle: expected a number of at least -1 and at most 1"),
        ("rough", SIZE, {"spacing": 0.0}, "spacing: expected a number of at least 0.2"),
        ("rough", SIZE, {"zone": 5.0}, "zone: expected a number of at least 0 and at most 4.5"),
        ("rough", (500.0, 500.0), {}, "size: 10000 x 10000 cells are too many"),
        ("rough", (0.05, 4.0), {}, "size: 80 x 1 cells are no terrain"),
        ("step", SIZE, {"resolution": 0.001}, "resolution: expected cells of 0.02 to 0.2 m"),
        ("step", SIZE, {"seed": -1}, "seed: expected an integer from 0"),
    ],
)
def test_bad_options_are_one_clear_line(
    kind: str, size: tuple[float, float], options: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError) as caught:
        generate_terrain(kind, size, **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_finer_cells_show_the_same_ground() -> None:
    coarse, fine = (generate_terrain("rough", SIZE, 5, cell) for cell in (0.1, 0.05))
    points = np.random.default_rng(0).uniform((1.5, 0.5), (7.5, 3.5), (200, 2))
    away = np.abs(coarse.heights_at(points) - fine.heights_at(points))
    assert np.median(away) < 0.01
    assert isinstance(fine, Terrain)
