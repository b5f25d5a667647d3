"""Distances between oriented rectangles and obstacles, compiled. Metres and radians.

All functions that look at many poses keep running minima in `best` `(2,)`: the smallest distance
from a centre to a surface, and the smallest gap between a body and a surface. Exact distances are
computed only where a bound says that they can lower a minimum or be a contact.

A body is a rectangle that is grown by `grown` m all around: with no extent a disc, with none grown
the rectangle itself.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

TOUCHING = 1e-9
"""Surfaces closer than this touch, m."""


@njit(cache=True)
def point_segment(px, py, ax, ay, bx, by):
    """Distance of a point to a segment."""
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    along = 0.0
    if square > 0.0:
        along = min(max(((px - ax) * dx + (py - ay) * dy) / square, 0.0), 1.0)
    return math.hypot(px - ax - along * dx, py - ay - along * dy)


@njit(cache=True)
def inside_polygon(px, py, vertices):
    """Whether a point lies in a simple polygon `(V, 2)`, by the parity of crossed edges."""
    inside = False
    count = vertices.shape[0]
    for i in range(count):
        ax, ay = vertices[i - 1, 0], vertices[i - 1, 1]
        bx, by = vertices[i, 0], vertices[i, 1]
        if (ay > py) != (by > py) and px < ax + (py - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside


@njit(cache=True)
def point_polygon(px, py, vertices):
    """Distance of a point to a simple polygon, 0 inside."""
    if inside_polygon(px, py, vertices):
        return 0.0
    nearest = math.inf
    for i in range(vertices.shape[0]):
        distance = point_segment(
            px, py, vertices[i - 1, 0], vertices[i - 1, 1], vertices[i, 0], vertices[i, 1]
        )
        nearest = min(nearest, distance)
    return nearest


@njit(cache=True)
def _side(ax, ay, bx, by, px, py):
    return (bx - ax) * (py - ay) - (by - ay) * (px - ax)


@njit(cache=True)
def polygons_gap(one, other):
    """Distance between two simple polygons, 0 where they meet or one holds the other."""
    if inside_polygon(one[0, 0], one[0, 1], other) or inside_polygon(other[0, 0], other[0, 1], one):
        return 0.0
    nearest = math.inf
    for i in range(one.shape[0]):
        ax, ay, bx, by = one[i - 1, 0], one[i - 1, 1], one[i, 0], one[i, 1]
        for j in range(other.shape[0]):
            cx, cy, dx, dy = other[j - 1, 0], other[j - 1, 1], other[j, 0], other[j, 1]
            apart = _side(ax, ay, bx, by, cx, cy) * _side(ax, ay, bx, by, dx, dy)
            astride = _side(cx, cy, dx, dy, ax, ay) * _side(cx, cy, dx, dy, bx, by)
            if apart < 0.0 and astride < 0.0:
                return 0.0
            nearest = min(nearest, point_segment(ax, ay, cx, cy, dx, dy))
            nearest = min(nearest, point_segment(cx, cy, ax, ay, bx, by))
    # Edges that lie on each other come out as some 1e-17 m apart.
    return nearest if nearest > TOUCHING else 0.0


@njit(cache=True)
def body_gap(corners, polygon, grown):
    """Distance between a body of these corners and a polygon, 0 where they meet."""
    gap = polygons_gap(corners, polygon) - grown
    return gap if gap > TOUCHING else 0.0


@njit(cache=True)
def body_corners(x, y, yaw, length, width, out):
    """Corners of a body, counter-clockwise, into `out` `(4, 2)`."""
    c, s = math.cos(yaw), math.sin(yaw)
    for i in range(4):
        u = 0.5 * length if i == 0 or i == 3 else -0.5 * length
        v = 0.5 * width if i < 2 else -0.5 * width
        out[i, 0] = x + c * u - s * v
        out[i, 1] = y + s * u + c * v


@njit(cache=True)
def point_body(px, py, x, y, yaw, length, width):
    """Distance of a point to a body, 0 inside."""
    c, s = math.cos(yaw), math.sin(yaw)
    u = abs(c * (px - x) + s * (py - y)) - 0.5 * length
    v = abs(c * (py - y) - s * (px - x)) - 0.5 * width
    return math.hypot(max(u, 0.0), max(v, 0.0))


@njit(cache=True)
def circles_clearance(poses, length, width, grown, circles, best, contact):
    """Judge poses `(M, 3)` of one body against discs `(K, 3)` x, y, radius.

    `contact` `(M,)` becomes True where the body touches one.
    """
    reach = 0.5 * math.hypot(length, width) + grown
    for m in range(poses.shape[0]):
        x, y, yaw = poses[m, 0], poses[m, 1], poses[m, 2]
        for k in range(circles.shape[0]):
            cx, cy, radius = circles[k, 0], circles[k, 1], circles[k, 2]
            centre = max(math.hypot(x - cx, y - cy) - radius, 0.0)
            best[0] = min(best[0], centre)
            if centre - reach < best[1] or centre <= reach:
                gap = point_body(cx, cy, x, y, yaw, length, width) - radius - grown
                best[1] = min(best[1], max(gap, 0.0))
                contact[m] |= gap <= 0.0


@njit(cache=True)
def polygons_clearance(poses, length, width, grown, vertices, starts, rings, best, contact):
    """Judge poses `(M, 3)` of one body against polygons.

    Polygon k has the vertices from `starts[k]` to `starts[k + 1]` of `vertices` `(V, 2)` and lies
    within the disc `rings[k]` = x, y, radius.
    """
    reach = 0.5 * math.hypot(length, width) + grown
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
                body_corners(x, y, yaw, length, width, corners)
                gap = body_gap(corners, polygon, grown)
                best[1] = min(best[1], gap)
                contact[m] |= gap <= 0.0


@njit(cache=True)
def cells_clearance(poses, order, length, width, grown, occupied, bound, cell, best, contact):
    """Judge poses `(M, 3)`, given in the grid's own frame, against its occupied cells as squares.

    Args:
        order: Indices `(M,)` in which to look at them; the nearest first is fastest.
        occupied: `(rows, cols)`.
        bound: `(rows, cols)` m, at most the distance from anywhere in a cell to an occupied one.
        cell: m.
    """
    reach = 0.5 * math.hypot(length, width) + grown
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
        body_corners(x, y, yaw, length, width, corners)
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
                at_least = point_body(mx, my, x, y, yaw, length, width) - 0.7072 * cell - grown
                if at_least < best[1] or (at_least <= 0.0 and not contact[m]):
                    body_corners(mx, my, 0.0, cell, cell, square)
                    gap = body_gap(corners, square, grown)
                    best[1] = min(best[1], gap)
                    contact[m] |= gap <= 0.0


@njit(cache=True)
def bodies_clearance(one, other, sizes, best, contact):
    """Judge two bodies that move at the same time: poses `(M, 3)` each.

    Args:
        sizes: `(2, 3)` length, width and `grown` of each.
        best: `(2,)` smallest distance of the centres and smallest gap.
        contact: `(M,)` becomes True where they touch.
    """
    grown = sizes[0, 2] + sizes[1, 2]
    reach = 0.5 * (math.hypot(sizes[0, 0], sizes[0, 1]) + math.hypot(sizes[1, 0], sizes[1, 1]))
    reach += grown
    first, second = np.empty((4, 2)), np.empty((4, 2))
    for m in range(one.shape[0]):
        centre = math.hypot(one[m, 0] - other[m, 0], one[m, 1] - other[m, 1])
        best[0] = min(best[0], centre)
        if centre - reach < best[1] or centre <= reach:
            body_corners(one[m, 0], one[m, 1], one[m, 2], sizes[0, 0], sizes[0, 1], first)
            body_corners(other[m, 0], other[m, 1], other[m, 2], sizes[1, 0], sizes[1, 1], second)
            gap = body_gap(first, second, grown)
            best[1] = min(best[1], gap)
            contact[m] |= gap <= 0.0
