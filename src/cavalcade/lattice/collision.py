"""Kernels of contact: footprints against solid ground and against other bodies over time.

A grid is the tuple (cell, solid, clearance) of a `Ground`. Others are the tuple (tracks, dt,
shapes, spans): poses `(J, K, 3)` every dt seconds from time 0, standing at the last for good;
half length, half width and whether round `(J, 3)`; and `(C, 3)` which track is to be avoided, from
when to when, in s.
"""

from __future__ import annotations

import math

from numba import njit

from cavalcade.lattice.primitives import (
    ACCELERATION,
    DURATION,
    HALF_LENGTH,
    HALF_WIDTH,
    LENGTH,
    ROUND,
    TURN,
    V0,
    V1,
    VMAX,
    advanced,
    trapezoid,
    within,
)


@njit(cache=True)
def pose_free(grid, x, y, yaw, half_length, half_width, is_round, margin):
    """Whether a footprint keeps `margin` from everything solid and from the grid's border.

    Cells are squares; what only touches one is free of it.
    """
    cell, solid, clearance = grid
    rows, cols = solid.shape
    col, row = int(math.floor(x / cell)), int(math.floor(y / cell))
    if row < 0 or col < 0 or row >= rows or col >= cols or solid[row, col]:
        return False
    hl, hw = half_length + margin, half_width + margin
    reach = hl if is_round > 0.0 else math.sqrt(hl * hl + hw * hw)
    known = clearance[row, col]
    if known - 0.7072 * cell > reach:
        return True
    if known + 0.7072 * cell < hw:
        return False
    slack = 1e-9
    if is_round > 0.0:
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
            if is_round > 0.0:
                dx = max(j * cell - x, x - (j + 1) * cell, 0.0)
                dy = max(i * cell - y, y - (i + 1) * cell, 0.0)
                if dx * dx + dy * dy < hl * hl - 1e-12:
                    return False
                continue
            dx, dy = (j + 0.5) * cell - x, (i + 0.5) * cell - y
            apart = abs(c * dx + s * dy) >= hl + half - 1e-9
            apart = apart or abs(c * dy - s * dx) >= hw + half - 1e-9
            # The square's own axes.
            apart = apart or j * cell >= high_x - 1e-9 or (j + 1) * cell <= low_x + 1e-9
            apart = apart or i * cell >= high_y - 1e-9 or (i + 1) * cell <= low_y + 1e-9
            if not apart:
                return False
    return True


@njit(cache=True)
def bodies_meet(x0, y0, yaw0, hl0, hw0, round0, x1, y1, yaw1, hl1, hw1, round1, margin):
    """Whether two footprints are nearer than `margin` (boxes at corners: a little more)."""
    dx, dy = x1 - x0, y1 - y0
    distance = dx * dx + dy * dy
    r0 = hl0 if round0 > 0.0 else math.sqrt(hl0 * hl0 + hw0 * hw0)
    r1 = hl1 if round1 > 0.0 else math.sqrt(hl1 * hl1 + hw1 * hw1)
    far = r0 + r1 + margin
    if distance >= far * far:
        return False
    near = (hl0 if round0 > 0.0 else hw0) + (hl1 if round1 > 0.0 else hw1) + margin
    if distance < near * near:
        return True
    if round0 > 0.0 and round1 > 0.0:
        return False
    if round0 > 0.0:
        return _disc_meets_box(-dx, -dy, yaw1, hl1, hw1, hl0 + margin)
    if round1 > 0.0:
        return _disc_meets_box(dx, dy, yaw0, hl0, hw0, hl1 + margin)
    c0, s0, c1, s1 = math.cos(yaw0), math.sin(yaw0), math.cos(yaw1), math.sin(yaw1)
    c, s = abs(c0 * c1 + s0 * s1), abs(c0 * s1 - s0 * c1)
    if abs(c0 * dx + s0 * dy) >= hl0 + c * hl1 + s * hw1 + margin:
        return False
    if abs(c0 * dy - s0 * dx) >= hw0 + s * hl1 + c * hw1 + margin:
        return False
    if abs(c1 * dx + s1 * dy) >= hl1 + c * hl0 + s * hw0 + margin:
        return False
    return abs(c1 * dy - s1 * dx) < hw1 + s * hl0 + c * hw0 + margin


@njit(cache=True)
def _disc_meets_box(dx, dy, yaw, half_length, half_width, radius):
    """Whether a disc at (dx, dy) from a box's centre is nearer to it than its radius."""
    c, s = math.cos(yaw), math.sin(yaw)
    u = max(abs(c * dx + s * dy) - half_length, 0.0)
    v = max(abs(c * dy - s * dx) - half_width, 0.0)
    return u * u + v * v < radius * radius


@njit(cache=True)
def place_free(others, x, y, yaw, mover, t, margin):
    """Whether a footprint keeps `margin` from the others at time `t`."""
    tracks, dt, shapes, spans = others
    last = tracks.shape[1] - 1
    for k in range(spans.shape[0]):
        if t < spans[k, 1] or t > spans[k, 2]:
            continue
        j = int(spans[k, 0])
        index = t / dt
        if index >= last:
            ox, oy, oyaw = tracks[j, last, 0], tracks[j, last, 1], tracks[j, last, 2]
        else:
            i = int(index)
            f = index - i
            ox = tracks[j, i, 0] + f * (tracks[j, i + 1, 0] - tracks[j, i, 0])
            oy = tracks[j, i, 1] + f * (tracks[j, i + 1, 1] - tracks[j, i, 1])
            oyaw = tracks[j, i, 2] + f * (tracks[j, i + 1, 2] - tracks[j, i, 2])
        if bodies_meet(
            x,
            y,
            yaw,
            mover[HALF_LENGTH],
            mover[HALF_WIDTH],
            mover[ROUND],
            ox,
            oy,
            oyaw,
            shapes[j, 0],
            shapes[j, 1],
            shapes[j, 2],
            margin,
        ):
            return False
    return True


@njit(cache=True)
def free_from(others, x, y, yaw, mover, t, margin):
    """The last time at or after `t` at which the place is taken, s; -1 if never.

    Infinite where somebody stands there for good.
    """
    tracks, dt, _, spans = others
    if spans.shape[0] == 0:
        return -1.0
    end = (tracks.shape[1] - 1) * dt
    if not place_free(others, x, y, yaw, mover, max(end, t) + 1e6, margin):
        return math.inf
    found = -1.0
    moment = max(end, t)
    while moment > t:
        if not place_free(others, x, y, yaw, mover, moment, margin):
            found = moment
            break
        moment -= dt
    return found


@njit(cache=True)
def move_free(grid, others, x, y, yaw, move, mover, t, margins, steps, standing):
    """Whether a move from a pose at time `t` meets nothing.

    Args:
        margins: From solid ground and from others, m.
        steps: Largest steps between tests: m, rad, and s where others are about.
        standing: Whether the ground need not be looked at.
    """
    duration = move[DURATION]
    length, turn = move[LENGTH], move[TURN]
    count = 1
    if length != 0.0:
        _, peak = trapezoid(abs(length), move[V0], move[V1], move[VMAX], mover[ACCELERATION])
        count = max(count, int(math.ceil(peak * duration / steps[0])))
        count = max(count, int(math.ceil(abs(turn) / abs(length) * peak * duration / steps[1])))
    elif turn != 0.0:
        count = max(count, int(math.ceil(2.0 * abs(turn) / steps[1])))
    if others[3].shape[0] > 0:
        count = max(count, int(math.ceil(duration / steps[2])))
    look = not standing and not (length == 0.0 and (turn == 0.0 or mover[ROUND] > 0.0))
    for k in range(1, count + 1):
        if k == count:
            px, py, pyaw = advanced(x, y, yaw, length, turn)
        else:
            px, py, pyaw, _, _ = within(x, y, yaw, move, mover, duration * k / count)
        if look and not pose_free(
            grid, px, py, pyaw, mover[HALF_LENGTH], mover[HALF_WIDTH], mover[ROUND], margins[0]
        ):
            return False
        if not place_free(others, px, py, pyaw, mover, t + duration * k / count, margins[1]):
            return False
    return True
