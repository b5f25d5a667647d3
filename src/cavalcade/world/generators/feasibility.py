"""Whether a disc gets from one place to another, on exact distances to the shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.world.shapes import Shape

_MAX_NODES = 4_000_000


def is_connected(
    shapes: Sequence[Shape],
    size: tuple[float, float],
    start: ArrayLike,
    goal: ArrayLike,
    radius: float = 0.30,
    step: float = 0.025,
) -> bool:
    """Whether a disc gets from start to goal without touching a shape or the world's border.

    Nodes `step` apart are joined where the way between them is clear for certain: distances
    change by at most one metre per metre, so a clearance of radius + step / 2 at both ends is
    enough. The answer True is therefore always right; False may be wrong where the free width is
    within 2.5 `step` of the disc's diameter.

    Args:
        shapes: Obstacles in the world frame, m.
        size: Width and height of the world, m; its lower-left corner is (0, 0).
        start: x, y, m; further numbers (a yaw) are ignored.
        goal: Likewise.
        radius: Of the disc, m.
        step: Distance of the nodes, m; coarser in very large worlds.
    """
    from scipy.ndimage import label

    if not (math.isfinite(radius) and radius >= 0.0 and math.isfinite(step) and step > 0.0):
        raise InputError("expected a disc of finite radius and a positive step", key="radius")
    step = max(step, math.sqrt(size[0] * size[1] / _MAX_NODES))
    cols, rows = (max(2, math.ceil(side / step) + 1) for side in size)
    x, y = np.linspace(0.0, size[0], cols), np.linspace(0.0, size[1], rows)
    need = radius + step / 2.0
    clearance = _clearance(shapes, x, y, need + 2.0 * step)
    labels, _ = label(clearance >= need)
    ends = [
        _reached(labels, clearance, x, y, np.asarray(end, dtype=float)[:2], radius)
        for end in (start, goal)
    ]
    return bool(ends[0] & ends[1])


def _clearance(shapes: Sequence[Shape], x: Array, y: Array, reach: float) -> Array:
    """Distance `(rows, cols)` to the nearest shape or border; a shape counts within `reach`."""
    clearance: Array = np.minimum(
        np.minimum(x, x[-1] - x)[None, :], np.minimum(y, y[-1] - y)[:, None]
    )
    for shape in shapes:
        x_min, y_min, x_max, y_max = shape.bounds
        i0, i1 = np.searchsorted(x, (x_min - reach, x_max + reach))
        j0, j1 = np.searchsorted(y, (y_min - reach, y_max + reach))
        if i0 == i1 or j0 == j1:
            continue
        nodes = np.stack(np.meshgrid(x[i0:i1], y[j0:j1]), axis=-1).reshape(-1, 2)
        distance = shape.distance(nodes).reshape(j1 - j0, i1 - i0)
        np.minimum(clearance[j0:j1, i0:i1], distance, out=clearance[j0:j1, i0:i1])
    return clearance


def _reached(
    labels: np.ndarray, clearance: Array, x: Array, y: Array, point: Array, radius: float
) -> set[int]:
    """Labels of the areas that a disc at `point` is in for certain."""
    i = np.clip(np.searchsorted(x, point[0]) + np.array([-1, 0]), 0, len(x) - 1)
    j = np.clip(np.searchsorted(y, point[1]) + np.array([-1, 0]), 0, len(y) - 1)
    found = set()
    for col in i:
        for row in j:
            away = math.hypot(x[col] - point[0], y[row] - point[1])
            # The disc stays clear all the way to a node that is this clear.
            if labels[row, col] and clearance[row, col] >= radius + away:
                found.add(int(labels[row, col]))
    return found
