"""Specks of maps: small groups of obstacle cells, which planners may be told to ignore."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cavalcade.errors import MapError, ScenarioError
from cavalcade.scenario import build_world, load_scenario, parse_scenario
from cavalcade.world import Circle, OccupancyMap, load_map, save_map


def _reference(grid: np.ndarray, occupied: np.ndarray, cells: int) -> np.ndarray:
    """Flood fill from every obstacle cell; slow and obvious."""
    rows, cols = grid.shape
    out = grid.copy()
    for row, col in np.argwhere(occupied):
        group, todo, border = set(), [(row, col)], False
        while todo:
            r, c = todo.pop()
            if not (0 <= r < rows and 0 <= c < cols):
                border = True
            elif occupied[r, c] and (r, c) not in group:
                group.add((r, c))
                todo += [(r + i, c + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        high = max(max(r for r, _ in group) - min(r for r, _ in group), 0) + 1
        wide = max(max(c for _, c in group) - min(c for _, c in group), 0) + 1
        if not border and max(high, wide) <= cells:
            out[row, col] = 0
    return out


@settings(max_examples=150, deadline=None)
@given(
    hnp.arrays(
        np.int8,
        hnp.array_shapes(min_dims=2, max_dims=2, max_side=9),
        elements=st.sampled_from([0, 0, 0, 0, 100, 70, 30, -1]),
    ),
    st.integers(0, 5),
    st.sampled_from(["occupied", "free"]),
)
def test_specks_are_those_of_the_slow_way(grid: np.ndarray, cells: int, unknown: str) -> None:
    map = OccupancyMap(grid, 0.05, (1.0, 2.0, 0.3), unknown)  # type: ignore[arg-type]
    cleaned = map.despeckled(cells * 0.05)
    np.testing.assert_array_equal(cleaned.grid, _reference(grid, map.occupied, cells))
    assert (cleaned.origin, cleaned.unknown) == (map.origin, map.unknown)


@pytest.mark.parametrize("resolution", [0.02, 0.05, 0.1, 0.25])
@pytest.mark.parametrize(
    ("side", "stays"), [(0.0, True), (0.499, True), (0.5, False), (1.0, False)]
)
def test_the_size_is_in_metres_whatever_the_cells(
    resolution: float, side: float, stays: bool
) -> None:
    grid = np.zeros((100, 100), dtype=bool)
    width = round(0.5 / resolution)
    grid[5 : 5 + width, 7 : 7 + width] = True
    assert OccupancyMap(grid, resolution).despeckled(side).occupied.any() == stays


@pytest.mark.parametrize("size", [-0.1, math.nan, math.inf, "0.1", None])
def test_sizes_that_are_none(size: float) -> None:
    with pytest.raises(MapError, match="size: expected"):
        OccupancyMap.empty((1, 1)).despeckled(size)


def _scenario(tmp_path: Path, **planner: object) -> dict:
    grid = np.zeros((80, 120), dtype=bool)
    grid[40, 60] = grid[20:30, 90] = True
    save_map(OccupancyMap(grid, 0.05), tmp_path / "m.yaml")
    return {
        "version": 1,
        "name": "specks",
        "world": {
            "map": str(tmp_path / "m.yaml"),
            "obstacles": [{"circle": {"center": [1.0, 3.0], "radius": 0.03}}],
        },
        "robots": [{"start": [1.0, 1.0, 0.0]}],
        "task": {"formation": {"shape": "line"}, "goals": [[5.0, 1.0, 0.0]]},
        "planner": planner,
    }


def test_planners_see_no_specks_and_the_world_keeps_them(tmp_path: Path) -> None:
    plain = build_world(parse_scenario(_scenario(tmp_path)))
    world = build_world(parse_scenario(_scenario(tmp_path, despeckle=0.1)))
    assert plain.map.occupied[40, 60]
    assert world.base == plain.base
    assert not world.map.occupied[40, 60]
    assert not world.map_with([]).occupied[40, 60]  # nor after an event
    assert world.map.occupied[20:30, 90].all()
    # Shapes are no specks, however small they are.
    assert world.map.occupied[60, 20]
    assert world.map_with([Circle((4.0, 3.0), 0.02)]).occupied[60, 80]


def test_starts_in_specks_are_starts_in_obstacles(tmp_path: Path) -> None:
    data = _scenario(tmp_path, despeckle=0.1)
    data["robots"] = [{"start": [3.0, 2.0, 0.0]}]
    with pytest.raises(ScenarioError, match="obstacle of the map"):
        build_world(parse_scenario(data))


def test_where_there_are_no_specks_the_key_is_refused(tmp_path: Path) -> None:
    data = _scenario(tmp_path, despeckle=0.1)
    data["world"] = {"empty": {"size": [6, 4]}}
    with pytest.raises(ScenarioError, match=r"planner\.despeckle: is for worlds from map files"):
        parse_scenario(data)
    data["planner"] = {"despeckle": 0}
    parse_scenario(data)


def test_a_cleaned_map_is_another_truth(shared_data: Callable[[str], Path], tmp_path: Path) -> None:
    source = load_map(shared_data("cases/specks.yaml"))
    cleaned = source.despeckled(0.05)
    assert (source.occupied & ~cleaned.occupied).sum() == 29
    save_map(cleaned, tmp_path / "specks.yaml")
    assert load_map(tmp_path / "specks.yaml") == cleaned
    scenario = load_scenario(
        shared_data("cases/specks-run.yaml"), {"world.map": str(tmp_path / "specks.yaml")}
    )
    assert build_world(scenario).base == cleaned
