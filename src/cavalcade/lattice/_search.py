"""Kernel of space-time A*: moves as edges, with analytic expansions to the goal.

States are continuous; of those that fall into one bin of place, heading, walking or standing, and
time, only the first is expanded (as in hybrid A*, Dolgov et al., IJRR 29(5), 2010, who call words
that are tried from a node to the goal analytic expansions). Time is part of the bin for as long as
somebody else moves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kernels import kernel, subroutine
from cavalcade.kernels.copying import copy_rows, copy_to
from cavalcade.lattice._queue import doubled, doubled_rows, pop, push, slot_of
from cavalcade.lattice.collision import move_free, moves_free, occupied_until, still_from
from cavalcade.lattice.dubins import (
    MOST_MOVES,
    backward_factor,
    connect,
    no_words,
    take_cheapest,
)
from cavalcade.lattice.motion_limits import FROM_MOVING, TO_MOVING, footprint_of
from cavalcade.lattice.primitives import DURATION, LENGTH, TURN, advanced, duration_of, trapezoid

FOUND, EXHAUSTED, SPENT, PAUSED = 0, 1, 2, 3

_HEADINGS = 32
_PATIENCE = 300
"""Expansions after a first path was found, to find a better one."""

_MORE_PATIENCE = 3000
_GOOD = 1.08
"""The same where it costs more than this times the least that is possible."""

_WORDS_TRIED = 3
_WAIT, _LONGEST_WAIT = 0.5, 15.0
"""The cheapest words are tried after waits at the start in such steps, s."""

_ROOM = 1024
"""Nodes that there is room for at first."""

_LOOPS = 4.0
"""Words that cost more than this beyond the straight line are not tried, s."""


class CostToGo(NamedTuple):
    """What the search's heuristic knows of the ground.

    Attributes:
        lengths: `(rows, cols)` of the shortest paths to the goal, m; `(0, 0)` where nothing stands.
        cell: m.
    """

    lengths: Array
    cell: float


class SearchSettings(NamedTuple):
    """How to search.

    Attributes:
        bin_size, bin_time: Of a bin, m and s.
        weight: Of the heuristic, at least 1: larger ones find paths sooner.
        most: Expansions.
        pause: Expansions after which the search stops to be gone on with.
    """

    bin_size: float
    bin_time: float
    weight: float
    most: int
    pause: int


class Frontier(NamedTuple):
    """What a search knows between two pauses.

    Attributes:
        state: `(C, 6)` nodes: x, y, yaw, moving, time, length.
        link: `(C, 2)` their parents, and the moves from there.
        heap, keys: `(C,)` the queue: nodes, and what they are ordered by.
        closed: Table of bins; empty until the first one is closed.
        word: `(MOST_MOVES + 1, 6)` the last moves of the best path.
        cost: `(1,)` of the best path.
        counts: `(6,)` nodes; length of the queue; expansions, and those at which the first path
            was found; the best path's node, -1 without one, and how many moves follow it.
    """

    state: Array
    link: NDArray[np.int64]
    heap: NDArray[np.int64]
    keys: Array
    closed: NDArray[np.int64]
    word: Array
    cost: Array
    counts: NDArray[np.int64]


def new_frontier(start: Array) -> Frontier:
    """The root alone, at rest at `start` `(3,)`."""
    frontier = Frontier(
        state=np.empty((_ROOM, 6)),
        link=np.empty((_ROOM, 2), dtype=np.int64),
        heap=np.zeros(_ROOM, dtype=np.int64),
        keys=np.zeros(_ROOM),
        closed=np.empty(0, dtype=np.int64),
        word=np.empty((MOST_MOVES + 1, 6)),
        cost=np.array([math.inf]),
        counts=np.array([1, 1, 0, 0, -1, 0]),
    )
    frontier.state[0] = (*start[:3], 0.0, 0.0, 0.0)
    frontier.link[0] = -1
    return frontier


@subroutine
def _bin(x, y, yaw, moving, t, settings):
    """One number for place, heading, moving and time."""
    i, j = np.int64(x / settings.bin_size), np.int64(y / settings.bin_size)
    heading = np.int64(math.floor(yaw / (2.0 * math.pi) * _HEADINGS + 0.5)) % _HEADINGS
    moment = np.int64(t / settings.bin_time)
    return (((moment * 8192 + i) * 8192 + j) * _HEADINGS + heading) * 2 + moving


@subroutine
def _length_to_go(to_go, x, y):
    """Length of the shortest path to the goal from the cell of a point, m."""
    row = min(max(int(y / to_go.cell), 0), to_go.lengths.shape[0] - 1)
    col = min(max(int(x / to_go.cell), 0), to_go.lengths.shape[1] - 1)
    return to_go.lengths[row, col]


@subroutine
def _distance_ahead(to_go, x, y, goal):
    """A lower bound of the length to the goal, m: straight, or along the grid less its rounding."""
    ahead = math.sqrt((goal[0] - x) ** 2 + (goal[1] - y) ** 2)
    if to_go.lengths.shape[0] > 0:
        ahead = max(ahead, _length_to_go(to_go, x, y) - 1.5 * to_go.cell)
    return ahead


@subroutine
def _later_start(scene, start, goal, taken, words, out):
    """The shortest wait at the start after which one of the cheapest words gets to the goal.

    Others are at the goal until `taken` s. The moves are written to `out`, the wait first; returned
    are their number, 0 if there is no such wait, and their cost.
    """
    number = connect(start, 0.0, goal, 0.0, scene.limits, scene.metre_cost, words)
    chosen = np.empty(_WORDS_TRIED, np.int64)
    chosen[:] = -1
    sizes = np.zeros(_WORDS_TRIED, dtype=np.int64)
    for rank in range(_WORDS_TRIED):
        chosen[rank], sizes[rank] = take_cheapest(words, number)
    here = (start[0], start[1], start[2])
    stand = np.zeros(6)
    stand[DURATION] = _WAIT
    wait = 0.0
    while wait < _LONGEST_WAIT:
        if not move_free(scene, here, stand, wait, True):
            break
        wait += _WAIT
        for rank in range(_WORDS_TRIED):
            pick, count = chosen[rank], sizes[rank]
            if pick < 0:
                break
            word = words.moves[pick, :count]
            if wait + duration_of(word) <= taken:
                continue
            if moves_free(scene, here, word, wait, False):
                copy_to(out[0], stand)
                out[0, DURATION] = wait
                copy_rows(out[1:], word)
                return count + 1, wait + words.costs[pick]
    return 0, 0.0


@subroutine
def _path_to(node, link, primitives, word):
    """The moves `(M, 6)` from the root to a node, and a word from there."""
    depth = 0
    at = node
    while at > 0:
        depth += 1
        at = link[at, 0]
    moves = np.empty((depth + len(word), 6))
    at = node
    for k in range(depth - 1, -1, -1):
        copy_to(moves[k], primitives[link[at, 1], :6])
        at = link[at, 0]
    copy_rows(moves[depth:], word)
    return moves


@kernel(nogil=True)
def search(scene, goal, primitives, to_go, settings, frontier):
    """The cheapest path from rest at the root to rest at `goal` past everything, for good.

    `primitives` `(P, 8)` are moves, and whether they begin and end walking; `frontier` is that of
    the root alone, or where the search has paused. It must not be used again.

    Returns:
        FOUND, EXHAUSTED (nothing left to try), SPENT or PAUSED; moves `(M, 6)`; expansions; the
        frontier to go on from.
    """
    limits, others, metre_cost = scene.limits, scene.others, scene.metre_cost
    most, weight = settings.most, settings.weight
    words = no_words()
    none = np.empty((0, 6))
    # Arriving counts only from when nobody comes past the goal any more.
    taken = occupied_until(
        others, footprint_of(limits), (goal[0], goal[1], goal[2]), 0.0, scene.margins
    )
    if taken == math.inf:
        return EXHAUSTED, none, 0, frontier
    still = still_from(others)
    speed = limits.speed
    turn_round, _ = trapezoid(math.pi, 0.0, 0.0, limits.yaw_rate, limits.yaw_acceleration)
    turn_round *= 2.0
    dislike = backward_factor(limits)
    # A lower bound of the whole cost tells whether what is found is good.
    state, link, heap, keys, closed, best_word, best, counts = frontier
    gap = _distance_ahead(to_go, state[0, 0], state[0, 1], goal)
    lowest, _ = trapezoid(gap, 0.0, 0.0, speed, limits.acceleration)
    lowest += metre_cost * gap

    # The first analytic expansion needs no table of bins: most problems end here.
    capacity = min(most * (len(primitives) + 1) + 2, 4_000_000)
    size = 1 << 12
    while size < 2 * min(most + 1, capacity):
        size <<= 1
    used, waiting, expansions, found_at = counts[0], counts[1], counts[2], counts[3]
    best_cost, best_node, best_count = best[0], counts[4], counts[5]
    here = np.empty(3)
    while waiting > 0:
        if settings.pause <= expansions < most:
            best[0] = best_cost
            counts[0], counts[1], counts[2], counts[3] = used, waiting, expansions, found_at
            counts[4], counts[5] = best_node, best_count
            known = Frontier(state, link, heap, keys, closed, best_word, best, counts)
            return PAUSED, none, expansions, known
        least = keys[0]
        node, waiting = pop(heap, keys, waiting)
        # The search ends when nothing cheaper can come, or after a while without a better path.
        if least >= weight * best_cost - 1e-9:
            break
        if best_node >= 0:
            patience = _PATIENCE if best_cost < _GOOD * lowest else _MORE_PATIENCE
            if expansions - found_at > patience:
                break
        if expansions >= most or used + len(primitives) >= capacity:
            if best_node >= 0:
                break
            return SPENT, none, expansions, frontier
        x, y, yaw, moving = state[node, 0], state[node, 1], state[node, 2], state[node, 3]
        t, length = state[node, 4], state[node, 5]
        # Lazily: a node's bin and the move to it are looked at when its turn comes.
        if node > 0:
            if closed.shape[0] == 0:
                closed = np.empty(size, np.int64)
                closed[:] = -1
            key = _bin(x, y, yaw, np.int64(moving), min(t, still), settings)
            slot = slot_of(closed, key)
            if closed[slot] == key:
                continue
            parent = link[node, 0]
            before = (state[parent, 0], state[parent, 1], state[parent, 2])
            if not move_free(scene, before, primitives[link[node, 1]], state[parent, 4], False):
                continue
            closed[slot] = key
        expansions += 1
        # An analytic expansion, unless the cost-to-go says that something stands between; often
        # near the goal, else now and then.
        gap = math.sqrt((goal[0] - x) ** 2 + (goal[1] - y) ** 2)
        sight = True
        if to_go.lengths.shape[0] > 0:
            sight = _length_to_go(to_go, x, y) < 1.1 * gap + 0.3
        near = gap < 3.0 and sight
        if length == 0.0 or near or (sight and expansions % 4 == 0) or expansions % 16 == 0:
            here[0], here[1], here[2] = x, y, yaw
            now = speed if moving > 0.0 else 0.0
            number = connect(here, now, goal, 0.0, limits, metre_cost, words)
            first_try = True
            dear = math.inf
            if node > 0:
                dear = gap * (metre_cost + 1.0 / speed) + turn_round + _LOOPS
            for _ in range(number):
                pick, count = take_cheapest(words, number)
                cost = t + metre_cost * length + words.costs[pick]
                if cost >= best_cost - 1e-9 or words.costs[pick] > dear:
                    break
                word = words.moves[pick, :count]
                if t + duration_of(word) <= taken:
                    first_try = False
                    continue
                if moves_free(scene, (x, y, yaw), word, t, False):
                    best_cost, best_node, best_count = cost, node, count
                    copy_rows(best_word, word)
                    if found_at == 0:
                        found_at = expansions
                    if node == 0 and first_try:
                        # The cheapest word of all is free: there is nothing to look for.
                        return FOUND, word.copy(), expansions, frontier
                    break
                first_try = False
            if node == 0 and best_node < 0 and others.spans.shape[0] > 0:
                # Setting off later is a path, too, and bounds what the search may cost.
                best_count, cost = _later_start(scene, here, goal, taken, words, best_word)
                if best_count > 0:
                    best_cost, best_node, found_at = cost, 0, expansions
        # Its successors; those that cannot beat the best path known are left out.
        if used + len(primitives) >= state.shape[0]:
            state = doubled_rows(state)
            link = doubled_rows(link)
            heap = doubled(heap)
            keys = doubled(keys)
        for p in range(len(primitives)):
            row = primitives[p]
            if row[FROM_MOVING] != moving:
                continue
            nx, ny, nyaw = advanced(x, y, yaw, row[LENGTH], row[TURN])
            then = t + row[DURATION]
            if nx < 0.0 or ny < 0.0:
                continue
            gone = length + (row[LENGTH] if row[LENGTH] >= 0.0 else -dislike * row[LENGTH])
            ahead = _distance_ahead(to_go, nx, ny, goal)
            if ahead == math.inf:
                continue
            # Cost-to-go: the quickest way over that distance, but not before the goal is free.
            now = speed if row[TO_MOVING] > 0.0 else 0.0
            quickest, _ = trapezoid(ahead, now, 0.0, speed, limits.acceleration)
            if quickest < 0.0:
                quickest = ahead / speed
            rest = metre_cost * ahead + max(quickest, taken - then)
            if then + metre_cost * gone + rest >= best_cost:
                continue
            value = then + metre_cost * gone + weight * rest
            state[used, 0], state[used, 1], state[used, 2] = nx, ny, nyaw
            state[used, 3], state[used, 4], state[used, 5] = row[TO_MOVING], then, gone
            link[used, 0], link[used, 1] = node, p
            waiting = push(heap, keys, waiting, used, value)
            used += 1
    if best_node < 0:
        return EXHAUSTED, none, expansions, frontier
    moves = _path_to(best_node, link, primitives, best_word[:best_count])
    return FOUND, moves, expansions, frontier
