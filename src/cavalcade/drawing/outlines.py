"""Outlines of obstacles and robots as rings of points, for any canvas that can fill polygons."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array, rectangle_corners, transform_points
from cavalcade.robots import RobotModel
from cavalcade.world import Box, Circle, Shape

_FINE_CELLS = 1_000_000


def shape_ring(shape: Shape, corners: int = 64) -> Array:
    """The shape's outline `(K, 2)`, not closed; a circle becomes a polygon of `corners`."""
    if isinstance(shape, Box):
        return rectangle_corners((*shape.center, shape.yaw), *shape.size)
    if isinstance(shape, Circle):
        return _circle(shape.radius, corners) + shape.center
    return np.asarray(shape.points, dtype=float)


def _circle(radius: float, corners: int) -> Array:
    angles = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def body_ring(pose: Array, model: RobotModel) -> Array:
    """The footprint's outline `(K, 2)`, not closed."""
    if model.round:
        return np.asarray(_circle(0.5 * model.length, 40) + pose[:2])
    return rectangle_corners(pose, model.length, model.width)


def cell_rings(
    mask: NDArray[np.bool_], resolution: float, origin: tuple[float, float, float]
) -> list[Array]:
    """Outlines `(K, 2)` of the true cells of a grid in the map frame, not closed.

    Row 0 is at the lowest y; `origin` is the pose of the lower-left corner of cell [0, 0]. Outer
    rings are counter-clockwise and holes clockwise, so that filling them together leaves the holes
    empty. Edges lie on the cells' borders; corners are cut by a quarter of a cell (by half a cell
    on very large grids).
    """
    from contourpy import FillType, contour_generator

    if not mask.any():
        return []
    factor = 2 if mask.size <= _FINE_CELLS else 1
    fine = np.repeat(np.repeat(mask, factor, axis=0), factor, axis=1)
    padded = np.pad(fine, 1).astype(np.float64)
    generator = contour_generator(z=padded, fill_type=FillType.OuterOffset)
    filled: Any = generator.filled(0.5, np.inf)  # of the fill type's own form
    rings = []
    for outer, starts in zip(*filled, strict=True):
        for first, last in pairwise(starts):
            # Sample [i] of the padded grid is the centre of fine cell i - 1.
            local = (np.asarray(outer[first : last - 1]) - 0.5) * (resolution / factor)
            rings.append(transform_points(origin, without_collinear(local)))
    return rings


def without_collinear(ring: Array) -> Array:
    """The ring `(K, 2)` without the points that lie on a straight stretch of it."""
    before = ring - np.roll(ring, 1, axis=0)
    after = np.roll(ring, -1, axis=0) - ring
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    kept = ring[np.abs(cross) > 1e-12]
    return kept if len(kept) >= 3 else ring


def simplified(line: Array, tolerance: float) -> Array:
    """The open line `(K, 2)` with the fewest of its points that stay within `tolerance` m.

    The first and the last point are always kept.
    """
    if len(line) < 3:
        return line

    def errors(first: int, last: int) -> Array:
        chord = line[last] - line[first]
        between = line[first + 1 : last] - line[first]
        along = between @ chord / max(float(np.hypot(*chord)) ** 2, 1e-24)
        return np.asarray(np.hypot(*(between - np.clip(along, 0.0, 1.0)[:, None] * chord).T))

    return np.asarray(line[fewest_points([0, len(line) - 1], errors, tolerance)])


def fewest_points(
    fixed: Sequence[int], errors: Callable[[int, int], Array], tolerance: float
) -> NDArray[np.int64]:
    """Which points of a line to keep so that none left out is further off than `tolerance`.

    Douglas and Peucker's rule.

    Args:
        fixed: Points to keep in any case, ascending; the first and the last one among them.
        errors: How far the points strictly between two kept ones are from what joins those.
        tolerance: In the unit of the errors.
    """
    kept = set(fixed)
    spans = list(pairwise(fixed))
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        away = errors(first, last)
        worst = int(np.argmax(away))
        if away[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            spans += [(first, middle), (middle, last)]
    return np.array(sorted(kept), dtype=np.int64)
