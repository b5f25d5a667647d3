"""What the page needs to know of a plan: key frames of its trajectories, and footholds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.outlines import fewest_points
from cavalcade.drawing.plans.motion import activities
from cavalcade.drawing.replay.packing import packed, rounded, steps
from cavalcade.drawing.scene import PlanScene, runs
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory

TOLERANCE = 0.004
"""Error of a position between two key frames, m; of the yaw a few times as much, rad."""

_YAW_WEIGHT = 0.3
_MOST_FOOTHOLDS = 12_000


def plan_data(scene: PlanScene, robots: list[dict[str, Any]]) -> dict[str, Any]:
    """The unit of the footholds' times; puts `path` and `feet` to each of the page's robots."""
    paths, footholds = scene.plan.trajectories, scene.plan.footholds
    stepping = sum(len(feet) for feet in footholds) <= _MOST_FOOTHOLDS
    tick = max(0.002, scene.makespan / 60_000)
    for robot, path, feet in zip(robots, paths, footholds, strict=True):
        robot["path"] = None if path is None else _path(path)
        robot["feet"] = _feet(feet, tick) if stepping and len(feet) else None
    return {"tick": tick}


def keyframes(path: Trajectory, tolerance: float = TOLERANCE) -> NDArray[np.int64]:
    """Samples `(K,)` to keep, ascending: ends of phases, and whatever bends more than that.

    The error of what is left out is that of the pose at the same moment.
    """
    values = np.column_stack([path.position, _YAW_WEIGHT * path.yaw])

    def errors(first: int, last: int) -> Array:
        time = path.time[first : last + 1]
        share = (time[1:-1] - time[0]) / max(time[-1] - time[0], 1e-12)
        line = values[first] + share[:, None] * (values[last] - values[first])
        return np.asarray(np.linalg.norm(values[first + 1 : last] - line, axis=1))

    changes = np.flatnonzero(np.diff(path.phase)) + 1
    return fewest_points([0, *changes.tolist(), len(values) - 1], errors, tolerance)


def _path(path: Trajectory) -> dict[str, Any]:
    """Key frames, each as the difference from the one before; ms, mm, mrad."""
    kept = keyframes(path)
    spans = [
        [kind, round(float(path.time[first]), 3), round(float(path.time[last]), 3)]
        for kind, first, last in runs(activities(path))
    ]
    columns = {"t": path.time, "a": path.yaw, **dict(zip("xyz", path.position.T, strict=True))}
    return {
        **{name: steps(values[kept], 1000) for name, values in columns.items()},
        "p": [int(phase) for phase in path.phase[kept]],
        "spans": spans,
        "end": round(path.duration, 4),
    }


def _feet(feet: Array, tick: float) -> dict[str, Any]:
    """Leg after leg: times in ticks, places in cm halves from the first one."""
    order = np.lexsort((feet[:, 0], feet[:, 2]))
    rows = feet[order]
    base = rows[0, 3:6]
    places = np.clip(np.rint((rows[:, 3:6] - base) * 200), -32_000, 32_000)
    return {
        "count": [int(np.count_nonzero(rows[:, 2] == leg)) for leg in range(4)],
        "down": packed(np.rint(rows[:, 0] / tick).astype("<u2")),
        "up": packed(np.rint(rows[:, 1] / tick).astype("<u2")),
        "base": rounded(base, 4),
        "place": packed(places.astype("<i2")),
    }
