"""Where feet may stand, compiled. Metres; x, y from the lower-left corner of cell [0, 0]."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True)
def can_stand(row, col, solid, traversability, flat, least):
    """Whether a foot may stand in a cell."""
    if row < 0 or col < 0 or row >= solid.shape[0] or col >= solid.shape[1] or solid[row, col]:
        return False
    return flat or traversability[row, col] >= least


@njit(cache=True)
def nearest_place(x, y, cell, solid, traversability, flat, least, reach):
    """The place nearest to (x, y) where a foot may stand.

    Where it may stand at (x, y) itself, there; otherwise the centre of the nearest such cell
    within `reach`, the first in the order of rows where two are equally near.

    Returns:
        x, y, and whether there is one; (x, y) itself where there is none.
    """
    row, col = int(math.floor(y / cell)), int(math.floor(x / cell))
    if can_stand(row, col, solid, traversability, flat, least):
        return x, y, True
    best, best_x, best_y = reach * reach, x, y
    found = False
    span = int(math.ceil(reach / cell)) + 1
    for r in range(row - span, row + span + 1):
        for c in range(col - span, col + span + 1):
            mx, my = (c + 0.5) * cell, (r + 0.5) * cell
            away = (mx - x) ** 2 + (my - y) ** 2
            if away < best and can_stand(r, c, solid, traversability, flat, least):
                best, best_x, best_y = away, mx, my
                found = True
    return best_x, best_y, found


@njit(cache=True)
def interpolate(x, y, cell, grid):
    """Bilinear between the centres of cells; beyond the outermost ones as at them."""
    rows, cols = grid.shape
    u = min(max(x / cell - 0.5, 0.0), cols - 1.0)
    v = min(max(y / cell - 0.5, 0.0), rows - 1.0)
    c, r = min(int(u), cols - 1), min(int(v), rows - 1)
    c1, r1 = min(c + 1, cols - 1), min(r + 1, rows - 1)
    u -= c
    v -= r
    low = grid[r, c] * (1.0 - u) + grid[r, c1] * u
    high = grid[r1, c] * (1.0 - u) + grid[r1, c1] * u
    return low * (1.0 - v) + high * v


@njit(cache=True)
def place_feet(wanted, cell, solid, height, traversability, flat, least, reach):
    """The places on the ground for wanted ones.

    Args:
        wanted: `(M, 2)` x, y.
        cell, solid, height, traversability, flat: As of `cavalcade.lattice.ground.Ground`.
        least: Least traversability.
        reach: How far a foot may be put from its wanted place.

    Returns:
        `(M, 3)` x, y, z.
    """
    places = np.empty((wanted.shape[0], 3))
    for m in range(wanted.shape[0]):
        x, y, _ = nearest_place(
            wanted[m, 0], wanted[m, 1], cell, solid, traversability, flat, least, reach
        )
        places[m, 0], places[m, 1] = x, y
        places[m, 2] = 0.0 if flat else interpolate(x, y, cell, height)
    return places


@njit(cache=True)
def stance_stretch(hips, needed, first, last, leg, x, y, z):
    """Longest distance of a hip from a foot over the samples `first` to `last` - 1."""
    longest = 0.0
    for k in range(first, last):
        if needed[k, leg]:
            away = math.sqrt(
                (hips[k, leg, 0] - x) ** 2 + (hips[k, leg, 1] - y) ** 2 + (hips[k, leg, 2] - z) ** 2
            )
            longest = max(longest, away)
    return longest


@njit(cache=True)
def stretch(times, hips, needed, down, up, feet):
    """Longest distance of a hip from its standing foot.

    Args:
        times: `(T,)` s.
        hips: `(T, 4, 3)` m, of each leg.
        needed: `(T, 4)` whether the leg has to reach its foothold then.
        down, up: `(M,)` s.
        feet: `(M, 4)` leg, x, y, z.

    Returns:
        `(M,)` m, over the samples during each stance; 0 where there is none.
    """
    longest = np.zeros(len(down))
    for m in range(len(down)):
        first = np.searchsorted(times, down[m] - 1e-9)
        last = np.searchsorted(times, up[m] + 1e-9)
        longest[m] = stance_stretch(
            hips, needed, first, last, int(feet[m, 0]), feet[m, 1], feet[m, 2], feet[m, 3]
        )
    return longest


@njit(cache=True)
def bring_in_reach(times, hips, needed, down, up, feet, length, cell, solid, height,
                   traversability, flat, least, reach):  # fmt: skip
    """Move feet that their leg cannot reach to where it can best, in place.

    Tried are the centres of cells within `reach` of where the foot is. Arguments as of `stretch`
    and `place_feet`, all in the ground's frame; `length` is that of a leg, m.
    """
    for m in range(len(down)):
        first = np.searchsorted(times, down[m] - 1e-9)
        last = np.searchsorted(times, up[m] + 1e-9)
        leg, x, y = int(feet[m, 0]), feet[m, 1], feet[m, 2]
        best = stance_stretch(hips, needed, first, last, leg, x, y, feet[m, 3])
        if best <= length:
            continue
        row, col = int(math.floor(y / cell)), int(math.floor(x / cell))
        span = int(math.ceil(reach / cell))
        for r in range(row - span, row + span + 1):
            for c in range(col - span, col + span + 1):
                mx, my = (c + 0.5) * cell, (r + 0.5) * cell
                if (mx - x) ** 2 + (my - y) ** 2 > reach * reach:
                    continue
                if not can_stand(r, c, solid, traversability, flat, least):
                    continue
                mz = 0.0 if flat else height[r, c]
                longest = stance_stretch(hips, needed, first, last, leg, mx, my, mz)
                if longest < best:
                    best = longest
                    feet[m, 1], feet[m, 2], feet[m, 3] = mx, my, mz
