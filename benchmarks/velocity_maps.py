"""The maps that the benchmarks solve: FM2 velocity maps of seeded clutter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

CELL = 0.05
"""m"""

SIZES = ((200, 280), (1000, 1000), (2048, 2048))
"""Rows and columns; the first is the 14 x 10 m arena."""

_PER_SQUARE_METRE = 45 / (8.4 * 10.0)


def velocity_map(
    rows: int, cols: int, seed: int = 0, inflate: float = 0.30, safe: float = 1.50
) -> NDArray[np.float64]:
    """Velocities `(rows, cols)` from 0 to 1 around random discs and boxes.

    As the paper makes them: 1 from `safe` m away from what is inflated by `inflate` m, falling
    evenly to 0.
    """
    rng = np.random.default_rng(seed)
    width, height = cols * CELL, rows * CELL
    occupied = np.zeros((rows, cols), dtype=bool)
    y, x = (np.mgrid[:rows, :cols] + 0.5) * CELL
    for _ in range(round(_PER_SQUARE_METRE * (width - 5.6) * height)):
        centre = rng.uniform((2.8, 0.0), (width - 2.8, height))
        yaw = rng.uniform(0.0, np.pi)
        half = rng.uniform((0.2, 0.2), (1.4, 0.6)) / 2.0
        round_one, radius = rng.random() < 0.5, rng.uniform(0.1, 0.35)
        reach = radius if round_one else float(np.hypot(*half))
        rows_near = slice(*_cells(centre[1], reach, rows))
        cols_near = slice(*_cells(centre[0], reach, cols))
        dx, dy = x[rows_near, cols_near] - centre[0], y[rows_near, cols_near] - centre[1]
        if round_one:
            inside = np.hypot(dx, dy) <= radius
        else:
            c, s = np.cos(yaw), np.sin(yaw)
            inside = (np.abs(c * dx + s * dy) <= half[0]) & (np.abs(c * dy - s * dx) <= half[1])
        occupied[rows_near, cols_near] |= inside
    inflated = distance_transform_edt(~occupied) * CELL <= inflate
    speed: NDArray[np.float64] = np.minimum(distance_transform_edt(~inflated) * CELL / safe, 1.0)
    return speed


def free_cell_near(speed: NDArray[np.float64], row: int, col: int) -> tuple[int, int]:
    """The cell of full speed closest to [row, col]."""
    rows, cols = np.nonzero(speed >= speed.max())
    nearest = np.argmin((rows - row) ** 2 + (cols - col) ** 2)
    return int(rows[nearest]), int(cols[nearest])


def _cells(middle: float, reach: float, count: int) -> tuple[int, int]:
    low = int(np.floor((middle - reach) / CELL)) - 1
    high = int(np.ceil((middle + reach) / CELL)) + 2
    return max(low, 0), min(max(high, 0), count)
