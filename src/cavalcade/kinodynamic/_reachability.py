"""Whether a goal can be reached at all, and roughly which way."""

from __future__ import annotations

import numpy as np
from numba import njit

_ROW = (0, 0, 1, -1, 1, 1, -1, -1)
_COL = (1, -1, 0, 0, 1, -1, 1, -1)


@njit(cache=True)
def grid_way(passable, start, goal):
    """The way with the fewest steps to neighbouring cells, of which each has eight.

    Args:
        passable: `(rows, cols)`; the start's and the goal's cells count as passable.
        start, goal: (row, col).

    Returns:
        `(K, 2)` rows and columns from the start to the goal, empty if there is no way. Both ends
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
    a, b = -1, -1
    while a < 0:
        for k in range(2):
            if heads[k] == tails[k]:
                return np.empty((0, 2), np.int64)
            for _ in range(tails[k] - heads[k]):  # one ring
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
                        a, b = (at, to) if k == 0 else (to, at)
                        break
                    side[to] = k + 1
                    source[to] = at
                    queues[k, tails[k]] = to
                    tails[k] += 1
                if a >= 0:
                    break
            if a >= 0:
                break
    return _trace(source, a, b, cols)


@njit(cache=True)
def _trace(source, a, b, cols):
    count = 2
    at = a
    while source[at] != at:
        at = source[at]
        count += 1
    ahead = count - 1
    at = b
    while source[at] != at:
        at = source[at]
        count += 1
    way = np.empty((count, 2), np.int64)
    at, k = a, ahead - 1
    way[k, 0], way[k, 1] = at // cols, at % cols
    while source[at] != at:
        at, k = source[at], k - 1
        way[k, 0], way[k, 1] = at // cols, at % cols
    at, k = b, ahead
    way[k, 0], way[k, 1] = at // cols, at % cols
    while source[at] != at:
        at, k = source[at], k + 1
        way[k, 0], way[k, 1] = at // cols, at % cols
    return way
