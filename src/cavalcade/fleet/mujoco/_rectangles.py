"""Few rectangles that cover the occupied cells of a grid, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

from cavalcade.kernels import kernel, subroutine


@subroutine
def holding(grid, low, high, left, right):
    """How many cells of the rectangle are true."""
    count = 0
    for row in range(low, high):
        for col in range(left, right):
            count += grid[row, col]
    return count


@subroutine
def widest(grid, row, col):
    """The rectangle that grows to both sides along the row first, then down and up."""
    rows, cols = grid.shape
    left, right = col, col + 1
    while left > 0 and grid[row, left - 1]:
        left -= 1
    while right < cols and grid[row, right]:
        right += 1
    low, high = row, row + 1
    while low > 0 and holding(grid, low - 1, low, left, right) == right - left:
        low -= 1
    while high < rows and holding(grid, high, high + 1, left, right) == right - left:
        high += 1
    return low, high, left, right


def cover(grid: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Rectangles of occupied cells that hold every occupied cell beside a free one.

    What lies deeper is covered as it comes: nothing gets there. Beyond the grid nothing is free.
    Returns `(M, 4)` rows from, to, columns from, to (half-open).
    """
    inner = binary_erosion(grid, np.ones((3, 3), bool), border_value=1)
    return cover_wanted(grid, np.ascontiguousarray(grid.T), grid & ~inner)


@kernel
def cover_wanted(grid, turned, wanted):
    """The rectangles that cover the `wanted` cells, of which those that are covered become False.

    Cell by cell in the order of rows, the first one that is not covered yet gets the rectangle
    through it that covers more new ones, of the widest and the highest. `turned` is the grid's
    transpose.
    """
    found = []
    for row in range(grid.shape[0]):
        for col in range(grid.shape[1]):
            if not wanted[row, col]:
                continue
            a, b, c, d = widest(grid, row, col)
            e, f, g, h = widest(turned, col, row)
            if holding(wanted, g, h, e, f) > holding(wanted, a, b, c, d):
                a, b, c, d = g, h, e, f
            for i in range(a, b):
                for k in range(c, d):
                    wanted[i, k] = False
            found.append((a, b, c, d))
    rectangles = np.empty((len(found), 4), np.int64)
    for k, (a, b, c, d) in enumerate(found):
        rectangles[k, 0], rectangles[k, 1], rectangles[k, 2], rectangles[k, 3] = a, b, c, d
    return rectangles
