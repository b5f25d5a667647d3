"""Clearances of boxes that move among obstacles, compiled. Metres and radians.

Those named clearances look at many poses and keep running minima in `best` `(2,)`: the smallest
distance from a centre to a surface, and the smallest gap between a box and a surface. `contact`
`(M,)` becomes True where the box touches something. Exact distances are computed only where a bound
says that they can lower a minimum or be a contact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.boxes import (
    box_corners,
    box_polygon_gap,
    boxes_gap,
    point_box,
    point_polygon,
)
from cavalcade.kernels import kernel, subroutine


class Box(NamedTuple):
    """An inflated rectangle, see `cavalcade.geometry.boxes`; all in m."""

    length: float
    width: float
    inflation: float


class Polygons(NamedTuple):
    """Simple polygons in one table.

    Attributes:
        vertices: `(V, 2)` m, one polygon after the other.
        starts: `(K + 1,)` where each begins; the last entry is `V`.
        rings: `(K, 3)` discs x, y, radius that hold them.
    """

    vertices: Array
    starts: NDArray[np.int64]
    rings: Array


class Cells(NamedTuple):
    """Occupied cells of a grid, as squares.

    Attributes:
        occupied: `(rows, cols)`.
        bound: `(rows, cols)` m, at most the distance from anywhere in a cell to an occupied one.
        cell: Side of a cell, m.
    """

    occupied: NDArray[np.bool_]
    bound: Array
    cell: float


@subroutine
def box_radius(box):
    """Distance of a box's farthest point from its centre, m."""
    return 0.5 * math.hypot(box.length, box.width) + box.inflation


@kernel
def circles_clearance(poses, box, circles, best, contact):
    """Judge poses `(M, 3)` of a box against discs `(K, 3)` x, y, radius."""
    reach = box_radius(box)
    for m in range(poses.shape[0]):
        x, y, yaw = poses[m, 0], poses[m, 1], poses[m, 2]
        for k in range(circles.shape[0]):
            cx, cy, radius = circles[k, 0], circles[k, 1], circles[k, 2]
            centre = max(math.hypot(x - cx, y - cy) - radius, 0.0)
            best[0] = min(best[0], centre)
            if centre - reach < best[1] or centre <= reach:
                gap = point_box(cx, cy, x, y, yaw, box.length, box.width) - radius - box.inflation
                best[1] = min(best[1], max(gap, 0.0))
                contact[m] |= gap <= 0.0


@kernel
def polygons_clearance(poses, box, polygons, best, contact):
    """Judge poses `(M, 3)` of a box against `Polygons`."""
    reach = box_radius(box)
    vertices, starts, rings = polygons
    corners = np.empty((4, 2))
    for m in range(poses.shape[0]):
        x, y, yaw = poses[m, 0], poses[m, 1], poses[m, 2]
        for k in range(rings.shape[0]):
            bound = math.hypot(x - rings[k, 0], y - rings[k, 1]) - rings[k, 2]
            if bound >= best[0] and bound - reach >= best[1] and bound > reach:
                continue
            polygon = vertices[starts[k] : starts[k + 1]]
            centre = point_polygon(x, y, polygon)
            best[0] = min(best[0], centre)
            if centre - reach < best[1] or centre <= reach:
                box_corners(x, y, yaw, box.length, box.width, corners)
                gap = box_polygon_gap(corners, polygon, box.inflation)
                best[1] = min(best[1], gap)
                contact[m] |= gap <= 0.0


@kernel
def cells_clearance(poses, order, box, cells, best, contact):
    """Judge poses `(M, 3)` of a box, given in the grid's own frame, against `Cells`.

    They are looked at in `order` `(M,)`; the nearest first is fastest.
    """
    reach = box_radius(box)
    occupied, bound, cell = cells
    rows, cols = occupied.shape
    corners = np.empty((4, 2))
    square = np.empty((4, 2))
    for m in order:
        x, y, yaw = poses[m, 0], poses[m, 1], poses[m, 2]
        row = min(max(int(math.floor(y / cell)), 0), rows - 1)
        col = min(max(int(math.floor(x / cell)), 0), cols - 1)
        low = bound[row, col]
        if low >= best[0] and low - reach >= best[1] and low > reach:
            continue
        box_corners(x, y, yaw, box.length, box.width, corners)
        # Squares farther away than this matter to neither minimum nor contact; `low` falls short
        # of the nearest square by less than three cells.
        far = min(max(best[0], best[1] + reach), max(low, 0.0) + 3.0 * cell + reach)
        span = int(math.ceil(far / cell)) + 1
        for r in range(max(row - span, 0), min(row + span + 1, rows)):
            for c in range(max(col - span, 0), min(col + span + 1, cols)):
                if not occupied[r, c]:
                    continue
                mx, my = (c + 0.5) * cell, (r + 0.5) * cell
                u = max(abs(mx - x) - 0.5 * cell, 0.0)
                v = max(abs(my - y) - 0.5 * cell, 0.0)
                centre = math.hypot(u, v)
                best[0] = min(best[0], centre)
                if centre - reach >= best[1] and centre > reach:
                    continue
                # A disc around the square falls short of it; where even that may count, exactly.
                at_least = point_box(mx, my, x, y, yaw, box.length, box.width)
                at_least = at_least - 0.7072 * cell - box.inflation
                if at_least < best[1] or (at_least <= 0.0 and not contact[m]):
                    box_corners(mx, my, 0.0, cell, cell, square)
                    gap = box_polygon_gap(corners, square, box.inflation)
                    best[1] = min(best[1], gap)
                    contact[m] |= gap <= 0.0


@kernel
def boxes_clearance(one, other, sizes, best, contact):
    """Judge two boxes that move at the same time: poses `(M, 3)` each.

    Their length, width and inflation are `sizes` `(2, 3)`, m; `best[0]` is of their centres.
    """
    reach = 0.5 * (math.hypot(sizes[0, 0], sizes[0, 1]) + math.hypot(sizes[1, 0], sizes[1, 1]))
    reach += sizes[0, 2] + sizes[1, 2]
    first, second = np.empty((4, 2)), np.empty((4, 2))
    for m in range(one.shape[0]):
        centre = math.hypot(one[m, 0] - other[m, 0], one[m, 1] - other[m, 1])
        best[0] = min(best[0], centre)
        if centre - reach < best[1] or centre <= reach:
            gap = boxes_gap(one[m], other[m], sizes[0], sizes[1], first, second)
            best[1] = min(best[1], gap)
            contact[m] |= gap <= 0.0


@kernel
def nearest_gaps(poses, bodies):
    """The smallest gap `(K, N)` m of each body to any other at each time, inf if it is alone.

    Poses `(K, N, 3)` are x, y, yaw, bodies `(N, 3)` length, width and inflation.
    """
    count, robots = poses.shape[0], poses.shape[1]
    gaps = np.full((count, robots), np.inf)
    first, second = np.empty((4, 2)), np.empty((4, 2))
    for k in range(count):
        for a in range(robots):
            for b in range(a):
                away = math.hypot(poses[k, a, 0] - poses[k, b, 0], poses[k, a, 1] - poses[k, b, 1])
                reach = bodies[a, 2] + bodies[b, 2]
                reach += 0.5 * (
                    math.hypot(bodies[a, 0], bodies[a, 1]) + math.hypot(bodies[b, 0], bodies[b, 1])
                )
                # The bound says that neither minimum can change.
                if away - reach >= gaps[k, a] and away - reach >= gaps[k, b]:
                    continue
                gap = boxes_gap(poses[k, a], poses[k, b], bodies[a], bodies[b], first, second)
                gaps[k, a] = min(gaps[k, a], gap)
                gaps[k, b] = min(gaps[k, b], gap)
    return gaps
