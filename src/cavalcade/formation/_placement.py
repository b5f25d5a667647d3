"""Looking up points in grids, and places for a whole shape. Compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.kernels import kernel


class FreeSpace(NamedTuple):
    """Where robots may stand.

    Attributes:
        labels: `(rows, cols)` numbers of the free regions, 0 for none.
        distance: `(rows, cols)` distances to obstacles, m.
        cell: Cell size, m.
    """

    labels: np.ndarray
    distance: np.ndarray
    cell: float


@kernel
def values_at(grid, points, cell):
    """Values `(N,)` of a grid in the cells of points `(N, 2)`; 0 off the grid."""
    out = np.zeros(points.shape[0])
    for k in range(points.shape[0]):
        row, col = int(math.floor(points[k, 1] / cell)), int(math.floor(points[k, 0] / cell))
        if 0 <= row < grid.shape[0] and 0 <= col < grid.shape[1]:
            out[k] = grid[row, col]
    return out


@kernel
def fitting_shift(shifts, places, bodies, region, needed, space):
    """Index of the first shift with which all places lie in a region, clear; -1 if none does.

    Args:
        shifts: `(K, 2)` m, in the order in which they are tried.
        places: `(S, 2)` m, to lie in cells of the region.
        bodies: `(S, B, 2)` m, to lie in cells that are clear.
        region: Number of the region; -1 for any.
        needed: Least distance to obstacles, m.
        space: The `FreeSpace` of the map.
    """
    labels, distance, cell = space
    rows, cols = labels.shape
    for k in range(shifts.shape[0]):
        fits = True
        # Every place, and with each the centres of the discs that cover a robot there.
        for i in range(places.shape[0]):
            row = int(math.floor((places[i, 1] + shifts[k, 1]) / cell))
            col = int(math.floor((places[i, 0] + shifts[k, 0]) / cell))
            fits = 0 <= row < rows and 0 <= col < cols
            fits = fits and labels[row, col] > 0 and (region < 0 or labels[row, col] == region)
            for j in range(bodies.shape[1]):
                if not fits:
                    break
                row = int(math.floor((bodies[i, j, 1] + shifts[k, 1]) / cell))
                col = int(math.floor((bodies[i, j, 0] + shifts[k, 0]) / cell))
                fits = 0 <= row < rows and 0 <= col < cols and distance[row, col] >= needed
            if not fits:
                break
        if fits:
            return k
    return -1
