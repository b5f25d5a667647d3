"""A slow, obvious fast march to compare with, and what a path must obey."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

Grid = NDArray[np.float64]
Cell = tuple[int, int]


def _upwind(times: Grid, delay: Grid, r: int, c: int) -> float:
    """The first-order scheme's time of a cell from its neighbours' times."""

    def at(i: int, j: int) -> float:
        inside = 0 <= i < times.shape[0] and 0 <= j < times.shape[1]
        return float(times[i, j]) if inside else math.inf

    early, late = sorted((min(at(r - 1, c), at(r + 1, c)), min(at(r, c - 1), at(r, c + 1))))
    q = float(delay[r, c])
    if early == math.inf or q == math.inf:
        return math.inf
    if late - early >= q:
        return early + q
    return 0.5 * (early + late + math.sqrt(2.0 * q * q - (late - early) ** 2))


def _march(speed: Grid, seeds: dict[Cell, float], cell: float) -> Grid:
    """Sethian's fast marching with a binary heap; `seeds` are cells with their times."""
    rows, cols = speed.shape
    delay = np.full(speed.shape, math.inf)
    np.divide(cell, speed, out=delay, where=speed > 0.0)
    times = np.full(speed.shape, math.inf)
    heap = []
    for place, time in seeds.items():
        times[place] = time
        heapq.heappush(heap, (time, place))
    while heap:
        time, (r, c) = heapq.heappop(heap)
        if time > times[r, c]:
            continue
        for i, j in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
            if 0 <= i < rows and 0 <= j < cols:
                new = _upwind(times, delay, i, j)
                if new < times[i, j]:
                    times[i, j] = new
                    heapq.heappush(heap, (new, (i, j)))
    return times


def _check_path(points: Grid, speed: Grid, cell: float, start: Grid, goal: Grid) -> None:
    """From start to goal, in free cells only, past no corner, without turning on the spot."""
    assert points.shape[0] >= 1
    assert np.isfinite(points).all()
    np.testing.assert_allclose(points[0], start, atol=1e-9 * cell + 1e-12)
    np.testing.assert_allclose(points[-1], goal, atol=1e-9 * cell + 1e-12)
    scaled = points / cell
    # All segments at once, each cut into parts of a sixteenth of a cell.
    ahead = np.diff(scaled, axis=0)
    parts = np.maximum(np.ceil(np.hypot(*ahead.T) * 16).astype(int), 1)
    segment = np.repeat(np.arange(len(ahead)), parts)
    share = (np.arange(len(segment)) - (np.cumsum(parts) - parts)[segment]) / parts[segment]
    along = np.vstack([scaled[segment] + share[:, None] * ahead[segment], scaled[-1:]])
    cols, rows = np.floor(along).astype(int).T
    inside = (rows >= 0) & (rows < speed.shape[0]) & (cols >= 0) & (cols < speed.shape[1])
    assert inside.all(), "the path leaves the map"
    assert (speed[rows, cols] > 0.0).all(), "the path leaves the free cells"
    across = np.flatnonzero((np.diff(rows) != 0) & (np.diff(cols) != 0))
    assert (speed[rows[across], cols[across + 1]] > 0.0).all(), "the path cuts a corner"
    assert (speed[rows[across + 1], cols[across]] > 0.0).all(), "the path cuts a corner"


@pytest.fixture(scope="session")
def upwind() -> Callable[[Grid, Grid, int, int], float]:
    return _upwind


@pytest.fixture(scope="session")
def slow_march() -> Callable[[Grid, dict[Cell, float], float], Grid]:
    return _march


@pytest.fixture(scope="session")
def check_path() -> Callable[[Grid, Grid, float, Grid, Grid], None]:
    return _check_path


@pytest.fixture(scope="session")
def clutter() -> Callable[..., Grid]:
    """Speeds `(rows, cols)` between 0 and 1 around random blocks, as FM2 makes them."""

    def make(rows: int, cols: int, seed: int, blocks: int = 12) -> Grid:
        from cavalcade.eikonal import surface_distance, velocity_map

        rng = np.random.default_rng(seed)
        occupied = np.zeros((rows, cols), dtype=bool)
        for _ in range(blocks):
            r, c = rng.integers(rows), rng.integers(cols)
            occupied[r : r + rng.integers(1, 6), c : c + rng.integers(1, 6)] = True
        return velocity_map(surface_distance(occupied, 0.05, border=False), 0.08, 0.4)

    return make
