"""A path over the cells of a grid by breadth-first search from both ends."""

from __future__ import annotations

import numpy as np
from numba import njit

_ROW = (0, 0, 1, -1, 1, 1, -1, -1)
_COL = (1, -1, 0, 0, 1, -1, 1, -1)


@njit(cache=True)
def grid_path(passable, start, goal):
    """The path with the fewest steps to neighbouring cells, of which each has eight.

    Args:
        passable: `(rows, cols)`; the start's and the goal's cells count as passable.
        start, goal: (row, col).

    Returns:
        `(K, 2)` rows and columns from the start to the goal, empty if there is no path. Both ends
        are searched from, so that a small enclosed area is soon known to be one.
    """
    rows, cols = passable.shape
    source = np.full(rows * cols, -1, np.int32)
    side = np.zeros(rows * cols, np.int8)
    queues = np.empty((2, rows * cols), np.int32)
    heads, tails = np.zeros(2, np.int64), np.ones(2, np.int64)
    ends = (start[0] * cols + start[1], goal[0] * cols + goal[1])
    for k in range(2):
        queues[k, 0] = ends[k]
        side[ends[k]] += k + 1
        source[ends[k]] = ends[k]
    if ends[0] == ends[1]:
        return np.array([[start[0], start[1]]], np.int64)
    while True:
        for k in range(2):
            if heads[k] == tails[k]:
                return np.empty((0, 2), np.int64)
            # One ring around this end; a cell of the other side joins both.
            for _ in range(tails[k] - heads[k]):
                at = queues[k, heads[k]]
                heads[k] += 1
                row, col = at // cols, at % cols
                for m in range(8):
                    i, j = row + _ROW[m], col + _COL[m]
                    if i < 0 or j < 0 or i >= rows or j >= cols:
                        continue
                    to = i * cols + j
                    if side[to] == k + 1 or (side[to] == 0 and not passable[i, j]):
                        continue
                    if side[to] != 0:
                        return (
                            _trace(source, cols, at, to) if k == 0 else _trace(source, cols, to, at)
                        )
                    side[to] = k + 1
                    source[to] = at
                    queues[k, tails[k]] = to
                    tails[k] += 1


@njit(cache=True)
def _trace(source, cols, a, b):
    """Cells from the root of `a` over `a` and `b` to the root of `b`."""
    before, after = _steps(source, a), _steps(source, b)
    path = np.empty((before + after, 2), np.int64)
    for k in range(before - 1, -1, -1):
        path[k, 0], path[k, 1] = a // cols, a % cols
        a = source[a]
    for k in range(before, before + after):
        path[k, 0], path[k, 1] = b // cols, b % cols
        b = source[b]
    return path


@njit(cache=True)
def _steps(source, at):
    """Number of cells from one to its root, both included."""
    count = 1
    while source[at] != at:
        at = source[at]
        count += 1
    return count
