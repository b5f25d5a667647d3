"""Oriented boxes, discs and polygons: distances between them, and whether they meet. Compiled.

Metres and radians. A box is a rectangle that is inflated by so many metres all around: without
extent it is a disc, without inflation the rectangle itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cavalcade.kernels import kernel, subroutine

TOUCHING = 1e-9
"""Surfaces closer than this touch, m."""


@subroutine
def point_segment(px, py, ax, ay, bx, by):
    """Distance of a point to a segment."""
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    along = 0.0
    if square > 0.0:
        along = min(max(((px - ax) * dx + (py - ay) * dy) / square, 0.0), 1.0)
    return math.hypot(px - ax - along * dx, py - ay - along * dy)


@subroutine
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


@subroutine
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


@subroutine
def _side(ax, ay, bx, by, px, py):
    """Positive for a point to the left of the line from a to b, negative to its right."""
    return (bx - ax) * (py - ay) - (by - ay) * (px - ax)


@subroutine
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


@subroutine
def box_polygon_gap(corners, polygon, inflation):
    """Distance between a box of these corners and a polygon, 0 where they meet."""
    gap = polygons_gap(corners, polygon) - inflation
    return gap if gap > TOUCHING else 0.0


@subroutine
def box_corners(x, y, yaw, length, width, out):
    """Write the corners of a box, without its inflation, counter-clockwise to `out` `(4, 2)`."""
    c, s = math.cos(yaw), math.sin(yaw)
    for i in range(4):
        u = 0.5 * length if i == 0 or i == 3 else -0.5 * length
        v = 0.5 * width if i < 2 else -0.5 * width
        out[i, 0] = x + c * u - s * v
        out[i, 1] = y + s * u + c * v


@subroutine
def point_box(px, py, x, y, yaw, length, width):
    """Distance of a point to a box without inflation, 0 inside."""
    c, s = math.cos(yaw), math.sin(yaw)
    u = abs(c * (px - x) + s * (py - y)) - 0.5 * length
    v = abs(c * (py - y) - s * (px - x)) - 0.5 * width
    return math.hypot(max(u, 0.0), max(v, 0.0))


@subroutine
def boxes_gap(one, other, first, second, a, b):
    """Distance between two boxes, 0 where they meet.

    They are at poses `(3,)`; `first` and `second` `(3,)` are their length, width and inflation, m.
    Corners are written to `a` and `b` `(4, 2)`.
    """
    box_corners(one[0], one[1], one[2], first[0], first[1], a)
    box_corners(other[0], other[1], other[2], second[0], second[1], b)
    return box_polygon_gap(a, b, first[2] + second[2])


class Footprint(NamedTuple):
    """What a robot covers of the ground, for tests that ask whether rather than how far.

    Attributes:
        half_length, half_width: m; of a disc both are its radius.
        round: Whether it is a disc.
    """

    half_length: float
    half_width: float
    round: bool


@subroutine
def footprint_at(shapes, k):
    """Row `k` of a table `(K, 3)`: half length, half width, 1 for a disc."""
    return Footprint(shapes[k, 0], shapes[k, 1], shapes[k, 2] > 0.0)


@subroutine
def footprint_radius(footprint):
    """Distance of a footprint's farthest point from its centre, m."""
    if footprint.round:
        return footprint.half_length
    return math.sqrt(
        footprint.half_length * footprint.half_length + footprint.half_width * footprint.half_width
    )


@kernel
def footprints_meet(one, here, other, there, margin):
    """Whether two footprints are nearer than `margin` m (boxes at corners: a little more)."""
    dx, dy = there[0] - here[0], there[1] - here[1]
    hl0, hw0, hl1, hw1 = one.half_length, one.half_width, other.half_length, other.half_width
    # The circles around both decide most cases, and those within both some more.
    distance = dx * dx + dy * dy
    far = footprint_radius(one) + footprint_radius(other) + margin
    if distance >= far * far:
        return False
    near = (hl0 if one.round else hw0) + (hl1 if other.round else hw1) + margin
    if distance < near * near:
        return True
    if one.round and other.round:
        return False
    if one.round:
        return _disc_meets_box(-dx, -dy, there[2], other, hl0 + margin)
    if other.round:
        return _disc_meets_box(dx, dy, here[2], one, hl1 + margin)
    # Two boxes: the separating axis theorem, along the axes of either.
    c0, s0, c1, s1 = math.cos(here[2]), math.sin(here[2]), math.cos(there[2]), math.sin(there[2])
    c, s = abs(c0 * c1 + s0 * s1), abs(c0 * s1 - s0 * c1)
    if abs(c0 * dx + s0 * dy) >= hl0 + c * hl1 + s * hw1 + margin:
        return False
    if abs(c0 * dy - s0 * dx) >= hw0 + s * hl1 + c * hw1 + margin:
        return False
    if abs(c1 * dx + s1 * dy) >= hl1 + c * hl0 + s * hw0 + margin:
        return False
    return abs(c1 * dy - s1 * dx) < hw1 + s * hl0 + c * hw0 + margin


@subroutine
def _disc_meets_box(dx, dy, yaw, box, radius):
    """Whether a disc at (dx, dy) from a box's centre is nearer to it than its radius."""
    c, s = math.cos(yaw), math.sin(yaw)
    u = max(abs(c * dx + s * dy) - box.half_length, 0.0)
    v = max(abs(c * dy - s * dx) - box.half_width, 0.0)
    return u * u + v * v < radius * radius
