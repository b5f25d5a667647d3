"""Where robots may start: judged by their oriented footprints."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import ScenarioError
from cavalcade.geometry import inverse_transform_points, rectangle_corners, transform_points
from cavalcade.scenario import build_world, parse_scenario
from cavalcade.world import Box, Circle, OccupancyMap, Polygon, Shape, save_map
from cavalcade.world.gaps import gap_between

Data = dict[str, Any]


def _build(data: Data, *starts: list[float]) -> None:
    data["robots"] = [{"start": start} for start in starts]
    build_world(parse_scenario(data, "a.yaml"))


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ([4.0, 2.0, 0.0], "stands in world.obstacles[0] at ("),
        ([6.4, 4.0, 0.0], "stands in world.obstacles[1]"),
        ([3.2, 4.2, 0.0], "stands in world.obstacles[2]"),
        ([3.8, 4.6, math.pi / 4], "stands in world.obstacles[2]"),
        ([0.3, 2.5, 0.0], "reaches beyond the map"),
        ([9.0, 2.5, 0.0], "reaches beyond the map"),
        ([2.0, 4.9, 0.0], "reaches beyond the map, which spans x from 0 to "),
    ],
)
def test_starts_in_obstacles_or_outside(data: Data, start: list[float], message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        _build(data, [1.0, 1.0, 0.0], start)
    assert str(caught.value).startswith("a.yaml: robots[1].start: the robot at (")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "start",
    [
        [0.3, 2.5, math.pi / 2],  # across, it fits where it does not along
        [6.6, 4.0, 0.0],
        [6.0, 3.6, 0.0],
        [3.8, 4.6, math.pi * 0.75],
    ],
)
def test_close_is_not_in(data: Data, start: list[float]) -> None:
    _build(data, [1.0, 1.0, 0.0], start)


@pytest.mark.parametrize(
    ("other", "overlap"),
    [
        ([2.0, 1.0, 0.0], True),
        ([2.0, 1.0, 0.3], True),
        ([2.5, 1.0, 0.0], True),
        ([2.0, 1.27, 0.0], True),
        ([2.4, 1.2, math.pi / 2], True),
        ([2.65, 1.0, 0.0], True),  # they touch
        ([2.0, 1.28, 0.0], True),
        ([2.651, 1.0, 0.0], False),
        ([2.0, 1.281, 0.0], False),
        ([2.47, 1.0, math.pi / 2], False),
    ],
)
def test_two_robots_need_two_places(data: Data, other: list[float], overlap: bool) -> None:
    if not overlap:
        _build(data, [2.0, 1.0, 0.0], other)
        return
    with pytest.raises(
        ScenarioError, match=r"robots\[1\]\.start: .* overlaps robot 0 at \(2\.000, 1\.000\)"
    ):
        _build(data, [2.0, 1.0, 0.0], other)


def test_occupied_cells_of_a_map_are_obstacles(tmp_path: Path, data: Data) -> None:
    grid = np.zeros((100, 160), dtype=bool)
    grid[40:44, 60:64] = True  # x 3.0 to 3.2, y 2.0 to 2.2
    save_map(OccupancyMap(grid, 0.05), tmp_path / "m.yaml")
    data["world"] = {"map": str(tmp_path / "m.yaml")}
    _build(data, [1.0, 1.0, 0.0], [2.67, 2.1, 0.0])
    with pytest.raises(ScenarioError, match="stands in an obstacle of the map"):
        _build(data, [1.0, 1.0, 0.0], [2.68, 2.1, 0.0])


@pytest.mark.parametrize(
    ("start", "problem"),
    [
        ([2.75, 2.13, 0.0], "an obstacle of the map at (3.025, 2.125) (8 cells of 0.05 m)"),
        ([5.0, 3.0, 0.0], "an obstacle of the map at (5.125, 3.025) (one cell of 0.05 m)"),
        ([4.95, 3.16, 0.0], "an obstacle of the map at (5.125, 3.025) (one cell of 0.05 m)"),
    ],
)
def test_a_start_on_a_speck_was_not_told_where_it_is(
    tmp_path: Path, data: Data, start: list[float], problem: str
) -> None:
    grid = np.zeros((100, 160), dtype=bool)
    grid[40:44, 60:64] = True  # x 3.0 to 3.2, y 2.0 to 2.2
    grid[60, 102] = True
    save_map(OccupancyMap(grid, 0.05), tmp_path / "m.yaml")
    data["world"] = {"map": str(tmp_path / "m.yaml")}
    with pytest.raises(ScenarioError) as caught:
        _build(data, [1.0, 1.0, 0.0], start)
    assert "robots[1].start: the robot at (" in str(caught.value)
    assert f"stands in {problem}; expected free ground" in str(caught.value)


def test_a_place_on_a_turned_map_is_one_of_the_map_frame(tmp_path: Path, data: Data) -> None:
    grid = np.zeros((100, 160), dtype=bool)
    grid[40, 60] = True
    origin = (1.0, -2.0, math.pi / 2)
    save_map(OccupancyMap(grid, 0.05, origin), tmp_path / "m.yaml")
    data["world"] = {"map": str(tmp_path / "m.yaml")}
    x, y = transform_points(origin, [(3.025, 2.025)])[0]
    with pytest.raises(ScenarioError, match=rf"at \({x:.3f}, {y:.3f}\) \(one cell"):
        _build(data, [x, y, 0.0])
    with pytest.raises(ScenarioError, match="between its corners"):
        _build(data, [9.0, 9.0, 0.0])


_SHAPES = st.one_of(
    st.builds(
        Box,
        st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
        st.tuples(st.floats(0.1, 2), st.floats(0.1, 2)),
        st.floats(-4, 4),
    ),
    st.builds(Circle, st.tuples(st.floats(-2, 2), st.floats(-2, 2)), st.floats(0.05, 1.5)),
    st.builds(
        lambda x, y, s: Polygon(
            tuple(
                (x + s * a, y + s * b) for a, b in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))
            )
        ),
        st.floats(-3, 2),
        st.floats(-3, 2),
        st.floats(0.1, 1.0),
    ),
)


@given(_SHAPES, st.floats(-1, 1), st.floats(-1, 1), st.floats(-4, 4))
@settings(max_examples=200, deadline=None)
def test_overlap_agrees_with_dense_sampling(shape: Shape, x: float, y: float, yaw: float) -> None:
    length, width = 0.65, 0.28
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 40), np.linspace(-0.5, 0.5, 20))
    inside = transform_points((x, y, yaw), np.c_[u.ravel() * length, v.ravel() * width])
    distance = float(shape.distance(inside).min())
    found = gap_between(Box((x, y), (length, width), yaw), shape) == 0.0
    if distance == 0.0:
        assert found
    elif distance > 0.03:  # beyond the spacing of the samples
        assert not found


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-4, 4))
@settings(max_examples=50, deadline=None)
def test_overlap_does_not_depend_on_who_is_asked(x: float, y: float, yaw: float) -> None:
    one, other = Box((0.1, 0.2), (0.65, 0.28), 0.4), Box((x, y), (0.65, 0.28), yaw)
    assert gap_between(one, other) == pytest.approx(gap_between(other, one), abs=1e-12)
    if gap_between(one, other) == 0.0:
        seen = inverse_transform_points((0.1, 0.2, 0.4), rectangle_corners((x, y, yaw), 0.65, 0.28))
        assert np.abs(seen).min() < 2.0
