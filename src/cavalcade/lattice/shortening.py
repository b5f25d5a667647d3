"""Kernel that shortens a way in space and time: words from one of its states to a later one."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.lattice.collision import free_from, move_free
from cavalcade.lattice.dubins import MOST_MOVES, MOST_WORDS, connect
from cavalcade.lattice.primitives import (
    ACCELERATION,
    DURATION,
    LENGTH,
    TURN,
    V0,
    V1,
    VMAX,
    advanced,
    make_move,
    poses_between,
    trapezoid,
)

_PIECE = 1.5
"""Words may begin and end within longer moves, m."""


@njit(cache=True)
def _rows_free(grid, others, pose, rows, mover, t, margins, steps, standing):
    """Whether moves from a pose at time `t` meet nothing."""
    x, y, yaw = pose[0], pose[1], pose[2]
    for k in range(len(rows)):
        if not move_free(grid, others, x, y, yaw, rows[k], mover, t, margins, steps, standing):
            return False
        x, y, yaw = advanced(x, y, yaw, rows[k, LENGTH], rows[k, TURN])
        t += rows[k, DURATION]
    return True


@njit(cache=True)
def split(moves, mover, piece):
    """The same motion with moves along the way cut into pieces no longer than `piece` m."""
    count = 0
    for k in range(len(moves)):
        count += max(1, int(math.ceil(abs(moves[k, LENGTH]) / piece)))
    rows = np.empty((count, moves.shape[1]))
    at = 0
    a = mover[ACCELERATION]
    for k in range(len(moves)):
        length, turn = moves[k, LENGTH], moves[k, TURN]
        parts = max(1, int(math.ceil(abs(length) / piece)))
        if parts == 1:
            rows[at] = moves[k]
            at += 1
            continue
        v0, v1 = moves[k, V0], moves[k, V1]
        _, peak = trapezoid(abs(length), v0, v1, moves[k, VMAX], a)
        before = v0
        for i in range(1, parts + 1):
            way = abs(length) * i / parts
            after = min(peak, math.sqrt(v0 * v0 + 2.0 * a * way))
            after = min(after, math.sqrt(v1 * v1 + 2.0 * a * (abs(length) - way)))
            if i == parts:
                after = v1
            make_move(rows[at], length / parts, turn / parts, before, after, peak, mover)
            before = after
            at += 1
    return rows


@njit(cache=True)
def shorten(grid, others, mover, start, moves, margins, steps, price, rounds):
    """The way with parts of it replaced by cheaper words, greedily from its start.

    Arguments as in `search`; `moves` `(M, 6)` are valid, and so is what is returned. At most
    `rounds` passes.
    """
    words = np.empty((MOST_WORDS, MOST_MOVES, 6))
    counts = np.zeros(MOST_WORDS, dtype=np.int64)
    costs = np.empty(MOST_WORDS)
    rows = split(moves, mover, _PIECE)
    goal = poses_between(start, moves)[-1]
    taken = free_from(others, goal[0], goal[1], goal[2], mover, 0.0, margins[1])
    for _ in range(rounds):
        changed = False
        i = 0
        while i < len(rows) - 1:
            poses = poses_between(start, rows)
            times = np.zeros(len(rows) + 1)
            times[1:] = np.cumsum(rows[:, DURATION])
            speed_i = rows[i, V0] if rows[i, LENGTH] != 0.0 else 0.0
            done = False
            j = len(rows)
            while j > i + 1 and not done:
                speed_j = 0.0
                if j < len(rows) and rows[j, LENGTH] != 0.0:
                    speed_j = rows[j, V0]
                elif j == len(rows):
                    speed_j = rows[j - 1, V1] if rows[j - 1, LENGTH] != 0.0 else 0.0
                old = times[j] - times[i]
                for k in range(i, j):
                    old += price * abs(rows[k, LENGTH])
                number = connect(
                    poses[i], speed_i, poses[j], speed_j, mover, price, words, counts, costs
                )
                for _ in range(number):
                    pick = -1
                    for k in range(number):
                        if counts[k] >= 0 and (pick < 0 or costs[k] < costs[pick]):
                            pick = k
                    if pick < 0 or costs[pick] >= old - 1e-6:
                        break
                    count = counts[pick]
                    counts[pick] = -1
                    word = words[pick, :count]
                    duration = word[:, DURATION].sum()
                    after = times[i] + duration
                    end = after + times[len(rows)] - times[j]
                    if end <= taken:
                        continue
                    if not _rows_free(
                        grid, others, poses[i], word, mover, times[i], margins, steps, False
                    ):
                        continue
                    if abs(after - times[j]) > 1e-9 and not _rows_free(
                        grid, others, poses[j], rows[j:], mover, after, margins, steps, True
                    ):
                        continue
                    fresh = np.empty((i + count + len(rows) - j, 6))
                    fresh[:i] = rows[:i]
                    fresh[i : i + count] = word
                    fresh[i + count :] = rows[j:]
                    rows = fresh
                    changed = done = True
                    break
                j -= 1
            i += 1
        if not changed:
            break
    return rows
