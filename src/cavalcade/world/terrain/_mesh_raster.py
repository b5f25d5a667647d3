"""The highest surface of a mesh above the centres of a grid's cells."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True)
def covered_cells(triangles, cell, rows, cols):
    """How many cells the triangles' bounding rectangles cover together, one by one.

    Args:
        triangles: `(N, 3, 3)` corners x, y, z; x and y from the grid's lower-left corner, m.
        cell: m.
        rows, cols: Of the grid.
    """
    total = 0.0
    for k in range(triangles.shape[0]):
        r0, r1, c0, c1 = _window(triangles[k], cell, rows, cols)
        total += max(r1 - r0, 0) * max(c1 - c0, 0)
    return total


@njit(cache=True)
def _window(corners, cell, rows, cols):
    """Half-open rows and columns of the cells whose centres a triangle's rectangle holds."""
    x0 = min(corners[0, 0], corners[1, 0], corners[2, 0])
    x1 = max(corners[0, 0], corners[1, 0], corners[2, 0])
    y0 = min(corners[0, 1], corners[1, 1], corners[2, 1])
    y1 = max(corners[0, 1], corners[1, 1], corners[2, 1])
    slack = 1e-6
    c0 = max(int(math.ceil(x0 / cell - 0.5 - slack)), 0)
    c1 = min(int(math.floor(x1 / cell - 0.5 + slack)) + 1, cols)
    r0 = max(int(math.ceil(y0 / cell - 0.5 - slack)), 0)
    r1 = min(int(math.floor(y1 / cell - 0.5 + slack)) + 1, rows)
    return r0, r1, c0, c1


@njit(cache=True)
def highest_surface(triangles, cell, rows, cols):
    """Heights `(rows, cols)` m of the highest triangle over each centre; nan where there is none.

    Upright triangles have no surface seen from above and are left out.
    """
    out = np.full((rows, cols), np.nan)
    for k in range(triangles.shape[0]):
        corners = triangles[k]
        r0, r1, c0, c1 = _window(corners, cell, rows, cols)
        if r0 >= r1 or c0 >= c1:
            continue
        ax, ay, az = corners[0, 0], corners[0, 1], corners[0, 2]
        ux, uy, uz = corners[1, 0] - ax, corners[1, 1] - ay, corners[1, 2] - az
        vx, vy, vz = corners[2, 0] - ax, corners[2, 1] - ay, corners[2, 2] - az
        area = ux * vy - uy * vx
        longest = max(abs(ux), abs(uy), abs(vx), abs(vy))
        if abs(area) <= 1e-12 * longest * longest:
            continue
        for row in range(r0, r1):
            for col in range(c0, c1):
                px, py = (col + 0.5) * cell - ax, (row + 0.5) * cell - ay
                s = (px * vy - py * vx) / area
                t = (ux * py - uy * px) / area
                # Centres on an edge belong to both triangles: rounding must not leave cracks.
                if s >= -1e-9 and t >= -1e-9 and s + t <= 1.0 + 1e-9:
                    z = az + s * uz + t * vz
                    if not out[row, col] >= z:
                        out[row, col] = z
    return out
