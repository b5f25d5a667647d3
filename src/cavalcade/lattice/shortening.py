"""A path shortened in space and time: words from one of its states to a later one."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.geometry import Array
from cavalcade.kernels import kernel
from cavalcade.kernels.copying import copy_rows, copy_to
from cavalcade.lattice.collision import Scene, moves_free, occupied_until
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.dubins import connect, no_words, take_cheapest
from cavalcade.lattice.motion_limits import footprint_of
from cavalcade.lattice.primitives import (
    DURATION,
    LENGTH,
    TURN,
    V0,
    V1,
    VMAX,
    duration_of,
    make_move,
    poses_between,
    trapezoid,
)

_PIECE = 1.5
"""Words may begin and end within longer moves, m."""

_PASSES = 3
"""From the start to the goal, at most."""

_MOST = 1_000_000
"""States of a path, more than there are."""


def shortened_moves(scene: Scene, start: Array, moves: Array, deadline: Deadline) -> Array:
    """The path with parts of it replaced by cheaper words, greedily from its start.

    `moves` `(M, 6)` from `start` are valid; so is what is returned, however early the deadline.
    """
    rows = split(moves, scene.limits, _PIECE)
    for _ in range(_PASSES):
        changed, state = False, 0
        for end in deadline.slices(0, _MOST):
            rows, better = shorten(scene, start, rows, state, end)
            changed, state = changed or better, end
            if state >= len(rows) - 1:
                break
        if not changed:
            break
    return np.asarray(rows, dtype=np.float64)


@kernel
def split(moves, limits, piece):
    """The same motion with moves along the path cut into pieces no longer than `piece` m."""
    count = 0
    for k in range(len(moves)):
        count += max(1, int(math.ceil(abs(moves[k, LENGTH]) / piece)))
    rows = np.empty((count, moves.shape[1]))
    at = 0
    a = limits.acceleration
    for k in range(len(moves)):
        length, turn = moves[k, LENGTH], moves[k, TURN]
        parts = max(1, int(math.ceil(abs(length) / piece)))
        if parts == 1:
            copy_to(rows[at], moves[k])
            at += 1
            continue
        # Each piece ends at the speed that the whole move's trapezoid has there.
        v0, v1 = moves[k, V0], moves[k, V1]
        _, peak = trapezoid(abs(length), v0, v1, moves[k, VMAX], a)
        before = v0
        for i in range(1, parts + 1):
            gone = abs(length) * i / parts
            after = min(peak, math.sqrt(v0 * v0 + 2.0 * a * gone))
            after = min(after, math.sqrt(v1 * v1 + 2.0 * a * (abs(length) - gone)))
            if i == parts:
                after = v1
            make_move(rows[at], length / parts, turn / parts, before, after, peak, limits)
            before = after
            at += 1
    return rows


@kernel(nogil=True)
def shorten(scene, start, rows, begin, end):
    """One pass over the states `begin` to `end` of a path, each followed by a cheaper word if any.

    Returns:
        The moves `(M, 6)`, valid if those that came in were, and whether they are others.
    """
    limits, margins = scene.limits, scene.margins
    words = no_words()
    goal = poses_between(start, rows)[-1]
    taken = occupied_until(
        scene.others, footprint_of(limits), (goal[0], goal[1], goal[2]), 0.0, margins
    )
    changed = False
    i = begin
    while i < min(end, len(rows) - 1):
        poses = poses_between(start, rows)
        times = np.zeros(len(rows) + 1)
        for k in range(len(rows)):
            times[k + 1] = times[k] + rows[k, DURATION]
        here = (poses[i, 0], poses[i, 1], poses[i, 2])
        speed_i = rows[i, V0] if rows[i, LENGTH] != 0.0 else 0.0
        done = False
        # From state i to the farthest state j that a cheaper word leads to.
        j = len(rows)
        while j > i + 1 and not done:
            there = (poses[j, 0], poses[j, 1], poses[j, 2])
            speed_j = 0.0
            if j < len(rows) and rows[j, LENGTH] != 0.0:
                speed_j = rows[j, V0]
            elif j == len(rows):
                speed_j = rows[j - 1, V1] if rows[j - 1, LENGTH] != 0.0 else 0.0
            old = times[j] - times[i]
            for k in range(i, j):
                old += scene.metre_cost * abs(rows[k, LENGTH])
            number = connect(poses[i], speed_i, poses[j], speed_j, limits, scene.metre_cost, words)
            for _ in range(number):
                pick, count = take_cheapest(words, number)
                if words.costs[pick] >= old - 1e-6:
                    break
                word = words.moves[pick, :count]
                after = times[i] + duration_of(word)
                # Whoever is at the goal until then must have left it.
                if after + times[len(rows)] - times[j] <= taken:
                    continue
                if not moves_free(scene, here, word, times[i], False):
                    continue
                # What follows comes at another time: past the others it is looked at again.
                late = abs(after - times[j]) > 1e-9
                if late and not moves_free(scene, there, rows[j:], after, True):
                    continue
                fresh = np.empty((i + count + len(rows) - j, 6))
                copy_rows(fresh, rows[:i])
                copy_rows(fresh[i:], word)
                copy_rows(fresh[i + count :], rows[j:])
                rows = fresh
                changed = done = True
                break
            j -= 1
        i += 1
    return rows, changed
