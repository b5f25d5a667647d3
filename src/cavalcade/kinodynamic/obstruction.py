"""Why a robot cannot be at a place, or cannot get from one to another: what can be proven."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cavalcade.eikonal import surface_distance
from cavalcade.geometry import GRAVITY, Array
from cavalcade.geometry.trajectory import WALK
from cavalcade.kernels import kernel, subroutine
from cavalcade.kinodynamic._validity import HALF_DIAGONAL, carried, solid_free
from cavalcade.kinodynamic.parameters import LEAST_TRAVERSABILITY, StateSpace
from cavalcade.lattice.ground import Ground
from cavalcade.lattice.surface import bilinear, surface

Pose = tuple[float, float, float]
Mask = NDArray[np.bool_]

_ROW = (0, 0, 1, -1, 1, 1, -1, -1)
_COL = (1, -1, 0, 0, 1, -1, 1, -1)


def obstruction(space: StateSpace, pose: Pose) -> str:
    """Why a robot cannot stand at a pose, empty if it can.

    Args:
        space: By `make_space`.
        pose: x, y, yaw in the ground's frame, m and rad.
    """
    ground = space.ground
    x, y, yaw = pose
    rows, cols = ground.solid.shape
    if not (0.0 <= x < cols * ground.cell and 0.0 <= y < rows * ground.cell):
        return "is off the map"
    cos, sin = math.cos(yaw), math.sin(yaw)
    if not solid_free(space, x, y, cos, sin):
        if len(space.discs) and solid_free(space._replace(discs=np.zeros((0, 3))), x, y, cos, sin):
            return "is within another robot's reach"
        return "is in an obstacle or over the map's edge"
    if not ground.flat:
        ground_there = bilinear(ground.traversability, ground.cell, x, y)
        if ground_there < 1e-9:
            return "is in a hole"
        if ground_there < LEAST_TRAVERSABILITY:
            return "is on ground too rough or too steep to stand on"
        z = surface(ground, x, y)[0] + space.body.h_nom
        if not carried(space, x, y, z, cos, sin, WALK):
            return "is where the legs do not reach firm ground or the belly touches it"
    return ""


def roomy_path(space: StateSpace, start: Pose, goal: Pose) -> Array | None:
    """Points `(K, 2)` x, y from start to goal between which a robot may turn anywhere, if any."""
    ground, body, discs = space
    reach = math.hypot(body.half_length, body.half_width) + body.margin
    passable = _room(ground, discs) >= reach + 2.0 * HALF_DIAGONAL * ground.cell
    if not ground.flat:
        passable &= ground.traversability >= LEAST_TRAVERSABILITY
    return _path(ground, passable, start, goal)


def find_path(space: StateSpace, start: Pose, goal: Pose) -> tuple[str, Array]:
    """Whether there may be a path, and places to sample beside.

    Returns:
        Why there is none, empty if there may be one; and `(K, 2)` x, y of a path on the grid that
        leaves as much room as it can.
    """
    ground, body, discs = space
    cell = ground.cell
    room = _room(ground, discs)
    footing = np.ones(ground.solid.shape, dtype=bool)
    if not ground.flat:
        good = _walkable(ground)
        footing = good
        if body.leaps:
            span = _longest_flight(space)
            footing = surface_distance(good, cell, border=False) <= 0.5 * span + cell
    narrow = body.half_width
    for needed in (math.hypot(body.half_length, body.half_width), 1.2 * narrow, narrow):
        slack = 0.0 if needed == narrow else 2.0 * HALF_DIAGONAL * cell
        path = _path(ground, (room >= needed + slack - 1e-9) & footing, start, goal)
        if path is not None:
            return "", path
    if _path(ground, room >= narrow - 1e-9, start, goal) is None:
        return "no way between the obstacles is wide enough", np.zeros((0, 2))
    return "no way over the ground: holes or steep ground are in between", np.zeros((0, 2))


def _path(ground: Ground, passable: Mask, start: Pose, goal: Pose) -> Array | None:
    """Centres of a path's cells, with start and goal themselves as ends; empty within a cell."""
    ends = ((int(pose[1] / ground.cell), int(pose[0] / ground.cell)) for pose in (start, goal))
    path = grid_path(passable, *ends)
    if len(path) < 2:
        return np.zeros((0, 2)) if len(path) else None
    points: Array = (path[:, ::-1].astype(np.float64) + 0.5) * ground.cell
    points[0], points[-1] = start[:2], goal[:2]
    return points


def _room(ground: Ground, discs: Array) -> Array:
    """The most room `(rows, cols)` from somewhere in a cell to what is solid, m; -1 in discs."""
    cell = ground.cell
    room: Array = ground.clearance + HALF_DIAGONAL * cell
    rows, cols = room.shape
    for x, y, radius in discs:
        dx = (np.arange(cols) + 0.5) * cell - x
        dy = (np.arange(rows) + 0.5) * cell - y
        away = np.sqrt(dx[None, :] ** 2 + dy[:, None] ** 2)
        room[away < radius - HALF_DIAGONAL * cell] = -1.0
    return room


def _walkable(ground: Ground) -> Mask:
    """Cells somewhere in which the ground may be traversable."""
    best = np.pad(ground.traversability, 1, mode="edge")
    rows, cols = ground.traversability.shape
    out = np.zeros((rows, cols), dtype=bool)
    for i in range(3):
        for j in range(3):
            out |= best[i : i + rows, j : j + cols] >= LEAST_TRAVERSABILITY
    return out


def _longest_flight(space: StateSpace) -> float:
    """No flight is longer than this, m.

    The legs push over at most h_max - h_min with at most the peak force; the flight then falls at
    most from the highest to the lowest ground and from h_max.
    """
    body, height = space.body, space.ground.height
    stroke = body.h_max - body.h_min
    push = math.sqrt(2.0 * stroke * GRAVITY * body.grf_max)
    drop = float(height.max() - height.min()) + body.h_max
    return body.v_max * (push + math.sqrt(push * push + 2.0 * GRAVITY * drop)) / GRAVITY


@kernel
def grid_path(passable, start, goal):
    """The path `(K, 2)` with the fewest steps to one of eight neighbouring cells; empty if none.

    Breadth-first from both ends, so that a small enclosed area is soon known to be one. Cells are
    (row, col); those of the start and the goal count as `passable` `(rows, cols)`.
    """
    rows, cols = passable.shape
    source = np.full(rows * cols, -1, np.int32)
    side = np.zeros(rows * cols, np.int8)
    queues = np.empty((2, rows * cols), np.int32)
    heads, tails = np.zeros(2, np.int64), np.ones(2, np.int64)
    ends = (start[0] * cols + start[1], goal[0] * cols + goal[1])
    for k in range(2):
        queues[k, 0] = ends[k]
        side[ends[k]] += k + 1
        source[ends[k]] = ends[k]
    if ends[0] == ends[1]:
        return np.array([[start[0], start[1]]], np.int64)
    while True:
        for k in range(2):
            if heads[k] == tails[k]:
                return np.empty((0, 2), np.int64)
            # One ring around this end; a cell of the other side joins both.
            for _ in range(tails[k] - heads[k]):
                at = queues[k, heads[k]]
                heads[k] += 1
                row, col = at // cols, at % cols
                for m in range(8):
                    i, j = row + _ROW[m], col + _COL[m]
                    if i < 0 or j < 0 or i >= rows or j >= cols:
                        continue
                    to = i * cols + j
                    if side[to] == k + 1 or (side[to] == 0 and not passable[i, j]):
                        continue
                    if side[to] != 0:
                        return (
                            _trace(source, cols, at, to) if k == 0 else _trace(source, cols, to, at)
                        )
                    side[to] = k + 1
                    source[to] = at
                    queues[k, tails[k]] = to
                    tails[k] += 1


@subroutine
def _trace(source, cols, a, b):
    """Cells from the root of `a` over `a` and `b` to the root of `b`."""
    before, after = _steps(source, a), _steps(source, b)
    path = np.empty((before + after, 2), np.int64)
    for k in range(before - 1, -1, -1):
        path[k, 0], path[k, 1] = a // cols, a % cols
        a = source[a]
    for k in range(before, before + after):
        path[k, 0], path[k, 1] = b // cols, b % cols
        b = source[b]
    return path


@subroutine
def _steps(source, at):
    """Number of cells from one to its root, both included."""
    count = 1
    while source[at] != at:
        at = source[at]
        count += 1
    return count
