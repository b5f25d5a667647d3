"""Few rectangles that cover the occupied cells of a grid, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def at_the_edge(grid, row, col):
    """Whether one of the eight neighbours of a cell is free; beyond the grid nothing is."""
    rows, cols = grid.shape
    for r in range(max(row - 1, 0), min(row + 2, rows)):
        for c in range(max(col - 1, 0), min(col + 2, cols)):
            if not grid[r, c]:
                return True
    return False


@njit(cache=True)
def widest(grid, row, col):
    """The rectangle that grows to both sides along the row first, then down and up."""
    rows, cols = grid.shape
    left, right = col, col + 1
    while left > 0 and grid[row, left - 1]:
        left -= 1
    while right < cols and grid[row, right]:
        right += 1
    low, high = row, row + 1
    while low > 0 and grid[low - 1, left:right].all():
        low -= 1
    while high < rows and grid[high, left:right].all():
        high += 1
    return low, high, left, right


@njit(cache=True)
def cover(grid):
    """Rectangles of occupied cells that hold every occupied cell beside a free one.

    What lies deeper is covered as it comes: nothing gets there. Cell by cell in the order of
    rows, the first one that is not covered yet gets the rectangle through it that covers more
    new ones, of the widest and the highest.

    Args:
        grid: `(rows, cols)` bool, True where occupied.

    Returns:
        `(M, 4)` rows from, to, columns from, to (half-open).
    """
    rows, cols = grid.shape
    turned = np.ascontiguousarray(grid.T)
    wanted = np.zeros((rows, cols), dtype=np.bool_)
    for row in range(rows):
        for col in range(cols):
            wanted[row, col] = grid[row, col] and at_the_edge(grid, row, col)
    found = np.empty((16, 4), dtype=np.int64)
    count = 0
    for row in range(rows):
        for col in range(cols):
            if not wanted[row, col]:
                continue
            a, b, c, d = widest(grid, row, col)
            e, f, g, h = widest(turned, col, row)
            if wanted[g:h, e:f].sum() > wanted[a:b, c:d].sum():
                a, b, c, d = g, h, e, f
            wanted[a:b, c:d] = False
            if count == len(found):
                longer = np.empty((2 * count, 4), dtype=np.int64)
                longer[:count] = found
                found = longer
            found[count] = (a, b, c, d)
            count += 1
    return found[:count]
