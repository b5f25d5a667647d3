"""Distances to obstacles and the velocity maps of Fast Marching Square (Norén et al., 2.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.eikonal._distance import saturated, square_distance
from cavalcade.geometry import Array

# m; the same for every safe distance, so that all maps block the same cells
_LEAST_CLEARANCE = 1e-3


def surface_distance(occupied: NDArray[np.bool_], cell: float, border: bool = True) -> Array:
    """Distance from each cell's centre to the nearest occupied cell's surface.

    Args:
        occupied: `(rows, cols)`; masked cells are occupied.
        cell: Cell size, m.
        border: Whether all ground beyond the grid counts as occupied.

    Returns:
        `(rows, cols)` m; 0 in occupied cells, inf everywhere if there is nothing occupied. Exact:
        distances are to the occupied squares, not to their centres.
    """
    # A copy: the kernel would be compiled a second time for read-only arrays.
    occupied = np.array(np.ma.filled(occupied, True), dtype=np.bool_, order="C")
    if not border:
        return square_distance(occupied, float(cell))
    padded = np.pad(occupied, 1, constant_values=True)
    return np.ascontiguousarray(square_distance(padded, float(cell))[1:-1, 1:-1])


def velocity_map(distance: Array, radius: float, safe_distance: float) -> Array:
    """Speeds in [0, 1] that rise with the distance to the inflated obstacles.

    Args:
        distance: `(rows, cols)` distance to the nearest obstacle's surface, m.
        radius: Inflation radius (the paper's r_max), m.
        safe_distance: Distance from the inflated obstacles from which on a robot may go at full
            speed (the paper's d_safe), m.

    Returns:
        `(rows, cols)`; 0 in the inflated obstacles and less than a millimetre beside them, where
        a cell would take longer than any path around it.
    """
    return saturated(np.ascontiguousarray(distance), radius, safe_distance, _LEAST_CLEARANCE)
