"""Planar laser scanners: rays on the cells of a map and on the robots in it."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel, subroutine

RAYS = 360
"""Of a scan, evenly around the robot, from -pi on, counter-clockwise."""

REACH = 10.0
"""Range beyond which a ray finds nothing, m."""


@subroutine
def _cells_range(x, y, dx, dy, occupied, reach):
    """Length of a ray to the first obstacle cell, all in cells; beyond the grid all is obstacle.

    Amanatides and Woo (1987): from border to border of the cells that the ray crosses.
    """
    rows, cols = occupied.shape
    col, row = int(math.floor(x)), int(math.floor(y))
    step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    per_x = abs(1.0 / dx) if dx != 0.0 else math.inf
    per_y = abs(1.0 / dy) if dy != 0.0 else math.inf
    next_x = ((col + 1 - x) if dx > 0.0 else (x - col)) * per_x if dx != 0.0 else math.inf
    next_y = ((row + 1 - y) if dy > 0.0 else (y - row)) * per_y if dy != 0.0 else math.inf
    length = 0.0
    while length < reach:
        if row < 0 or row >= rows or col < 0 or col >= cols or occupied[row, col]:
            return length
        if next_x < next_y:
            length, col, next_x = next_x, col + step_x, next_x + per_x
        else:
            length, row, next_y = next_y, row + step_y, next_y + per_y
    return math.inf


@subroutine
def _body_range(x, y, dx, dy, body):
    """Length of a ray to a rectangle or a disc about the origin, inf beside it; 0 inside.

    `body` is length, width and inflation; a disc has inflation alone.
    """
    if body[2] > 0.0:
        along, square = x * dx + y * dy, x * x + y * y - body[2] * body[2]
        root = along * along - square
        if square <= 0.0:
            return 0.0
        return -along - math.sqrt(root) if root >= 0.0 and along < 0.0 else math.inf
    near, far = 0.0, math.inf
    for place, speed, half in ((x, dx, 0.5 * body[0]), (y, dy, 0.5 * body[1])):
        if abs(speed) < 1e-12:
            if abs(place) > half:
                return math.inf
            continue
        a, b = (-half - place) / speed, (half - place) / speed
        near, far = max(near, min(a, b)), min(far, max(a, b))
    return near if near <= far else math.inf


@kernel
def scan_team(occupied, place, poses, bodies, rays, reach):
    """Ranges `(N, rays)` in m that a scanner in the middle of each robot measures.

    Args:
        occupied: `(rows, cols)` obstacle cells.
        place: `(4,)` the grid's origin x, y in m, yaw in rad, and its resolution in m.
        poses: `(N, 3)` of the robots, map frame; nobody sees itself.
        bodies: `(N, 3)` length, width and inflation of each, m.
        rays: How many, evenly from -pi on, counter-clockwise from the robot's back.
        reach: Beyond it ranges are inf, m.
    """
    count = poses.shape[0]
    ranges = np.full((count, rays), np.inf)
    cell = place[3]
    c, s = math.cos(place[2]), math.sin(place[2])
    for robot in range(count):
        x, y, yaw = poses[robot, 0], poses[robot, 1], poses[robot, 2]
        u = (c * (x - place[0]) + s * (y - place[1])) / cell
        v = (c * (y - place[1]) - s * (x - place[0])) / cell
        for ray in range(rays):
            angle = yaw - math.pi + 2.0 * math.pi * ray / rays
            dx, dy = math.cos(angle), math.sin(angle)
            best = _cells_range(u, v, c * dx + s * dy, c * dy - s * dx, occupied, reach / cell)
            best *= cell
            for other in range(count):
                if other == robot:
                    continue
                co, so = math.cos(poses[other, 2]), math.sin(poses[other, 2])
                ox, oy = x - poses[other, 0], y - poses[other, 1]
                best = min(
                    best,
                    _body_range(
                        co * ox + so * oy,
                        co * oy - so * ox,
                        co * dx + so * dy,
                        co * dy - so * dx,
                        bodies[other],
                    ),
                )
            if best <= reach:
                ranges[robot, ray] = best
    return ranges
