"""Geometry of simple polygons: vertices `(V, 2)`, either way round, edge i from i to i + 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array

_CHUNK = 2_000_000
"""Point-edge pairs that are treated at once; bounds the memory."""


def signed_area(vertices: Array) -> float:
    """Area in m², positive for counter-clockwise vertices (shoelace formula)."""
    # Relative to the first vertex, so that a small polygon far away keeps its digits.
    x, y = (vertices - vertices[0]).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2.0


def contains(vertices: Array, points: Array) -> NDArray[np.bool_]:
    """Whether points `(N, 2)` lie inside, `(N,)`, by the parity of crossed edges.

    Points on the boundary may fall either way.
    """
    start, end = vertices, np.roll(vertices, -1, axis=0)
    inside = np.zeros(len(points), dtype=bool)
    for (ax, ay), (bx, by) in zip(start, end, strict=True):
        if ay == by:
            continue
        spans = (ay > points[:, 1]) != (by > points[:, 1])
        crossing = ax + (points[:, 1] - ay) * ((bx - ax) / (by - ay))
        inside ^= spans & (points[:, 0] < crossing)
    return inside


def distance(vertices: Array, points: Array) -> Array:
    """Distance in m of points `(N, 2)` to the polygon, `(N,)`, 0 inside."""
    result = np.empty(len(points))
    step = max(1, _CHUNK // len(vertices))
    for first in range(0, len(points), step):
        chunk = points[first : first + step]
        result[first : first + step] = np.where(
            contains(vertices, chunk), 0.0, _boundary_distance(vertices, chunk)
        )
    return result


def first_crossing(vertices: Array) -> tuple[int, int] | None:
    """The first pair of edges that touch or cross where they must not; None if it is simple.

    Neighbouring edges share a vertex, and must share nothing else.
    """
    count = len(vertices)
    start, end = vertices, np.roll(vertices, -1, axis=0)
    edge = end - start
    for i in range(count):
        following = edge[(i + 1) % count]
        folded = _cross(edge[i], following) == 0.0 and float(edge[i] @ following) <= 0.0
        if folded or not edge[i].any():
            return (i, (i + 1) % count)
        others = np.arange(i + 2, count - 1 if i == 0 else count)
        if len(others) == 0:
            continue
        hit = edges_touch(start[i], end[i], start[others], end[others])
        if hit.any():
            return (i, int(others[np.argmax(hit)]))
    return None


def meet(one: Array, other: Array) -> bool:
    """Whether two simple polygons `(N, 2)`, `(M, 2)` share a point."""
    a, b = one[:, None], np.roll(one, -1, axis=0)[:, None]
    c, d = other[None], np.roll(other, -1, axis=0)[None]
    if edges_touch(a, b, c, d).any():
        return True
    return bool(contains(other, one[:1])[0] or contains(one, other[:1])[0])


def gap(one: Array, other: Array) -> float:
    """Distance in m between two simple polygons `(N, 2)`, `(M, 2)`, 0 where they meet."""
    if meet(one, other):
        return 0.0
    return float(min(_boundary_distance(one, other).min(), _boundary_distance(other, one).min()))


def edges_touch(a: Array, b: Array, c: Array, d: Array) -> NDArray[np.bool_]:
    """Whether segments a-b and c-d share a point, `(...)`; ends are `(..., 2)`."""
    # Segments meet if each straddles the other's line.
    hit = np.sign(_cross(b - a, c - a)) * np.sign(_cross(b - a, d - a)) <= 0
    hit &= np.sign(_cross(d - c, a - c)) * np.sign(_cross(d - c, b - c)) <= 0
    # Those on one line pass both tests; they touch only if their bounding boxes do.
    low, high = np.minimum(c, d), np.maximum(c, d)
    near = (low <= np.maximum(a, b)) & (high >= np.minimum(a, b))
    return np.asarray(hit & near.all(axis=-1))


def _cross(u: Array, v: Array) -> Array:
    """The z component of the cross product of planar vectors `(..., 2)`."""
    result: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return result


def _boundary_distance(vertices: Array, points: Array) -> Array:
    """Distance in m of points `(N, 2)` to the nearest edge, `(N,)`."""
    edge = np.roll(vertices, -1, axis=0) - vertices
    away = points[:, None, :] - vertices[None, :, :]
    along = np.einsum("nvi,vi->nv", away, edge) / np.einsum("vi,vi->v", edge, edge)
    rest = away - np.clip(along, 0.0, 1.0)[:, :, None] * edge
    nearest: Array = np.sqrt(np.einsum("nvi,nvi->nv", rest, rest).min(axis=1))
    return nearest
