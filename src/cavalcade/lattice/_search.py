"""Kernel of the search in space and time: A* over moves, with a shot at the goal from each node.

States are continuous; of those that fall into one bin of place, heading, walking or standing, and
time, only the first is expanded (as in hybrid A*, Dolgov et al., IJRR 29(5), 2010). Time is part
of the bin for as long as somebody else moves.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.lattice._queue import grown, grown_line, pop, push, slot_of
from cavalcade.lattice.collision import free_from, move_free
from cavalcade.lattice.dubins import MOST_MOVES, MOST_WORDS, backward_factor, connect
from cavalcade.lattice.primitives import (
    ACCELERATION,
    DURATION,
    LENGTH,
    RATE,
    SPEED,
    TURN,
    TURN_ACCELERATION,
    advanced,
    trapezoid,
)

FOUND, NONE, SPENT = 0, 1, 2
FROM_MOVING, TO_MOVING = 6, 7
"""Columns of the table of primitives, after those of a move."""

_HEADINGS = 32
_PATIENCE = 300
"""Expansions after a first way was found, to find a better one."""

_MORE_PATIENCE = 3000
_GOOD = 1.08
"""The same where it costs more than this times the least that is possible."""

_WORDS_TRIED = 3
_WAIT, _LONGEST_WAIT = 0.5, 15.0
"""The cheapest words are tried after waits at the start in such steps, s."""

_LOOPS = 4.0
"""Words that cost more than this beyond the straight way are no shots at the goal, s."""


@njit(cache=True)
def _bin(x, y, yaw, moving, t, bins, still):
    """One number for place, heading, moving and time."""
    i, j = np.int64(x / bins[0]), np.int64(y / bins[0])
    heading = np.int64(math.floor(yaw / (2.0 * math.pi) * _HEADINGS + 0.5)) % _HEADINGS
    moment = np.int64(min(t, still) / bins[1])
    return (((moment * 8192 + i) * 8192 + j) * _HEADINGS + heading) * 2 + moving


@njit(cache=True)
def _guided(guide, cell, x, y):
    """Length of the shortest way to the goal from the guide's cell, m; straight without a guide."""
    row = min(max(int(y / cell), 0), guide.shape[0] - 1)
    col = min(max(int(x / cell), 0), guide.shape[1] - 1)
    return guide[row, col]


@njit(cache=True)
def _word_free(grid, others, pose, word, mover, t, margins, steps):
    """Whether the moves of a word from a pose at time `t` meet nothing."""
    x, y, yaw = pose[0], pose[1], pose[2]
    for k in range(len(word)):
        if not move_free(grid, others, x, y, yaw, word[k], mover, t, margins, steps, False):
            return False
        x, y, yaw = advanced(x, y, yaw, word[k, LENGTH], word[k, TURN])
        t += word[k, DURATION]
    return True


@njit(cache=True)
def _later_start(
    grid,
    others,
    start,
    goal,
    mover,
    taken,
    margins,
    steps,
    price,
    words,
    counts,
    costs,
    out,
):
    """The shortest wait at the start after which one of the cheapest words gets to the goal.

    Returns:
        Moves written to `out`, the wait first, 0 if there is none; and their cost.
    """
    number = connect(start, 0.0, goal, 0.0, mover, price, words, counts, costs)
    chosen = np.full(_WORDS_TRIED, -1)
    for rank in range(_WORDS_TRIED):
        for k in range(number):
            if counts[k] < 0:
                continue
            if chosen[rank] < 0 or costs[k] < costs[chosen[rank]]:
                chosen[rank] = k
        if chosen[rank] >= 0:
            counts[chosen[rank]] = -1 - counts[chosen[rank]]
    stand = np.zeros(6)
    stand[DURATION] = _WAIT
    wait = 0.0
    while wait < _LONGEST_WAIT:
        if not move_free(
            grid, others, start[0], start[1], start[2], stand, mover, wait, margins, steps, True
        ):
            break
        wait += _WAIT
        for rank in range(_WORDS_TRIED):
            pick = chosen[rank]
            if pick < 0:
                break
            count = -1 - counts[pick]
            word = words[pick, :count]
            if wait + word[:, DURATION].sum() <= taken:
                continue
            if _word_free(grid, others, start, word, mover, wait, margins, steps):
                out[0] = stand
                out[0, DURATION] = wait
                out[1 : count + 1] = word
                return count + 1, wait + costs[pick]
    return 0, 0.0


@njit(cache=True)
def search(
    grid,
    others,
    mover,
    start,
    goal,
    prims,
    guide,
    guide_cell,
    margins,
    steps,
    bins,
    price,
    greed,
    most,
):
    """The cheapest way from rest at `start` to rest at `goal` past everything, for good.

    Args:
        grid, others: See `_moves_contact`.
        mover: See `_moves`.
        start, goal: x, y, yaw.
        prims: `(P, 8)` moves, and whether they begin and end walking.
        guide: `(rows, cols)` lengths of the shortest ways to the goal, m; `(0, 0)` for none.
        guide_cell: m.
        margins, steps: As in `move_free`.
        bins: Sizes of the bins of place and time, m and s.
        price: Of a metre, in s.
        greed: Factor of what is left to the goal, at least 1: larger ones find ways sooner.
        most: Expansions.

    Returns:
        FOUND, NONE (nothing left to try) or SPENT; moves `(M, 6)`; expansions.
    """
    words = np.empty((MOST_WORDS, MOST_MOVES, 6))
    counts = np.zeros(MOST_WORDS, dtype=np.int64)
    costs = np.empty(MOST_WORDS)
    none = np.empty((0, 6))
    taken = free_from(others, goal[0], goal[1], goal[2], mover, 0.0, margins[1])
    if taken == math.inf:
        return NONE, none, 0
    still = 0.0
    if others[3].shape[0] > 0:
        for k in range(others[3].shape[0]):
            begin, end = others[3][k, 1], others[3][k, 2]
            if end == math.inf:
                end = max(begin, (others[0].shape[1] - 1) * others[1])
            still = max(still, end)
    speed = mover[SPEED]
    turn_round, _ = trapezoid(math.pi, 0.0, 0.0, mover[RATE], mover[TURN_ACCELERATION])
    turn_round *= 2.0
    dislike = backward_factor(mover)
    gap = math.sqrt((goal[0] - start[0]) ** 2 + (goal[1] - start[1]) ** 2)
    if guide.shape[0] > 0:
        gap = max(gap, _guided(guide, guide_cell, start[0], start[1]) - 1.5 * guide_cell)
    lowest, _ = trapezoid(gap, 0.0, 0.0, speed, mover[ACCELERATION])
    lowest += price * gap

    capacity = min(most * (len(prims) + 1) + 2, 4_000_000)
    size = 1 << 12
    while size < 2 * min(most + 1, capacity):
        size <<= 1
    # The first shot needs no tables: most problems end here.
    state = np.empty((1024, 6))  # x, y, yaw, moving, t, length
    link = np.empty((1024, 2), dtype=np.int64)
    heap = np.empty(1024, dtype=np.int64)
    keys = np.empty(1024)
    table = np.empty(0, dtype=np.int64)
    state[0, 0], state[0, 1], state[0, 2] = start[0], start[1], start[2]
    state[0, 3], state[0, 4], state[0, 5] = 0.0, 0.0, 0.0
    link[0, 0], link[0, 1] = -1, -1
    used = 1
    waiting = push(heap, keys, 0, 0, 0.0)
    best_cost, best_node, best_count = math.inf, -1, 0
    best_word = np.empty((MOST_MOVES + 1, 6))
    expansions = 0
    found_at = 0
    here = np.empty(3)
    while waiting > 0:
        least = keys[0]
        node, waiting = pop(heap, keys, waiting)
        if least >= greed * best_cost - 1e-9:
            break
        if best_node >= 0:
            patience = _PATIENCE if best_cost < _GOOD * lowest else _MORE_PATIENCE
            if expansions - found_at > patience:
                break
        if expansions >= most or used + len(prims) >= capacity:
            if best_node >= 0:
                break
            return SPENT, none, expansions
        x, y, yaw, moving = state[node, 0], state[node, 1], state[node, 2], state[node, 3]
        t, length = state[node, 4], state[node, 5]
        if node > 0:
            if table.shape[0] == 0:
                table = np.full(size, -1, dtype=np.int64)
            key = _bin(x, y, yaw, np.int64(moving), t, bins, still)
            slot = slot_of(table, key)
            if table[slot] == key:
                continue
            parent, used_move = link[node, 0], prims[link[node, 1]]
            if not move_free(
                grid,
                others,
                state[parent, 0],
                state[parent, 1],
                state[parent, 2],
                used_move,
                mover,
                state[parent, 4],
                margins,
                steps,
                False,
            ):
                continue
            table[slot] = key
        expansions += 1
        # A shot at the goal, unless the guide says that something stands between.
        gap = math.sqrt((goal[0] - x) ** 2 + (goal[1] - y) ** 2)
        sight = True
        if guide.shape[0] > 0:
            sight = _guided(guide, guide_cell, x, y) < 1.1 * gap + 0.3
        near = gap < 3.0 and sight
        if length == 0.0 or near or (sight and expansions % 4 == 0) or expansions % 16 == 0:
            here[0], here[1], here[2] = x, y, yaw
            number = connect(
                here, speed if moving > 0.0 else 0.0, goal, 0.0, mover, price, words, counts, costs
            )
            first_try = True
            dear = math.inf if node == 0 else gap * (price + 1.0 / speed) + turn_round + _LOOPS
            for _ in range(number):
                pick = -1
                for k in range(number):
                    if counts[k] >= 0 and (pick < 0 or costs[k] < costs[pick]):
                        pick = k
                if pick < 0:
                    break
                count = counts[pick]
                counts[pick] = -1
                cost = t + price * length + costs[pick]
                if cost >= best_cost - 1e-9 or costs[pick] > dear:
                    break
                duration = 0.0
                for k in range(count):
                    duration += words[pick, k, DURATION]
                if t + duration <= taken:
                    first_try = False
                    continue
                if _word_free(grid, others, here, words[pick, :count], mover, t, margins, steps):
                    best_cost, best_node, best_count = cost, node, count
                    best_word[:count] = words[pick, :count]
                    if found_at == 0:
                        found_at = expansions
                    if node == 0 and first_try:
                        # The cheapest word of all is free: there is nothing to look for.
                        return FOUND, words[pick, :count].copy(), expansions
                    break
                first_try = False
            if node == 0 and best_node < 0 and others[3].shape[0] > 0:
                # Setting off later is a way, too, and bounds what the search may cost.
                best_count, cost = _later_start(
                    grid,
                    others,
                    here,
                    goal,
                    mover,
                    taken,
                    margins,
                    steps,
                    price,
                    words,
                    counts,
                    costs,
                    best_word,
                )
                if best_count > 0:
                    best_cost, best_node, found_at = cost, 0, expansions
        # Its successors, judged when their turn comes.
        if used + len(prims) >= state.shape[0]:
            state = grown(state)
            link = grown(link)
            heap = grown_line(heap)
            keys = grown_line(keys)
        for p in range(len(prims)):
            row = prims[p]
            if row[FROM_MOVING] != moving:
                continue
            nx, ny, nyaw = advanced(x, y, yaw, row[LENGTH], row[TURN])
            then = t + row[DURATION]
            if nx < 0.0 or ny < 0.0:
                continue
            gone = length + (row[LENGTH] if row[LENGTH] >= 0.0 else -dislike * row[LENGTH])
            ahead = math.sqrt((goal[0] - nx) ** 2 + (goal[1] - ny) ** 2)
            if guide.shape[0] > 0:
                ahead = max(ahead, _guided(guide, guide_cell, nx, ny) - 1.5 * guide_cell)
                if ahead == math.inf:
                    continue
            quickest, _ = trapezoid(
                ahead, speed if row[TO_MOVING] > 0.0 else 0.0, 0.0, speed, mover[ACCELERATION]
            )
            if quickest < 0.0:
                quickest = ahead / speed
            rest = price * ahead + max(quickest, taken - then)
            if then + price * gone + rest >= best_cost:
                continue
            value = then + price * gone + greed * rest
            state[used, 0], state[used, 1], state[used, 2] = nx, ny, nyaw
            state[used, 3], state[used, 4], state[used, 5] = row[TO_MOVING], then, gone
            link[used, 0], link[used, 1] = node, p
            waiting = push(heap, keys, waiting, used, value)
            used += 1
    if best_node < 0:
        return NONE, none, expansions
    depth = 0
    node = best_node
    while node > 0:
        depth += 1
        node = link[node, 0]
    moves = np.empty((depth + best_count, 6))
    node = best_node
    for k in range(depth - 1, -1, -1):
        moves[k] = prims[link[node, 1], :6]
        node = link[node, 0]
    moves[depth:] = best_word[:best_count]
    return FOUND, moves, expansions
