"""Exact outlines of obstacles, so that what meets only a cell of one does not count as contact.

Cells that an outline leads through are taken to be solid by whoever knows no better; here a body
in them is tested against the edges themselves. Everything is in the grid's own frame, m.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.eikonal import surface_distance
from cavalcade.geometry import Array, inverse_transform_points
from cavalcade.kernels import subroutine
from cavalcade.world import Box, Circle, Shape

NEAR = 2.0
"""How far from an outline distances are exact, m; farther away they are those to cells."""

_SLACK = 1e-9
"""Bodies that overlap by less only touch, m."""


class Outlines(NamedTuple):
    """Which outlines lead through which cell.

    Attributes:
        part: `(rows, cols)` number of a cell that is solid in part; -1 of all others. `(0, 0)`
            where nothing is known but cells.
        first: `(C + 1,)` where the list of each such cell begins in `listed`.
        listed: `(P,)` which edges lead through it.
        edges: `(E, 6)` both ends x, y, then a radius: an edge of a polygon has none, a disc is one
            point with a radius; and the number of the shape.
    """

    part: NDArray[np.int32]
    first: NDArray[np.int64]
    listed: NDArray[np.int64]
    edges: Array


NO_OUTLINES = Outlines(
    np.zeros((0, 0), dtype=np.int32),
    np.zeros(1, dtype=np.int64),
    np.zeros(0, dtype=np.int64),
    np.zeros((0, 6)),
)


def outlines_of(
    shapes: Sequence[Shape], origin: ArrayLike, cell: float, solid: NDArray, cells: NDArray
) -> tuple[Outlines, Array]:
    """The outlines of shapes of the map frame, and the clearance that they leave.

    Args:
        shapes: Obstacles.
        origin: Pose of the grid in the map frame.
        cell: Its resolution, m.
        solid: `(rows, cols)` cells that are solid, those that the shapes touch included.
        cells: `(rows, cols)` those that are solid whatever the shapes.

    Returns:
        The outlines, and the clearance `(rows, cols)` of the cells' centres, m.
    """
    edges = _edges(shapes, origin)
    met: list[NDArray[np.int64]] = []
    nearest = np.full(solid.shape, np.inf)
    for edge in edges:
        met.append(_meet(edge, cell, nearest))
    index = np.repeat(np.arange(len(edges)), [len(found) for found in met])
    where = np.concatenate(met) if met else np.zeros(0, dtype=np.int64)
    kept = (solid & ~cells).ravel()[where]
    where, index = where[kept], index[kept]
    order = np.argsort(where, kind="stable")
    found, counts = np.unique(where, return_counts=True)
    part = np.full(solid.shape, -1, dtype=np.int32)
    part.ravel()[found] = np.arange(len(found))
    first = np.concatenate([[0], np.cumsum(counts)])
    exact = np.minimum(surface_distance(solid & (part < 0), cell), nearest)
    rough = surface_distance(solid, cell)
    clearance = np.where(exact <= NEAR, exact, np.maximum(NEAR, rough))
    return Outlines(part, first, index[order], edges), np.ascontiguousarray(clearance)


def _edges(shapes: Sequence[Shape], origin: ArrayLike) -> Array:
    rows: list[Array] = []
    for number, shape in enumerate(shapes):
        if isinstance(shape, Circle):
            x, y = inverse_transform_points(origin, [shape.center])[0]
            rows.append(np.array([[x, y, x, y, shape.radius, number]]))
            continue
        corners = shape.corners if isinstance(shape, Box) else shape.vertices
        ends = inverse_transform_points(origin, corners)
        rest = np.broadcast_to((0.0, float(number)), (len(ends), 2))
        rows.append(np.column_stack([ends, np.roll(ends, -1, axis=0), rest]))
    return np.concatenate([np.zeros((0, 6)), *rows])


def _meet(edge: Array, cell: float, nearest: Array) -> NDArray[np.int64]:
    """Flat numbers of the cells that an edge leads through; centres near it learn how near.

    Of a disc, cells that lie in it are none of these.
    """
    rows, cols = nearest.shape
    (x0, y0, x1, y1), radius = edge[:4], edge[4]
    low = np.floor((np.minimum(edge[:2], edge[2:4]) - radius - NEAR) / cell).astype(int)
    high = np.ceil((np.maximum(edge[:2], edge[2:4]) + radius + NEAR) / cell).astype(int)
    (left, bottom), (right, top) = np.maximum(low, 0), np.minimum(high, (cols, rows))
    if left >= right or bottom >= top:
        return np.zeros(0, dtype=np.int64)
    x = ((np.arange(left, right) + 0.5) * cell)[None, :]
    y = ((np.arange(bottom, top) + 0.5) * cell)[:, None]
    dx, dy = x1 - x0, y1 - y0
    along = ((x - x0) * dx + (y - y0) * dy) / max(dx * dx + dy * dy, 1e-300)
    along = np.clip(along, 0.0, 1.0)
    away = np.hypot(x - x0 - along * dx, y - y0 - along * dy) - radius
    view = nearest[bottom:top, left:right]
    np.minimum(view, np.maximum(away, 0.0), out=view)
    half = cell / 2.0 + _SLACK
    beyond_x = np.maximum(np.maximum(min(x0, x1) - half - x, x - max(x0, x1) - half), 0.0)
    beyond_y = np.maximum(np.maximum(min(y0, y1) - half - y, y - max(y0, y1) - half), 0.0)
    touched = beyond_x**2 + beyond_y**2 <= radius**2
    touched &= np.abs(dx * (y - y0) - dy * (x - x0)) <= half * (abs(dx) + abs(dy)) + _SLACK
    if radius:
        corner = (np.abs(x - x0) + half) ** 2 + (np.abs(y - y0) + half) ** 2
        touched &= corner > radius**2
    row, col = np.nonzero(touched)
    return np.asarray((row + bottom) * cols + col + left, dtype=np.int64)


@subroutine
def partly_solid(outlines, row, col):
    """Whether outlines decide what of a cell is solid."""
    return outlines.part.shape[0] > 0 and outlines.part[row, col] >= 0


@subroutine
def within_outline(outlines, x, y):
    """Whether a point is in one of the shapes."""
    edges = outlines.edges
    inside = False
    for k in range(edges.shape[0]):
        x0, y0, x1, y1, radius = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3], edges[k, 4]
        if inside and edges[k, 5] != edges[k - 1, 5]:
            return True
        if radius > 0.0:
            inside = (x - x0) ** 2 + (y - y0) ** 2 < radius * radius
        elif (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
    return inside


@subroutine
def meets_outline(outlines, cell, pose, half, round):
    """Whether a footprint meets an outline in a cell (row, col) that is partly solid.

    `pose` is x, y, cosine and sine of the yaw; `half` half the length and width, of a disc its
    radius, m.
    """
    x, y, c, s = pose
    hl, hw = half
    k = outlines.part[cell[0], cell[1]]
    for at in range(outlines.first[k], outlines.first[k + 1]):
        edge = outlines.edges[outlines.listed[at]]
        dx, dy = edge[0] - x, edge[1] - y
        ex, ey = edge[2] - edge[0], edge[3] - edge[1]
        radius = edge[4]
        if round:
            square = ex * ex + ey * ey
            f = 0.0
            if square > 0.0:
                f = min(max(-(dx * ex + dy * ey) / square, 0.0), 1.0)
            gx, gy = dx + f * ex, dy + f * ey
            reach = hl + radius - _SLACK
            if gx * gx + gy * gy < reach * reach:
                return True
            continue
        # In the body's frame: the nearest point of a disc, or an edge cut to what is inside.
        u, v = c * dx + s * dy, c * dy - s * dx
        if radius > 0.0:
            gu, gv = max(abs(u) - hl, 0.0), max(abs(v) - hw, 0.0)
            reach = radius - _SLACK
            if gu * gu + gv * gv < reach * reach:
                return True
            continue
        du, dv = c * ex + s * ey, c * ey - s * ex
        begin, end = _cut(u, du, hl - _SLACK, 0.0, 1.0)
        begin, end = _cut(v, dv, hw - _SLACK, begin, end)
        if begin < end:
            return True
    return False


@subroutine
def _cut(at, change, limit, begin, end):
    """The part of `begin` to `end` in which at + f * change lies between -limit and limit."""
    if abs(change) < 1e-12:
        if abs(at) >= limit:
            return 1.0, 0.0
        return begin, end
    a, b = (-limit - at) / change, (limit - at) / change
    return max(begin, min(a, b)), min(end, max(a, b))
