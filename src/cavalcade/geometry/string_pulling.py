"""Paths over a grid and string pulling; compiled. Points are x, y in the grid's own frame, m.

Coordinates are copied one by one: numba takes seconds to compile `there[k] = here[n]`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kernels import kernel, subroutine

Mask = NDArray[np.bool_]


@kernel
def line_is_free(free: Mask, cell: float, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether all cells that the segment passes through are free, by stepping border to border."""
    rows, cols = free.shape
    col, row = int(math.floor(ax / cell)), int(math.floor(ay / cell))
    last_col, last_row = int(math.floor(bx / cell)), int(math.floor(by / cell))
    dx, dy = bx - ax, by - ay
    step_col, step_row = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    along_col = along_row = math.inf
    per_col = per_row = math.inf
    if dx != 0.0:
        border = (col + (1 if dx > 0.0 else 0)) * cell
        along_col, per_col = (border - ax) / dx, cell / abs(dx)
    if dy != 0.0:
        border = (row + (1 if dy > 0.0 else 0)) * cell
        along_row, per_row = (border - ay) / dy, cell / abs(dy)
    for _ in range(abs(last_col - col) + abs(last_row - row) + 1):
        if row < 0 or row >= rows or col < 0 or col >= cols or not free[row, col]:
            return False
        if along_col < along_row:
            along_col += per_col
            col += step_col
        else:
            along_row += per_row
            row += step_row
    return True


@kernel
def descend(times: Array, row: int, col: int) -> NDArray[np.int64]:
    """Cells `(K, 2)` from (row, col) down to the source, to the steepest of eight neighbours.

    A diagonal is taken only where both cells beside it are reached, so that it cuts no corner.
    """
    rows, cols = times.shape
    cells = np.empty((rows * cols, 2), dtype=np.int64)
    count = 0
    while True:
        cells[count, 0], cells[count, 1] = row, col
        count += 1
        best, best_row, best_col = 0.0, row, col
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                r, c = row + dr, col + dc
                if (dr == 0 and dc == 0) or r < 0 or r >= rows or c < 0 or c >= cols:
                    continue
                beside = math.isfinite(times[r, col]) and math.isfinite(times[row, c])
                if dr != 0 and dc != 0 and not beside:
                    continue
                drop = (times[row, col] - times[r, c]) / math.hypot(dr, dc)
                if drop > best:
                    best, best_row, best_col = drop, r, c
        if best <= 0.0 or count == rows * cols:
            return cells[:count]
        row, col = best_row, best_col


@subroutine
def _shortcut(free: Mask, cell: float, path: Array) -> Array:
    """The path with every point left out that the one before can do without seeing."""
    kept = np.empty_like(path)
    kept[0, 0], kept[0, 1] = path[0, 0], path[0, 1]
    count = 1
    anchor = 0
    for k in range(1, path.shape[0] - 1):
        if not line_is_free(
            free, cell, path[anchor, 0], path[anchor, 1], path[k + 1, 0], path[k + 1, 1]
        ):
            kept[count, 0], kept[count, 1] = path[k, 0], path[k, 1]
            count += 1
            anchor = k
    kept[count, 0], kept[count, 1] = path[-1, 0], path[-1, 1]
    return kept[: count + 1]


@subroutine
def _dense(path: Array, spacing: float) -> Array:
    """The path with points in between, at most `spacing` m apart."""
    total = 1
    for k in range(path.shape[0] - 1):
        gap = math.hypot(path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1])
        total += max(int(math.ceil(gap / spacing)), 1)
    dense = np.empty((total, 2))
    count = 0
    for k in range(path.shape[0] - 1):
        gap = math.hypot(path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1])
        parts = max(int(math.ceil(gap / spacing)), 1)
        for part in range(parts):
            along = part / parts
            dense[count, 0] = path[k, 0] + (path[k + 1, 0] - path[k, 0]) * along
            dense[count, 1] = path[k, 1] + (path[k + 1, 1] - path[k, 1]) * along
            count += 1
    dense[count, 0], dense[count, 1] = path[-1, 0], path[-1, 1]
    return dense


@subroutine
def _length(path: Array) -> float:
    """Summed over the segments, m."""
    total = 0.0
    for k in range(path.shape[0] - 1):
        total += math.hypot(path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1])
    return total


@subroutine
def _reversed(path: Array) -> Array:
    """The same from the other end."""
    turned = np.empty_like(path)
    for k in range(path.shape[0]):
        turned[k, 0], turned[k, 1] = path[-1 - k, 0], path[-1 - k, 1]
    return turned


@kernel
def string_pulled_length(free: Mask, cell: float, path: Array) -> float:
    """Length of a path `(K, 2)` after string pulling, from both ends in turn, while that helps."""
    length = _length(path)
    for _ in range(60):
        path = _reversed(_shortcut(free, cell, _dense(path, 0.5 * cell)))
        shorter = _length(path)
        # Two rounds, one from each end, without a gain of a tenth of a millimetre: done.
        if length - shorter < 1e-4:
            path = _reversed(_shortcut(free, cell, _dense(path, 0.25 * cell)))
            shorter = _length(path)
            if length - shorter < 1e-4:
                return min(length, shorter)
        length = shorter
    return length
