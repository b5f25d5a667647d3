"""Conflicts: which bodies of a team come too near each other, and when."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from cavalcade.geometry import Array
from cavalcade.geometry.boxes import Footprint, footprint_at, footprint_radius, footprints_meet
from cavalcade.kernels import kernel
from cavalcade.lattice.collision import place_free, pose_at
from cavalcade.lattice.motion_limits import footprint
from cavalcade.lattice.planner import MARGINS, TRACK_STEP, stacked
from cavalcade.robots import RobotModel

MARGIN = 0.002
"""Bodies nearer than this are in conflict, m: what sampled tracks may hide is less."""

_CLOSE = MARGINS[-1].others
"""The same of robots that begin or end within `MARGIN` of another: they are planned with less."""

_LOOK = 1.25
"""Time between looks at bodies that are near each other, s for each m of margin: at 1.5 m/s they
come nearer by less than twice the margin in between."""


class Conflict(NamedTuple):
    """Robots `i` < `j` are too near from `begin` to `end` s (inf: for good)."""

    i: int
    j: int
    begin: float
    end: float


def conflicts_of(
    tracks: Sequence[Array],
    models: Sequence[RobotModel],
    most: int = 4,
    distance: float | None = None,
) -> list[Conflict]:
    """All conflicts in order of time, at most `most` of each pair.

    Args:
        tracks: `(K_j, 3)` poses every `TRACK_STEP` s; robots stand at their last for good.
        distance: Between centres, m: instead of the bodies (the paper's threshold d).
    """
    table = stacked(tracks)
    shapes = np.array([footprint(model) for model in models], dtype=float)
    margins = np.full((len(table), len(table)), MARGIN)
    if distance is None:
        _spare_neighbours(margins, table, shapes)
    else:
        shapes[:] = (distance - MARGIN) / 2.0, (distance - MARGIN) / 2.0, 1.0
    # Of the fastest point of any body.
    steps = np.abs(np.diff(table, axis=1)) if table.shape[1] > 1 else np.zeros((1, 1, 3))
    moved = np.hypot(steps[..., 0], steps[..., 1]) + steps[..., 2] * shapes[:, :2].max()
    speed = max(float(moved.max()) / TRACK_STEP, 1e-3)
    rows = find_conflicts(table, TRACK_STEP, shapes, margins, speed, _LOOK, most)
    found = [Conflict(int(i), int(j), float(a), float(b)) for i, j, a, b in rows]
    return sorted(found, key=lambda conflict: (conflict.begin, conflict.i, conflict.j))


def _spare_neighbours(margins: Array, table: Array, shapes: Array) -> None:
    """Ask less of robots that begin or end nearer to another than their margin."""
    rows = [Footprint(length, width, disc > 0.0) for length, width, disc in shapes.tolist()]
    for i, j in combinations(range(len(table)), 2):
        for at in (0, -1):
            here, there = (tuple(table[k, at].tolist()) for k in (i, j))
            if footprints_meet(rows[i], here, rows[j], there, MARGIN):
                margins[[i, j], :] = margins[:, [i, j]] = _CLOSE


@kernel(nogil=True)
def find_conflicts(tracks, dt, shapes, margins, speed, look, most):
    """The times at which two bodies are nearer than their margin, after which all stand.

    Args:
        tracks: `(N, K, 3)` poses every `dt` s, linear in between.
        shapes: `(N, 3)` half length, half width (m), whether round.
        margins: `(N, N)` of each pair, m.
        speed: Of the fastest point of any body, m/s: no two approach by more than twice that.
        look: Time between looks where two are near, s for each m of margin.
        most: Conflicts at most, of each pair.

    Returns:
        `(C, 4)` robots i < j, first and last moment in s; infinite for a conflict that stays.
    """
    n = tracks.shape[0]
    end = (tracks.shape[1] - 1) * dt
    found = np.empty((n * (n - 1) // 2 * most, 4))
    count = 0
    for i in range(n):
        first = footprint_at(shapes, i)
        for j in range(i + 1, n):
            second = footprint_at(shapes, j)
            margin = margins[i, j]
            radii = footprint_radius(first), footprint_radius(second)
            t = 0.0
            begin = -1.0
            of_pair = 0
            while t <= end and of_pair < most:
                here, there = pose_at(tracks, i, t / dt), pose_at(tracks, j, t / dt)
                away = math.sqrt((here[0] - there[0]) ** 2 + (here[1] - there[1]) ** 2)
                gap = away - radii[0] - radii[1] - margin
                meet = gap < 0.0 and footprints_meet(first, here, second, there, margin)
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
                # No sooner than after this can the circles around the two meet.
                t = min(t + max(look * margin, gap / (2.0 * speed)), end)
            if begin >= 0.0 and of_pair < most:
                found[count, 0], found[count, 1] = i, j
                found[count, 2], found[count, 3] = begin, math.inf
                count += 1
    return found[:count]


@kernel
def first_conflict(others, footprint, track, delay, margin, step):
    """The first time at which a robot on a track is nearer than `margin` to others; -1 if never.

    Its poses `(K, 3)` are as far apart in time as the others', begun after `delay` s at the first
    one; looks are `step` s apart.
    """
    if others.spans.shape[0] == 0:
        return -1.0
    dt = others.step
    last = len(track) - 1
    end = max((others.tracks.shape[1] - 1) * dt, delay + last * dt)
    count = int(math.ceil(end / step)) + 1
    # The last look is long after everybody has come to rest.
    for k in range(count + 1):
        t = k * step if k < count else end + 1e6
        at = min(max((t - delay) / dt, 0.0), float(last))
        i = min(int(at), max(last - 1, 0))
        f = at - i
        j = min(i + 1, last)
        pose = (
            track[i, 0] + f * (track[j, 0] - track[i, 0]),
            track[i, 1] + f * (track[j, 1] - track[i, 1]),
            track[i, 2] + f * (track[j, 2] - track[i, 2]),
        )
        if not place_free(others, footprint, pose, t, margin):
            return t
    return -1.0
