"""Conflicts: which bodies of a team come too near each other, and when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cavalcade.coordination._conflicts import find_conflicts
from cavalcade.geometry import Array
from cavalcade.lattice.motion_limits import footprint
from cavalcade.lattice.planner import TRACK_STEP, stacked
from cavalcade.robots import RobotModel

MARGIN = 0.002
"""Bodies nearer than this are in conflict, m: what sampled tracks may hide is less."""

_LOOK = 0.0025
"""Time between looks at bodies that are near each other, s: at 1.5 m/s they come nearer by less
than twice the margin in between."""


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
        models: Of the robots on them.
        most: Conflicts of each pair.
        distance: Between centres, m: instead of the bodies (the paper's threshold d).
    """
    table = stacked(tracks)
    shapes = np.array([footprint(model) for model in models], dtype=float)
    if distance is not None:
        shapes[:] = (distance - MARGIN) / 2.0, (distance - MARGIN) / 2.0, 1.0
    # Of the fastest point of any body.
    steps = np.abs(np.diff(table, axis=1)) if table.shape[1] > 1 else np.zeros((1, 1, 3))
    moved = np.hypot(steps[..., 0], steps[..., 1]) + steps[..., 2] * shapes[:, :2].max()
    speed = max(float(moved.max()) / TRACK_STEP, 1e-3)
    rows = find_conflicts(table, TRACK_STEP, shapes, MARGIN, speed, _LOOK, most)
    found = [Conflict(int(i), int(j), float(a), float(b)) for i, j, a, b in rows]
    return sorted(found, key=lambda conflict: (conflict.begin, conflict.i, conflict.j))
