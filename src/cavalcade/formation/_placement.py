"""Looking up points in grids, and places for a whole shape. Compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.formation._clearance import DistanceMap, distance_at
from cavalcade.kernels import kernel

_STAND_OFF = 0.05  # m by which robots may be kept from a place and still arrive there


class FreeSpace(NamedTuple):
    """Where robots may stand.

    Attributes:
        labels: `(rows, cols)` numbers of the free regions, 0 for none.
        map: Distances to obstacles.
        radius: What a robot's centre keeps off them, m.
    """

    labels: np.ndarray
    map: DistanceMap
    radius: float


@kernel
def values_at(grid, points, cell):
    """Values `(N,)` of a grid in the cells of points `(N, 2)`; 0 off the grid."""
    out = np.zeros(points.shape[0])
    for k in range(points.shape[0]):
        row, col = int(math.floor(points[k, 1] / cell)), int(math.floor(points[k, 0] / cell))
        if 0 <= row < grid.shape[0] and 0 <= col < grid.shape[1]:
            out[k] = grid[row, col]
    return out


@kernel(nogil=True)
def fitting_shift(shifts, places, bodies, region, needed, space):
    """Index of the first shift with which all places lie in a region, clear; -1 if none does.

    Args:
        shifts: `(K, 2)` m, in the order in which they are tried.
        places: `(S, 2)` m, to lie in cells of the region, near enough to where centres may be.
        bodies: `(S, B, 2)` m, to be clear.
        region: Number of the region; -1 for any.
        needed: Least distance to obstacles, m.
        space: The `FreeSpace` of the map.
    """
    labels, known, cell = space.labels, space.map, space.map.cell
    rows, cols = labels.shape
    for k in range(shifts.shape[0]):
        fits = True
        # Every place, and with each the centres of the discs that cover a robot there.
        for i in range(places.shape[0]):
            x, y = places[i, 0] + shifts[k, 0], places[i, 1] + shifts[k, 1]
            row, col = int(math.floor(y / cell)), int(math.floor(x / cell))
            fits = 0 <= row < rows and 0 <= col < cols
            fits = fits and labels[row, col] > 0 and (region < 0 or labels[row, col] == region)
            fits = fits and distance_at(known, x, y)[0] >= space.radius - _STAND_OFF
            for j in range(bodies.shape[1]):
                if not fits:
                    break
                x, y = bodies[i, j, 0] + shifts[k, 0], bodies[i, j, 1] + shifts[k, 1]
                fits = distance_at(known, x, y)[0] >= needed
            if not fits:
                break
        if fits:
            return k
    return -1
