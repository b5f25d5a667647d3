"""Clearances of oriented footprints, for the safety filter and dynamic avoidance. Compiled.

The checker judges by other code of its own; nothing here is shared with it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.kernels import subroutine

_NEAR = 3.0
"""Cells: nearer to an obstacle than this, distances are exact."""
_EXCESS = 0.65
"""Bilinear interpolation overstates distances d of at least `_NEAR` cells by less than this times
cell² a (1 - a) / d, a being the place between two centres: the distance to a point is as curved as
a circle around it, and the bound holds for the nearest point of what stands."""


class DistanceMap(NamedTuple):
    """What stands.

    Attributes:
        distances: `(rows, cols)` from each cell's centre to the nearest obstacle's surface, m.
        cell: Cell size, m.
    """

    distances: np.ndarray
    cell: float


class ObstacleBoxes(NamedTuple):
    """What moves: dynamic obstacles as the rectangles around them, in the grid's frame.

    Attributes:
        poses: `(M, 3)` x, y in m and yaw in rad.
        half: `(M, 2)` half lengths and half widths, m.
        velocities: `(M, 2)` m/s.
    """

    poses: np.ndarray
    half: np.ndarray
    velocities: np.ndarray

    @classmethod
    def none(cls) -> ObstacleBoxes:
        """Nothing moves."""
        return cls(np.empty((0, 3)), np.empty((0, 2)), np.empty((0, 2)))


class Surroundings(NamedTuple):
    """What robots keep clear of besides one another: a `DistanceMap`'s and `ObstacleBoxes`' parts.

    It is flat because every record within a record takes its time at each call from Python.
    """

    distances: np.ndarray
    cell: float
    poses: np.ndarray
    half: np.ndarray
    velocities: np.ndarray


class Footprint(NamedTuple):
    """A robot's body seen from above: a rectangle, and discs that cover it.

    Attributes:
        half: `(2,)` half length and half width, m.
        discs: `(K, 2)` centres of the discs in the body's frame, m.
        radius: Of the discs, m.
    """

    half: np.ndarray
    discs: np.ndarray
    radius: float

    @classmethod
    def of(cls, length: float, width: float, columns: int = 4, rows: int = 1) -> Footprint:
        """A rectangle with the least discs of one size, in rows along the body, that cover it."""
        step, lane = length / columns, width / rows
        x = (np.arange(columns) - (columns - 1) / 2.0) * step
        y = (np.arange(rows) - (rows - 1) / 2.0) * lane
        discs = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        radius = float(np.hypot(step / 2.0, lane / 2.0))
        return cls(np.array([length, width]) / 2.0, discs, radius)


class Rectangle(NamedTuple):
    """A placed rectangle.

    Attributes:
        x, y: Its centre, m.
        cos, sin: Of its heading.
        half_length, half_width: m.
    """

    x: float
    y: float
    cos: float
    sin: float
    half_length: float
    half_width: float


class Gap(NamedTuple):
    """The gap between two rectangles a and b.

    Attributes:
        distance: m; negative where they overlap: the depth.
        nx, ny: Unit normal from b towards a.
        ax, ay: The point of a nearest to b, m.
        bx, by: The point of b nearest to a, m.
    """

    distance: float
    nx: float
    ny: float
    ax: float
    ay: float
    bx: float
    by: float


@subroutine
def nearest_square(map, x, y, bound):
    """The occupied cell nearest to a point, as a square.

    Returns:
        Its distance, m, 0 inside; and its point nearest to (x, y), m. Without one within `bound` m
        the distance is `bound`.
    """
    distance, cell = map.distances, map.cell
    rows, cols = distance.shape
    best, qx, qy = bound, x, y
    row = int(math.floor(y / cell))
    span = int(math.ceil(bound / cell)) + 1
    for k in range(2 * span + 1):  # the own row, then those above and below it
        r = row + (k + 1) // 2 if k % 2 == 1 else row - k // 2
        dy = max(max(r * cell - y, y - (r + 1) * cell), 0.0)
        if r < 0 or r >= rows or dy >= best:
            continue
        reach = math.sqrt(best * best - dy * dy)
        c = max(int(math.floor((x - reach) / cell)), 0)
        last = min(int(math.floor((x + reach) / cell)), cols - 1)
        while c <= last:
            away = distance[r, c]
            if away > 0.0:  # free, and so are the cells up to that distance from its centre
                c += max(int(away / cell + 0.5), 1)
                continue
            dx = max(max(c * cell - x, x - (c + 1) * cell), 0.0)
            found = math.hypot(dx, dy)
            if found < best:
                best = found
                qx = min(max(x, c * cell), (c + 1) * cell)
                qy = min(max(y, r * cell), (r + 1) * cell)
            c += 1
    return best, qx, qy


@subroutine
def distance_at(map, x, y):
    """Distance to the nearest obstacle at a point, m, and which way it grows: `(2,)`.

    Never more than there is, whatever the size of the cells: exact up to some `_NEAR` cells, by
    interpolation between the centres of cells, less what that may promise too much, farther off.
    The gradient is the interpolant's, whose length tells ridges, but for the last cell before an
    obstacle, where it has no meaning. Beyond the border the distance is negative: all ground out
    there is occupied.
    """
    distance, cell = map.distances, map.cell
    rows, cols = distance.shape
    u = min(max(x / cell - 0.5, 0.0), cols - 1.0)
    v = min(max(y / cell - 0.5, 0.0), rows - 1.0)
    c, r = min(int(u), max(cols - 2, 0)), min(int(v), max(rows - 2, 0))
    c1, r1 = min(c + 1, cols - 1), min(r + 1, rows - 1)
    a, b = u - c, v - r
    d00, d01, d10, d11 = distance[r, c], distance[r, c1], distance[r1, c], distance[r1, c1]
    value = (d00 * (1 - a) + d01 * a) * (1 - b) + (d10 * (1 - a) + d11 * a) * b
    gx = ((d01 - d00) * (1 - b) + (d11 - d10) * b) / cell
    gy = ((d10 - d00) * (1 - a) + (d11 - d01) * a) / cell
    # Along the border, too, the nearest of the four centres is less than a cell away.
    edge = min(min(x, cols * cell - x), min(y, rows * cell - y))
    if value >= _NEAR * cell:
        value -= _EXCESS * cell * cell * max(a * (1 - a), b * (1 - b)) / value
    elif edge > 0.0:
        value, qx, qy = nearest_square(map, x, y, min(min(d00, d01), min(d10, d11)) + 1.5 * cell)
        if 0.0 < value < cell and (qx != x or qy != y):
            gx, gy = (x - qx) / value, (y - qy) / value
    # Nothing beyond the border is in the map: measure to the border itself.
    if edge < value:
        value = edge
        gx = 1.0 if edge == x else (-1.0 if edge == cols * cell - x else 0.0)
        gy = 0.0 if gx != 0.0 else (1.0 if edge == y else -1.0)
    return value, gx, gy


@subroutine
def rectangle(pose, half):
    """The `Rectangle` at a pose `(3,)` with half length and half width `(2,)`, m."""
    return Rectangle(pose[0], pose[1], math.cos(pose[2]), math.sin(pose[2]), half[0], half[1])


@subroutine
def corner(box, k):
    """Corner k of 0..3 of a rectangle, m."""
    i, j = (1.0 if k < 2 else -1.0), (1.0 if k % 2 == 0 else -1.0)
    return (
        box.x + box.cos * i * box.half_length - box.sin * j * box.half_width,
        box.y + box.sin * i * box.half_length + box.cos * j * box.half_width,
    )


@subroutine
def point_rectangle(px, py, box):
    """Distance from a point to a rectangle, m, and the nearest point of it; 0 inside."""
    c, s = box.cos, box.sin
    dx, dy = px - box.x, py - box.y
    bx, by = c * dx + s * dy, -s * dx + c * dy
    qx = min(max(bx, -box.half_length), box.half_length)
    qy = min(max(by, -box.half_width), box.half_width)
    return math.hypot(bx - qx, by - qy), box.x + c * qx - s * qy, box.y + s * qx + c * qy


@subroutine
def rectangle_gap(a, b):
    """The signed `Gap` between two rectangles; where they overlap, its points are the middle."""
    dx, dy = a.x - b.x, a.y - b.y
    # The axis of greatest separation tells overlap, and its depth.
    depth, nx, ny = -np.inf, 1.0, 0.0
    for k in range(4):
        ux = a.cos if k == 0 else (-a.sin if k == 1 else (b.cos if k == 2 else -b.sin))
        uy = a.sin if k == 0 else (a.cos if k == 1 else (b.sin if k == 2 else b.cos))
        along = dx * ux + dy * uy
        reach = (
            a.half_length * abs(a.cos * ux + a.sin * uy)
            + a.half_width * abs(-a.sin * ux + a.cos * uy)
            + b.half_length * abs(b.cos * ux + b.sin * uy)
            + b.half_width * abs(-b.sin * ux + b.cos * uy)
        )
        if abs(along) - reach > depth:
            depth = abs(along) - reach
            sign = 1.0 if along >= 0.0 else -1.0
            nx, ny = sign * ux, sign * uy
    if depth <= 0.0:
        mx, my = 0.5 * (a.x + b.x), 0.5 * (a.y + b.y)
        return Gap(depth, nx, ny, mx, my, mx, my)
    # Apart: a corner of one is nearest to the other.
    best = np.inf
    px, py, qx, qy = 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        vx, vy = corner(a, k)
        d, rx, ry = point_rectangle(vx, vy, b)
        if d < best:
            best, px, py, qx, qy = d, vx, vy, rx, ry
        vx, vy = corner(b, k)
        d, rx, ry = point_rectangle(vx, vy, a)
        if d < best:
            best, px, py, qx, qy = d, rx, ry, vx, vy
    if best > 1e-9:
        nx, ny = (px - qx) / best, (py - qy) / best
    return Gap(best, nx, ny, px, py, qx, qy)


@subroutine
def contact_centres(a, b, gap, slop):
    """Centres of the parts of two rectangles that lie within `slop` m of their `gap`.

    Between parallel faces the nearest points jump from corner to corner with the slightest turn;
    these do not.

    Returns:
        The point on a (2) and the point on b (2), m.
    """
    if gap.distance <= 0.0:
        return gap.ax, gap.ay, gap.bx, gap.by
    total, ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        vx, vy = corner(a, k)
        d, rx, ry = point_rectangle(vx, vy, b)
        weight = max(0.0, 1.0 - (d - gap.distance) / slop)
        total += weight
        ax, ay, bx, by = ax + weight * vx, ay + weight * vy, bx + weight * rx, by + weight * ry
        vx, vy = corner(b, k)
        d, rx, ry = point_rectangle(vx, vy, a)
        weight = max(0.0, 1.0 - (d - gap.distance) / slop)
        total += weight
        ax, ay, bx, by = ax + weight * rx, ay + weight * ry, bx + weight * vx, by + weight * vy
    return ax / total, ay / total, bx / total, by / total
