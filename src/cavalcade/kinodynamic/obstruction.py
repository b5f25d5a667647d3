"""Why a robot cannot be at a place, or cannot get from one to another: what can be proven."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cavalcade.eikonal import surface_distance
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import WALK
from cavalcade.kinodynamic._reachability import grid_way
from cavalcade.kinodynamic._validity import LEAST_TRAVERSABILITY, carried, solid_free
from cavalcade.kinodynamic.parameters import GRAVITY, Body
from cavalcade.lattice.ground import Ground
from cavalcade.lattice.surface import bilinear, surface

Pose = tuple[float, float, float]
Cells = NDArray[np.int64]

_HALF_DIAGONAL = 0.7072


def obstruction(ground: Ground, body: Body, discs: Array, pose: Pose) -> str:
    """Why a robot cannot stand at a pose, empty if it can.

    Args:
        ground, body, discs: As kernels take them; see `BodySettings.discs`.
        pose: x, y, yaw in the ground's frame, m and rad.
    """
    x, y, yaw = pose
    rows, cols = ground.solid.shape
    if not (0.0 <= x < cols * ground.cell and 0.0 <= y < rows * ground.cell):
        return "is off the map"
    cos, sin = math.cos(yaw), math.sin(yaw)
    if not solid_free(ground, body, np.zeros((0, 3)), x, y, cos, sin):
        return "is in an obstacle or over the map's edge"
    if not solid_free(ground, body, discs, x, y, cos, sin):
        return "is within another robot's reach"
    if not ground.flat:
        ground_there = bilinear(ground.traversability, ground.cell, x, y)
        if ground_there < 1e-9:
            return "is in a hole"
        if ground_there < LEAST_TRAVERSABILITY:
            return "is on ground too rough or too steep to stand on"
        z = surface(ground, x, y)[0] + body.h_nom
        if not carried(ground, body, x, y, z, cos, sin, WALK):
            return "is where the legs do not reach firm ground or the belly touches it"
    return ""


def roomy_way(ground: Ground, body: Body, discs: Array, start: Pose, goal: Pose) -> Array:
    """Points `(K, 2)` x, y from start to goal between which a robot may turn anywhere; or none."""
    reach = math.hypot(body.half_length, body.half_width) + body.margin
    passable = _room(ground, discs) >= reach + 2.0 * _HALF_DIAGONAL * ground.cell
    if not ground.flat:
        passable &= ground.traversability >= LEAST_TRAVERSABILITY
    return _points(ground, grid_way(passable, *_ends(ground, start, goal)), start, goal)


def find_way(
    ground: Ground, body: Body, discs: Array, leaps: bool, start: Pose, goal: Pose
) -> tuple[str, Array]:
    """Whether there may be a way, and places to sample beside.

    Returns:
        Why there is none, empty if there may be one; and `(K, 2)` x, y of a way on the grid that
        leaves as much room as it can.
    """
    cell = ground.cell
    ends = _ends(ground, start, goal)
    room = _room(ground, discs)
    footing = np.ones(ground.solid.shape, dtype=bool)
    if not ground.flat:
        good = _walkable(ground)
        span = _longest_flight(ground, body) if leaps else 0.0
        footing = surface_distance(good, cell, border=False) <= 0.5 * span + cell if leaps else good
    narrow = body.half_width
    for needed in (math.hypot(body.half_length, body.half_width), 1.2 * narrow, narrow):
        slack = 0.0 if needed == narrow else 2.0 * _HALF_DIAGONAL * cell
        way = grid_way((room >= needed + slack - 1e-9) & footing, *ends)
        if len(way):
            return "", _points(ground, way, start, goal)
    if len(grid_way(room >= narrow - 1e-9, *ends)) == 0:
        return "no way between the obstacles is wide enough", np.zeros((0, 2))
    return "no way over the ground: holes or steep ground are in between", np.zeros((0, 2))


def _ends(ground: Ground, start: Pose, goal: Pose) -> tuple[tuple[int, int], tuple[int, int]]:
    cell = ground.cell
    return (int(start[1] / cell), int(start[0] / cell)), (int(goal[1] / cell), int(goal[0] / cell))


def _points(ground: Ground, way: Cells, start: Pose, goal: Pose) -> Array:
    """The cells' centres, with the start and the goal themselves as ends."""
    if len(way) < 2:
        return np.zeros((0, 2))
    points: Array = (way[:, ::-1].astype(np.float64) + 0.5) * ground.cell
    points[0], points[-1] = start[:2], goal[:2]
    return points


def _room(ground: Ground, discs: Array) -> Array:
    """The most room `(rows, cols)` from somewhere in a cell to what is solid, m; -1 in discs."""
    cell = ground.cell
    room: Array = ground.clearance + _HALF_DIAGONAL * cell
    rows, cols = room.shape
    for x, y, radius in discs:
        dx = (np.arange(cols) + 0.5) * cell - x
        dy = (np.arange(rows) + 0.5) * cell - y
        away = np.sqrt(dx[None, :] ** 2 + dy[:, None] ** 2)
        room[away < radius - _HALF_DIAGONAL * cell] = -1.0
    return room


def _walkable(ground: Ground) -> NDArray[np.bool_]:
    """Cells somewhere in which the ground may be traversable."""
    best = np.pad(ground.traversability, 1, mode="edge")
    rows, cols = ground.traversability.shape
    out = np.zeros((rows, cols), dtype=bool)
    for i in range(3):
        for j in range(3):
            out |= best[i : i + rows, j : j + cols] >= LEAST_TRAVERSABILITY
    return out


def _longest_flight(ground: Ground, body: Body) -> float:
    """No flight is longer than this, m.

    The legs push over at most h_max - h_min with at most the peak force; the flight then falls at
    most from the highest to the lowest ground and from h_max.
    """
    stroke = body.h_max - body.h_min
    push = math.sqrt(2.0 * stroke * GRAVITY * body.grf_max)
    drop = float(ground.height.max() - ground.height.min()) + body.h_max
    return body.v_max * (push + math.sqrt(push * push + 2.0 * GRAVITY * drop)) / GRAVITY
