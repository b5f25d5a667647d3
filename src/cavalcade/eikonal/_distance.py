"""Exact distances from cell centres to occupied squares."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel


@kernel(nogil=True)
def square_distance(occupied, cell):
    """Distance from each cell's centre to the nearest occupied cell's *square*, 0 inside.

    Two passes of one-dimensional lower envelopes (Felzenszwalb and Huttenlocher 2012), with the
    parabolas' vertices on the squares' edges instead of their centres.

    Args:
        occupied: bool `(rows, cols)`.
        cell: Cell size, m.

    Returns:
        `(rows, cols)` m; inf everywhere if nothing is occupied.
    """
    rows, cols = occupied.shape
    out = np.empty((rows, cols))
    out[:] = np.inf
    for c in range(cols):  # first the distance along the column
        last = -np.inf
        for r in range(rows):
            if occupied[r, c]:
                last = float(r)
                out[r, c] = 0.0
            else:
                out[r, c] = r - last - 0.5
        last = np.inf
        for r in range(rows - 1, -1, -1):
            if occupied[r, c]:
                last = float(r)
            else:
                out[r, c] = min(out[r, c], last - r - 0.5)

    height = np.empty(cols + 1)
    vertex = np.empty(cols + 1, np.int64)
    border = np.empty(cols + 2)
    for r in range(rows):
        for k in range(cols + 1):  # the edge between cells k - 1 and k
            left = out[r, k - 1] if k > 0 else np.inf
            right = out[r, k] if k < cols else np.inf
            height[k] = min(left, right) ** 2
        top = -1
        for k in range(cols + 1):
            if height[k] == np.inf:
                continue
            crossing = -np.inf
            while top >= 0:
                j = vertex[top]
                crossing = 0.5 * (k + j) + (height[k] - height[j]) / (2.0 * (k - j))
                if crossing > border[top]:
                    break
                top -= 1
            top += 1
            vertex[top] = k
            border[top] = crossing if top > 0 else -np.inf
        if top < 0:
            continue
        border[top + 1] = np.inf
        at = 0
        for c in range(cols):
            place = c + 0.5
            while border[at + 1] < place:
                at += 1
            k = vertex[at]
            across = (place - k) ** 2 + height[k]
            out[r, c] = cell * math.sqrt(min(across, out[r, c] ** 2))
    return out


@kernel(nogil=True)
def saturated(distance, radius, safe, least):
    """Speeds `(rows, cols)` that rise from 0 at `radius` to 1 over the next `safe` metres.

    Args:
        distance: `(rows, cols)` m.
        radius, safe: m.
        least: Beyond the radius, below which the speed is 0, m.
    """
    rows, cols = distance.shape
    speed = np.empty((rows, cols))
    for r in range(rows):
        for c in range(cols):
            room = distance[r, c] - radius
            speed[r, c] = min(room / safe, 1.0) if room >= least else 0.0
    return speed
