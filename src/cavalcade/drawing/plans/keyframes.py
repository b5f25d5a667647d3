"""The fewest samples of a motion from which straight lines give it back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory

TOLERANCE = 0.004
"""Error of a position between two key frames, m; of the yaw a few times as much, rad."""

_YAW_WEIGHT = 0.3


def keyframes(path: Trajectory, tolerance: float = TOLERANCE) -> NDArray[np.int64]:
    """Samples `(K,)` to keep, ascending: ends of phases, and whatever bends more than that.

    Douglas and Peucker's rule over time: the error is that of the pose at the same moment.
    """
    values = np.column_stack([path.position, _YAW_WEIGHT * path.yaw])
    keep = np.zeros(len(values), dtype=bool)
    keep[[0, -1]] = True
    keep[1:][np.diff(path.phase) != 0] = True
    marks = np.flatnonzero(keep)
    spans = list(zip(marks[:-1].tolist(), marks[1:].tolist(), strict=True))
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        away = _errors(path.time, values, first, last)
        worst = int(np.argmax(away))
        if away[worst] > tolerance:
            middle = first + 1 + worst
            keep[middle] = True
            spans += [(first, middle), (middle, last)]
    return np.flatnonzero(keep)


def _errors(time: Array, values: Array, first: int, last: int) -> Array:
    share = (time[first + 1 : last] - time[first]) / max(time[last] - time[first], 1e-12)
    line = values[first] + share[:, None] * (values[last] - values[first])
    return np.asarray(np.linalg.norm(values[first + 1 : last] - line, axis=1))
