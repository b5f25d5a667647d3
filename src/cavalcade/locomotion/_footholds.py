"""Where feet may stand, compiled. Metres; x, y from the lower-left corner of cell [0, 0].

`ground` is a `Footing`; its cells carry a foot from the traversability `least` on, and a foot may
be put up to `reach` from its wanted place.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kernels import kernel, subroutine


class Stances(NamedTuple):
    """Feet that stand, one row each, and the motion of the hips above them; in the ground's frame.

    Attributes:
        times: `(T,)` s.
        hips: `(T, 4, 3)` m, of each leg.
        needed: `(T, 4)` whether the leg has to reach its foothold then.
        down, up: `(M,)` s.
        feet: `(M, 4)` leg, x, y, z.
    """

    times: Array
    hips: Array
    needed: NDArray[np.bool_]
    down: Array
    up: Array
    feet: Array


@subroutine
def can_stand(row, col, ground, least):
    """Whether a foot may stand in a cell."""
    solid = ground.solid
    if row < 0 or col < 0 or row >= solid.shape[0] or col >= solid.shape[1] or solid[row, col]:
        return False
    return ground.flat or ground.traversability[row, col] >= least


@subroutine
def nearest_place(x, y, ground, least, reach):
    """The place nearest to (x, y) where a foot may stand.

    Where it may stand at (x, y) itself, there; otherwise the centre of the nearest such cell
    within `reach`, the first in the order of rows where two are equally near. Returns x, y and
    whether there is one; (x, y) itself where there is none.
    """
    cell = ground.cell
    row, col = int(math.floor(y / cell)), int(math.floor(x / cell))
    if can_stand(row, col, ground, least):
        return x, y, True
    best, best_x, best_y = reach * reach, x, y
    found = False
    span = int(math.ceil(reach / cell)) + 1
    for r in range(row - span, row + span + 1):
        for c in range(col - span, col + span + 1):
            mx, my = (c + 0.5) * cell, (r + 0.5) * cell
            away = (mx - x) ** 2 + (my - y) ** 2
            if away < best and can_stand(r, c, ground, least):
                best, best_x, best_y = away, mx, my
                found = True
    return best_x, best_y, found


@kernel
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


@kernel
def place_feet(wanted, ground, least, reach):
    """The places `(M, 3)` x, y, z on the ground for wanted ones `(M, 2)`."""
    places = np.empty((wanted.shape[0], 3))
    for m in range(wanted.shape[0]):
        x, y, _ = nearest_place(wanted[m, 0], wanted[m, 1], ground, least, reach)
        places[m, 0], places[m, 1] = x, y
        places[m, 2] = 0.0 if ground.flat else interpolate(x, y, ground.cell, ground.height)
    return places


@subroutine
def first_from(times, time):
    """The index of the first of the rising times that is not before `time`, by bisection."""
    low, high = 0, len(times)
    while low < high:
        middle = (low + high) // 2
        if times[middle] < time:
            low = middle + 1
        else:
            high = middle
    return low


@subroutine
def leg_length(stances, m, x, y, z):
    """Longest distance of the hip during stance `m` from a foot at (x, y, z); 0 where never."""
    leg = int(stances.feet[m, 0])
    first = first_from(stances.times, stances.down[m] - 1e-9)
    last = first_from(stances.times, stances.up[m] + 1e-9)
    hips, longest = stances.hips, 0.0
    for k in range(first, last):
        if stances.needed[k, leg]:
            away = math.sqrt(
                (hips[k, leg, 0] - x) ** 2 + (hips[k, leg, 1] - y) ** 2 + (hips[k, leg, 2] - z) ** 2
            )
            longest = max(longest, away)
    return longest


@kernel
def leg_lengths(stances):
    """Longest distance `(M,)` m of each standing foot from its hip; 0 where none is needed."""
    feet = stances.feet
    longest = np.zeros(len(feet))
    for m in range(len(feet)):
        longest[m] = leg_length(stances, m, feet[m, 1], feet[m, 2], feet[m, 3])
    return longest


@kernel
def bring_in_reach(stances, longest, ground, least, reach):
    """Move feet whose leg would be longer than `longest`, m, to where it is shortest, in place.

    Tried are the centres of cells within `reach` of where the foot is.
    """
    cell, feet = ground.cell, stances.feet
    for m in range(len(feet)):
        x, y = feet[m, 1], feet[m, 2]
        best = leg_length(stances, m, x, y, feet[m, 3])
        if best <= longest:
            continue
        row, col = int(math.floor(y / cell)), int(math.floor(x / cell))
        span = int(math.ceil(reach / cell))
        for r in range(row - span, row + span + 1):
            for c in range(col - span, col + span + 1):
                mx, my = (c + 0.5) * cell, (r + 0.5) * cell
                if (mx - x) ** 2 + (my - y) ** 2 > reach * reach:
                    continue
                if not can_stand(r, c, ground, least):
                    continue
                mz = 0.0 if ground.flat else ground.height[r, c]
                length = leg_length(stances, m, mx, my, mz)
                if length < best:
                    best = length
                    feet[m, 1], feet[m, 2], feet[m, 3] = mx, my, mz
