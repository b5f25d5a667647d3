from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.metrics.lower_bound import ShortestPaths
from cavalcade.world import Box, Circle, OccupancyMap

FREE = OccupancyMap.empty((8.0, 6.0), 0.05)
RADIUS = 0.14


@settings(max_examples=20, deadline=None)
@given(st.floats(0.2, 7.8), st.floats(0.2, 5.8), st.floats(0.2, 7.8), st.floats(0.2, 5.8))
def test_on_free_ground_it_is_the_straight_line(x0: float, y0: float, x1: float, y1: float) -> None:
    length = ShortestPaths(FREE, RADIUS).length((x0, y0), (x1, y1))
    assert length == pytest.approx(np.hypot(x1 - x0, y1 - y0))


def test_around_a_wall_it_is_nearly_the_taut_string() -> None:
    paths = ShortestPaths(FREE.with_shapes([Box((4.0, 2.0), (0.2, 4.0))]), RADIUS)
    start, goal = (1.0, 2.0), (7.0, 2.0)
    around = np.hypot(2.9, 2.0) * 2 + 0.2
    length = paths.length(start, goal)
    assert length is not None
    # Never longer than the disc's own way, and at most by its radius at each corner shorter.
    disc = np.hypot(2.9, 2.0 + RADIUS) * 2 + 0.2
    assert around - 0.1 <= length <= disc
    assert paths.length(goal, start) == pytest.approx(length, abs=0.02)


def test_around_a_disc() -> None:
    paths = ShortestPaths(FREE.with_shapes([Circle((4.0, 3.0), 1.0)]), RADIUS)
    length = paths.length((1.0, 3.0), (7.0, 3.0))

    def string(radius: float) -> float:
        tangent = np.sqrt(9.0 - radius**2)
        return float(2 * tangent + radius * (np.pi - 2 * np.arccos(radius / 3.0)))

    assert length is not None
    assert string(1.0) - 0.02 <= length <= string(1.0 + RADIUS) + 1e-3


def test_no_way_is_none() -> None:
    closed = FREE.with_shapes([Box((4.0, 3.0), (0.2, 6.0))])
    assert ShortestPaths(closed, RADIUS).length((1.0, 3.0), (7.0, 3.0)) is None


@pytest.mark.parametrize("end", [(-1.0, 3.0), (4.0, 3.0), (9.0, 9.0)])
def test_ends_that_cannot_be_are_none(end: tuple[float, float]) -> None:
    paths = ShortestPaths(FREE.with_shapes([Box((4.0, 3.0), (1.0, 1.0))]), RADIUS)
    assert paths.length((1.0, 3.0), end) is None
    assert paths.length(end, (1.0, 3.0)) is None


def test_too_narrow_a_gap_is_closed_and_a_wide_one_open() -> None:
    def through(gap: float) -> float | None:
        walls = [
            Box((4.0, 1.5 - gap / 4), (0.2, 3.0 - gap / 2)),
            Box((4.0, 4.5 + gap / 4), (0.2, 3.0 - gap / 2)),
        ]
        return ShortestPaths(FREE.with_shapes(walls), 0.30).length((1.0, 3.0), (7.0, 3.0))

    assert through(0.10) is None
    assert through(0.62) == pytest.approx(6.0)


def test_a_start_beside_an_obstacle_is_fine() -> None:
    """A body may stand closer to a wall than the raster shows."""
    walls = FREE.with_shapes([Box((4.0, 3.0), (1.0, 1.0))])
    assert ShortestPaths(walls, RADIUS).length((3.35, 3.0), (1.0, 3.0)) == pytest.approx(2.35)


def test_a_map_turned_in_its_frame() -> None:
    turned = OccupancyMap(FREE.grid, FREE.resolution, (3.0, -1.0, 0.7))
    ends = turned.to_map([(1.0, 1.0), (6.0, 4.0)])
    assert ShortestPaths(turned, RADIUS).length(*ends) == pytest.approx(np.hypot(5.0, 3.0))
