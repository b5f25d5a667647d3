"""Kernel that finds when the bodies of a team come too near each other."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.lattice.collision import bodies_meet


@njit(cache=True)
def _pose(tracks, j, index):
    last = tracks.shape[1] - 1
    if index >= last:
        return tracks[j, last, 0], tracks[j, last, 1], tracks[j, last, 2]
    i = int(index)
    f = index - i
    return (
        tracks[j, i, 0] + f * (tracks[j, i + 1, 0] - tracks[j, i, 0]),
        tracks[j, i, 1] + f * (tracks[j, i + 1, 1] - tracks[j, i, 1]),
        tracks[j, i, 2] + f * (tracks[j, i + 1, 2] - tracks[j, i, 2]),
    )


@njit(cache=True)
def find_conflicts(tracks, dt, shapes, margin, speed, step, most):
    """The times at which two bodies are nearer than `margin`, after which all stand.

    Args:
        tracks: `(N, K, 3)` poses every `dt` s, linear in between.
        dt: s.
        shapes: `(N, 3)` half length, half width (m), whether round.
        margin: m.
        speed: Of the fastest point of any body, m/s: no two approach by more than twice that.
        step: Time between looks where two are near, s.
        most: Conflicts at most, of each pair.

    Returns:
        `(C, 4)` robots i < j, first and last moment in s; infinite for a conflict that stays.
    """
    n = tracks.shape[0]
    end = (tracks.shape[1] - 1) * dt
    found = np.empty((n * (n - 1) // 2 * most, 4))
    count = 0
    for i in range(n):
        r_i = math.sqrt(shapes[i, 0] ** 2 + (0.0 if shapes[i, 2] > 0.0 else shapes[i, 1] ** 2))
        for j in range(i + 1, n):
            r_j = math.sqrt(shapes[j, 0] ** 2 + (0.0 if shapes[j, 2] > 0.0 else shapes[j, 1] ** 2))
            t = 0.0
            begin = -1.0
            of_pair = 0
            while t <= end and of_pair < most:
                xi, yi, ai = _pose(tracks, i, t / dt)
                xj, yj, aj = _pose(tracks, j, t / dt)
                gap = math.sqrt((xi - xj) ** 2 + (yi - yj) ** 2) - r_i - r_j - margin
                meet = gap < 0.0 and bodies_meet(
                    xi,
                    yi,
                    ai,
                    shapes[i, 0],
                    shapes[i, 1],
                    shapes[i, 2],
                    xj,
                    yj,
                    aj,
                    shapes[j, 0],
                    shapes[j, 1],
                    shapes[j, 2],
                    margin,
                )
                if meet and begin < 0.0:
                    begin = t
                if not meet and begin >= 0.0:
                    found[count, 0], found[count, 1] = i, j
                    found[count, 2], found[count, 3] = begin, t
                    count += 1
                    of_pair += 1
                    begin = -1.0
                if t == end:
                    break
                t = min(t + max(step, gap / (2.0 * speed)), end)
            if begin >= 0.0 and of_pair < most:
                found[count, 0], found[count, 1] = i, j
                found[count, 2], found[count, 3] = begin, math.inf
                count += 1
    return found[:count]
