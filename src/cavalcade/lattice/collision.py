"""Kernels of contact: footprints against solid ground and against other bodies over time."""

from __future__ import annotations

import math
from typing import NamedTuple

from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.boxes import footprint_at, footprints_meet
from cavalcade.kernels import kernel, subroutine
from cavalcade.lattice.ground import Ground, read_only
from cavalcade.lattice.motion_limits import MotionLimits, footprint_of
from cavalcade.lattice.outlines import Outlines, meets_outline, partly_solid, within_outline
from cavalcade.lattice.primitives import (
    DURATION,
    LENGTH,
    TURN,
    V0,
    V1,
    VMAX,
    advanced,
    trapezoid,
    within,
)

_COARSE, _FINER = 64, 8
"""Poses along moves are looked at in passes, the coarsest first: every 64th, every 8th, then all.
What is met is mostly met soon, and whether it is does not depend on the order."""


class Grid(NamedTuple):
    """What of a `Ground` footprints are tested against."""

    cell: float
    solid: NDArray
    clearance: Array
    outlines: Outlines


class Others(NamedTuple):
    """What is to be avoided while it is there.

    Attributes:
        tracks: `(J, K, 3)` poses every `step` s from time 0, standing at the last for good.
        step: Time between two poses, s.
        shapes: `(J, 3)` half length, half width (m), whether round.
        spans: `(C, 3)` which track, from when to when, s.
    """

    tracks: Array
    step: float
    shapes: Array
    spans: Array


class Margins(NamedTuple):
    """How far to keep off, and how closely to look.

    Attributes:
        ground, others: Distances that are kept from what is solid and from other bodies, m.
        length_step, angle_step, time_step: Largest steps between two tests: m, rad, and s where
            others are about.
        finer: How often to halve the steps of a search.
    """

    ground: float
    others: float
    length_step: float
    angle_step: float
    time_step: float
    finer: int


class Scene(NamedTuple):
    """One robot among others: what stays the same for the whole of a search.

    Attributes:
        grid: The ground.
        others: To be avoided.
        limits: Of the robot.
        margins: From the ground and the others.
        metre_cost: What a metre costs; a second costs 1.
    """

    grid: Grid
    others: Others
    limits: MotionLimits
    margins: Margins
    metre_cost: float


def grid_of(ground: Ground) -> Grid:
    """The ground as kernels of contact take it; read-only, for they compile for what they see."""
    ground = read_only(ground)
    return Grid(ground.cell, ground.solid, ground.clearance, ground.outlines)


@kernel
def pose_free(grid, footprint, x, y, yaw, margin):
    """Whether a footprint keeps `margin` from everything solid and from the grid's border.

    Cells are squares; what only touches one is free of it. Where outlines are known, they count.
    """
    cell, solid, clearance, outlines = grid
    rows, cols = solid.shape
    col, row = int(math.floor(x / cell)), int(math.floor(y / cell))
    if row < 0 or col < 0 or row >= rows or col >= cols:
        return False
    if solid[row, col] and not partly_solid(outlines, row, col):
        return False
    # The clearance of the cell decides for bodies far from everything, or much too near.
    hl, hw = footprint.half_length + margin, footprint.half_width + margin
    reach = hl if footprint.round else math.sqrt(hl * hl + hw * hw)
    known = clearance[row, col]
    if known - 0.7072 * cell > reach:
        return True
    if known + 0.7072 * cell < hw:
        return False
    if solid[row, col] and within_outline(outlines, x, y):
        return False
    # The box around the footprint: within the border, and which cells to look at.
    slack = 1e-9
    if footprint.round:
        near = hl - slack
        if x < near or y < near or x > cols * cell - near or y > rows * cell - near:
            return False
        low_x, high_x, low_y, high_y = x - hl, x + hl, y - hl, y + hl
        c, s = 1.0, 0.0
    else:
        c, s = math.cos(yaw), math.sin(yaw)
        span_x, span_y = abs(c) * hl + abs(s) * hw, abs(s) * hl + abs(c) * hw
        low_x, high_x, low_y, high_y = x - span_x, x + span_x, y - span_y, y + span_y
        if low_x < -slack or low_y < -slack:
            return False
        if high_x > cols * cell + slack or high_y > rows * cell + slack:
            return False
    first_col, last_col = max(int(low_x / cell), 0), min(int(high_x / cell), cols - 1)
    first_row, last_row = max(int(low_y / cell), 0), min(int(high_y / cell), rows - 1)
    half = 0.5 * cell * (abs(c) + abs(s))
    for i in range(first_row, last_row + 1):
        for j in range(first_col, last_col + 1):
            if not solid[i, j]:
                continue
            if footprint.round:
                dx = max(j * cell - x, x - (j + 1) * cell, 0.0)
                dy = max(i * cell - y, y - (i + 1) * cell, 0.0)
                apart = dx * dx + dy * dy >= hl * hl - 1e-12
                if not apart and not partly_solid(outlines, i, j):
                    return False
                if not apart and meets_outline(outlines, (i, j), (x, y, c, s), (hl, hw), True):
                    return False
                continue
            # Separating axes: those of the footprint, then those of the square.
            dx, dy = (j + 0.5) * cell - x, (i + 0.5) * cell - y
            apart = abs(c * dx + s * dy) >= hl + half - 1e-9
            apart = apart or abs(c * dy - s * dx) >= hw + half - 1e-9
            apart = apart or j * cell >= high_x - 1e-9 or (j + 1) * cell <= low_x + 1e-9
            apart = apart or i * cell >= high_y - 1e-9 or (i + 1) * cell <= low_y + 1e-9
            if not apart and not partly_solid(outlines, i, j):
                return False
            if not apart and meets_outline(outlines, (i, j), (x, y, c, s), (hl, hw), False):
                return False
    return True


@subroutine
def pose_at(tracks, j, index):
    """The pose (x, y, yaw) of track `j` of `(J, K, 3)` at a sample number, linear in between."""
    last = tracks.shape[1] - 1
    if index >= last:
        return tracks[j, last, 0], tracks[j, last, 1], tracks[j, last, 2]
    i = int(index)
    f = index - i
    return (
        tracks[j, i, 0] + f * (tracks[j, i + 1, 0] - tracks[j, i, 0]),
        tracks[j, i, 1] + f * (tracks[j, i + 1, 1] - tracks[j, i, 1]),
        tracks[j, i, 2] + f * (tracks[j, i + 1, 2] - tracks[j, i, 2]),
    )


@kernel
def place_free(others, footprint, pose, t, margin):
    """Whether a footprint at a pose (x, y, yaw) keeps `margin` from the others at time `t`."""
    tracks, dt, shapes, spans = others
    for k in range(spans.shape[0]):
        if t < spans[k, 1] or t > spans[k, 2]:
            continue
        j = int(spans[k, 0])
        there = pose_at(tracks, j, t / dt)
        if footprints_meet(footprint, pose, footprint_at(shapes, j), there, margin):
            return False
    return True


@subroutine
def still_from(others):
    """When the last of the others has left or stands for good, s."""
    still = 0.0
    for k in range(others.spans.shape[0]):
        begin, end = others.spans[k, 1], others.spans[k, 2]
        if end == math.inf:
            end = max(begin, (others.tracks.shape[1] - 1) * others.step)
        still = max(still, end)
    return still


@subroutine
def occupied_until(others, footprint, pose, t, margins):
    """The last look after `t` at which others are where a footprint is to stand, s.

    Looks are as far apart as those along moves, `margins.time_step`: so no more is hidden between
    two of them than there. -1 if they never are; infinite where somebody stands there for good.
    """
    if others.spans.shape[0] == 0:
        return -1.0
    still = still_from(others)
    if not place_free(others, footprint, pose, max(still, t) + 1e6, margins.others):
        return math.inf
    count = int(math.ceil((still - t) / margins.time_step))
    for k in range(count):
        moment = still - k * margins.time_step
        if not place_free(others, footprint, pose, moment, margins.others):
            return moment
    return -1.0


@subroutine
def _looks_free(scene, pose, move, t, standing, stride):
    """Whether a move meets nothing at every `stride`-th of the poses that are to be looked at.

    Those that a pass with `_FINER` times the stride has looked at are left out; see `move_free`.
    """
    grid, others, limits, margins, _ = scene
    x, y, yaw = pose
    duration = move[DURATION]
    length, turn = move[LENGTH], move[TURN]
    # How many poses to look at: by the steps in length, angle and time.
    count = 1
    if length != 0.0:
        _, peak = trapezoid(abs(length), move[V0], move[V1], move[VMAX], limits.acceleration)
        count = max(count, int(math.ceil(peak * duration / margins.length_step)))
        bend = abs(turn) / abs(length) * peak * duration
        count = max(count, int(math.ceil(bend / margins.angle_step)))
    elif turn != 0.0:
        count = max(count, int(math.ceil(2.0 * abs(turn) / margins.angle_step)))
    if others.spans.shape[0] > 0:
        count = max(count, int(math.ceil(duration / margins.time_step)))
    footprint = footprint_of(limits)
    look = not standing and not (length == 0.0 and (turn == 0.0 or limits.round))
    # The end belongs to the first pass.
    for k in range(count, 0, -stride):
        if stride < _COARSE and (count - k) % (_FINER * stride) == 0:
            continue
        if k == count:
            px, py, pyaw = advanced(x, y, yaw, length, turn)
        else:
            px, py, pyaw, _, _ = within(x, y, yaw, move, limits, duration * k / count)
        if look and not pose_free(grid, footprint, px, py, pyaw, margins.ground):
            return False
        when = t + duration * k / count
        if not place_free(others, footprint, (px, py, pyaw), when, margins.others):
            return False
    return True


@kernel
def move_free(scene, pose, move, t, standing):
    """Whether a move `(6,)` from a pose (x, y, yaw) at time `t` meets nothing.

    The pose itself is not looked at; if `standing`, neither is the ground.
    """
    stride = _COARSE
    while stride >= 1:
        if not _looks_free(scene, pose, move, t, standing, stride):
            return False
        stride //= _FINER
    return True


@subroutine
def moves_free(scene, pose, moves, t, standing):
    """The same for moves `(M, 6)`, one after the other."""
    stride = _COARSE
    while stride >= 1:
        x, y, yaw = pose
        when = t
        for k in range(len(moves)):
            if not _looks_free(scene, (x, y, yaw), moves[k], when, standing, stride):
                return False
            x, y, yaw = advanced(x, y, yaw, moves[k, LENGTH], moves[k, TURN])
            when += moves[k, DURATION]
        stride //= _FINER
    return True
