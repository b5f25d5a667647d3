"""Distances from an oriented rectangle to what it may run into. Exact, in metres, 0 in contact.

Everything is seen from the rectangle: it lies at the origin, its sides along the axes, and is
described by `half`, half of its length and half of its width. A cheap first look at boxes along the
axes, `overlapping`, leaves few pairs for that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array

_LEAF = 16
_NONE = np.empty(0, dtype=np.int64)


def seen_from(pose: Array, points: Array) -> Array:
    """Points `(M, P, 2)` expressed in the frames of poses `(M, 3)`."""
    offset = points - pose[:, None, :2]
    c, s = np.cos(pose[:, 2])[:, None], np.sin(pose[:, 2])[:, None]
    x, y = offset[..., 0], offset[..., 1]
    return np.stack((c * x + s * y, c * y - s * x), axis=-1)


def corners(pose: Array, half: Array) -> Array:
    """Corners `(M, 4, 2)`, counter-clockwise, of rectangles `half` `(2,)` at poses `(M, 3)`."""
    local = half * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    return beside(pose, local[:, 0], local[:, 1])


def beside(pose: Array, forward: Array, left: Array) -> Array:
    """Points `(M, P, 2)` in m, `(M, P)` or `(P,)` m forward and to the left of poses `(M, 3)`."""
    c, s = np.cos(pose[:, 2])[:, None], np.sin(pose[:, 2])[:, None]
    x = pose[:, 0, None] + c * forward - s * left
    y = pose[:, 1, None] + s * forward + c * left
    return np.stack((x, y), axis=-1)


def to_points(half: Array, points: Array) -> Array:
    """Distance `(...)` of points `(..., 2)` from the rectangle."""
    outside = np.maximum(np.abs(points) - half, 0.0)
    return np.hypot(outside[..., 0], outside[..., 1])


def to_polygons(half: Array, vertices: Array) -> Array:
    """Distance `(M,)` of simple polygons, convex or not, with vertices `(M, P, 2)`."""
    following = np.roll(vertices, -1, axis=1)
    apart = np.minimum(
        to_points(half, vertices).min(axis=1), _corners_to_edges(half, vertices, following)
    )
    crossed = _edges_cross(half, vertices, following) | _holds_origin(vertices, following)
    return np.where(crossed, 0.0, apart)


def _corners_to_edges(half: Array, a: Array, b: Array) -> Array:
    """Least distance `(M,)` of the rectangle's corners from the edges a-b `(M, P, 2)`."""
    edge = b - a
    square = np.maximum((edge * edge).sum(axis=-1), 1e-300)
    least = np.full(len(a), np.inf)
    for sign in ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)):
        to_corner = half * np.array(sign) - a
        along = np.clip((to_corner * edge).sum(axis=-1) / square, 0.0, 1.0)
        rest = to_corner - along[..., None] * edge
        least = np.minimum(least, np.hypot(rest[..., 0], rest[..., 1]).min(axis=1))
    return least


def _edges_cross(half: Array, a: Array, b: Array) -> NDArray[np.bool_]:
    """Whether an edge a-b `(M, P, 2)` has a point in common with the rectangle, `(M,)`."""
    edge = b - a
    # An edge along an axis lies within the slab for its whole length or not at all.
    flat = np.abs(edge) < 1e-12
    inverse = 1.0 / np.where(flat, 1.0, edge)
    one, two = (-half - a) * inverse, (half - a) * inverse
    inside = np.abs(a) <= half
    enter = np.where(flat, np.where(inside, -np.inf, np.inf), np.minimum(one, two))
    leave = np.where(flat, np.where(inside, np.inf, -np.inf), np.maximum(one, two))
    crossed = np.maximum(enter.max(axis=-1), 0.0) <= np.minimum(leave.min(axis=-1), 1.0)
    return crossed.any(axis=1)


def _holds_origin(a: Array, b: Array) -> NDArray[np.bool_]:
    """Whether the polygons with edges a-b `(M, P, 2)` hold the origin, by crossings, `(M,)`."""
    spans = (a[..., 1] > 0.0) != (b[..., 1] > 0.0)
    turn = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    right = np.where(b[..., 1] > a[..., 1], turn > 0.0, turn < 0.0)
    return (spans & right).sum(axis=1) % 2 == 1


def overlapping(
    along: Array, others: Array, margin: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of boxes closer than `margin` m in x and in y, `(K,)` and `(K,)` indices.

    Boxes are x0, y0, x1, y1 in m. Neighbours of those `along` `(T, 4)` lie close together, as on a
    path, which is halved until few of the `others` `(S, 4)` are left.
    """
    grown = along + np.array([-margin, -margin, margin, margin])
    first, second = [_NONE], [_NONE]
    stack = [(0, len(grown), np.arange(len(others)))]
    while stack:
        begin, end, candidates = stack.pop()
        part = grown[begin:end]
        hull = np.concatenate((part[:, :2].min(axis=0), part[:, 2:].max(axis=0)))
        candidates = candidates[_meet(hull[None], others[candidates])[0]]
        if not len(candidates):
            continue
        if end - begin > _LEAF:
            middle = (begin + end) // 2
            stack += [(middle, end, candidates), (begin, middle, candidates)]
            continue
        one, two = np.nonzero(_meet(part, others[candidates]))
        first.append(begin + one)
        second.append(candidates[two])
    return np.concatenate(first), np.concatenate(second)


def _meet(one: Array, two: Array) -> NDArray[np.bool_]:
    """Whether boxes `(A, 4)` and `(B, 4)` overlap, `(A, B)`."""
    a, b = one[:, None], two[None]
    return (
        (a[..., 0] <= b[..., 2])
        & (b[..., 0] <= a[..., 2])
        & (a[..., 1] <= b[..., 3])
        & (b[..., 1] <= a[..., 3])
    )
