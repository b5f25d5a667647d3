"""Kernel of the search in the product space: RRT-Connect over the poses of all robots at once.

The paper's joint planner, as its text describes it, for any number of robots: what is sampled is
one point of the joint space, the robots' places biased away from each other, and an edge counts
only if no robot meets the ground or, at the same time, another robot. At nodes all robots rest, so
that edges can be driven from either tree.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.kinodynamic.random import uniform
from cavalcade.lattice.collision import bodies_meet, move_free, pose_free
from cavalcade.lattice.dubins import MOST_MOVES, MOST_WORDS, connect
from cavalcade.lattice.primitives import (
    DURATION,
    HALF_LENGTH,
    HALF_WIDTH,
    LENGTH,
    ROUND,
    TURN,
    advanced,
    sample_moves,
)

FOUND, SPENT = 0, 2
_TRIES = 20
_REACH = 4.0
"""Largest step of a robot in one extension, m."""


@njit(cache=True)
def word_between(grid, nobody, mover, a, b, price, margins, steps):
    """The cheapest word from rest at `a` to rest at `b` on free ground, `(M, 6)`; whether any."""
    words = np.empty((MOST_WORDS, MOST_MOVES, 6))
    counts = np.zeros(MOST_WORDS, dtype=np.int64)
    costs = np.empty(MOST_WORDS)
    number = connect(a, 0.0, b, 0.0, mover, price, words, counts, costs)
    for _ in range(number):
        pick = -1
        for k in range(number):
            if counts[k] >= 0 and (pick < 0 or costs[k] < costs[pick]):
                pick = k
        if pick < 0:
            break
        count = counts[pick]
        counts[pick] = -1
        x, y, yaw = a[0], a[1], a[2]
        good = True
        for k in range(count):
            row = words[pick, k]
            if not move_free(grid, nobody, x, y, yaw, row, mover, 0.0, margins, steps, False):
                good = False
                break
            x, y, yaw = advanced(x, y, yaw, row[LENGTH], row[TURN])
        if good:
            return words[pick, :count].copy(), True
    return words[0, :0].copy(), False


@njit(cache=True)
def edge_free(grid, nobody, movers, a, b, price, margins, steps):
    """Whether all robots get from poses `a` to `b` `(N, 3)` at once."""
    n = len(movers)
    longest = 0.0
    count = 1
    moves = np.zeros((n, MOST_MOVES, 6))
    sizes = np.zeros(n, dtype=np.int64)
    for k in range(n):
        rows, good = word_between(grid, nobody, movers[k], a[k], b[k], price, margins, steps)
        if not good:
            return False
        sizes[k] = len(rows)
        moves[k, : len(rows)] = rows
        longest = max(longest, rows[:, DURATION].sum())
    count = int(math.ceil(longest / steps[2])) + 1
    times = np.empty(count)
    for i in range(count):
        times[i] = min(i * steps[2], longest)
    tracks = np.empty((n, count, 6))
    for k in range(n):
        tracks[k] = sample_moves(a[k], moves[k, : sizes[k]], movers[k], times)
    for i in range(count):
        for j in range(n):
            for k in range(j):
                if bodies_meet(
                    tracks[j, i, 0],
                    tracks[j, i, 1],
                    tracks[j, i, 2],
                    movers[j, HALF_LENGTH],
                    movers[j, HALF_WIDTH],
                    movers[j, ROUND],
                    tracks[k, i, 0],
                    tracks[k, i, 1],
                    tracks[k, i, 2],
                    movers[k, HALF_LENGTH],
                    movers[k, HALF_WIDTH],
                    movers[k, ROUND],
                    margins[1],
                ):
                    return False
    return True


@njit(cache=True)
def _sample(grid, movers, rng, out):
    """One point of the joint space: free places, each later one away from the earlier ones."""
    cell, solid, _ = grid
    height, width = solid.shape[0] * cell, solid.shape[1] * cell
    for k in range(len(movers)):
        best = -1.0
        for _ in range(_TRIES):
            x, y = uniform(rng) * width, uniform(rng) * height
            yaw = (2.0 * uniform(rng) - 1.0) * math.pi
            if not pose_free(
                grid,
                x,
                y,
                yaw,
                movers[k, HALF_LENGTH],
                movers[k, HALF_WIDTH],
                movers[k, ROUND],
                0.0,
            ):
                continue
            gap = math.inf
            for j in range(k):
                near = math.sqrt((x - out[j, 0]) ** 2 + (y - out[j, 1]) ** 2)
                gap = min(gap, near - movers[j, HALF_LENGTH] - movers[k, HALF_LENGTH])
            if gap > best:
                best = gap
                out[k, 0], out[k, 1], out[k, 2] = x, y, yaw
            if best > 2.0 * movers[k, HALF_LENGTH]:
                break
        if best < 0.0:
            return False
    return True


@njit(cache=True)
def _nearest(nodes, count, point):
    best, least = 0, math.inf
    for i in range(count):
        total = 0.0
        for k in range(point.shape[0]):
            total += math.sqrt(
                (nodes[i, k, 0] - point[k, 0]) ** 2 + (nodes[i, k, 1] - point[k, 1]) ** 2
            )
        if total < least:
            best, least = i, total
    return best


@njit(cache=True)
def _towards(node, point, share, forward, out):
    """Poses on the way from a node to a point, headed along it (`forward`) or back along it."""
    for k in range(len(node)):
        dx, dy = point[k, 0] - node[k, 0], point[k, 1] - node[k, 1]
        gap = math.sqrt(dx * dx + dy * dy)
        part = share * min(1.0, _REACH / max(gap, 1e-9))
        out[k, 0], out[k, 1] = node[k, 0] + part * dx, node[k, 1] + part * dy
        out[k, 2] = math.atan2(dy, dx) if forward else math.atan2(-dy, -dx)


@njit(cache=True)
def search_joint(grid, nobody, movers, starts, goals, price, margins, steps, rng, most):
    """Poses of all robots to stop at on the way from the starts to the goals.

    Args:
        grid: See `_moves_contact`; `nobody`: others, of whom there are none.
        movers: `(N, 11)`.
        starts, goals: `(N, 3)`.
        price, margins, steps: As in the search in space and time.
        rng: State of the generator `(1,)`.
        most: Extensions.

    Returns:
        FOUND or SPENT; poses `(M, N, 3)`, starts and goals included; extensions.
    """
    n = len(movers)
    if edge_free(grid, nobody, movers, starts, goals, price, margins, steps):
        direct = np.empty((2, n, 3))
        direct[0], direct[1] = starts, goals
        return FOUND, direct, 1
    nodes = np.empty((2, most + 2, n, 3))
    parents = np.full((2, most + 2), -1, dtype=np.int64)
    counts = np.ones(2, dtype=np.int64)
    nodes[0, 0], nodes[1, 0] = starts, goals
    point = np.empty((n, 3))
    fresh = np.empty((n, 3))
    tree = 0
    for iteration in range(most):
        mine, tree = tree, 1 - tree
        other = 1 - mine
        if not _sample(grid, movers, rng, point):
            continue
        near = _nearest(nodes[mine], counts[mine], point)
        grown = False
        for share in (1.0, 0.5, 0.25):
            _towards(nodes[mine, near], point, share, mine == 0, fresh)
            if mine == 0:
                good = edge_free(
                    grid, nobody, movers, nodes[mine, near], fresh, price, margins, steps
                )
            else:
                good = edge_free(
                    grid, nobody, movers, fresh, nodes[mine, near], price, margins, steps
                )
            if good:
                grown = True
                break
        if not grown:
            continue
        at = counts[mine]
        nodes[mine, at], parents[mine, at] = fresh, near
        counts[mine] += 1
        there = _nearest(nodes[other], counts[other], fresh)
        if mine == 0:
            good = edge_free(
                grid, nobody, movers, fresh, nodes[other, there], price, margins, steps
            )
        else:
            good = edge_free(
                grid, nobody, movers, nodes[other, there], fresh, price, margins, steps
            )
        if good:
            first, last = (at, there) if mine == 0 else (there, at)
            return FOUND, _path(nodes, parents, first, last), iteration + 1
    return SPENT, np.empty((0, n, 3)), most


@njit(cache=True)
def _path(nodes, parents, first, last):
    """From the root of the first tree over the two nodes to the root of the second tree."""
    ahead = 0
    node = first
    while node >= 0:
        ahead += 1
        node = parents[0, node]
    behind = 0
    node = last
    while node >= 0:
        behind += 1
        node = parents[1, node]
    path = np.empty((ahead + behind, nodes.shape[2], 3))
    node = first
    for k in range(ahead - 1, -1, -1):
        path[k] = nodes[0, node]
        node = parents[0, node]
    node = last
    for k in range(behind):
        path[ahead + k] = nodes[1, node]
        node = parents[1, node]
    return path


@njit(cache=True)
def shorten_joint(grid, nobody, movers, path, price, margins, steps):
    """The path with nodes left out, greedily from its start: edges to the farthest node."""
    kept = np.empty_like(path)
    kept[0] = path[0]
    count, i = 1, 0
    while i < len(path) - 1:
        j = len(path) - 1
        while j > i + 1:
            if edge_free(grid, nobody, movers, kept[count - 1], path[j], price, margins, steps):
                break
            j -= 1
        kept[count] = path[j]
        count += 1
        i = j
    return kept[:count].copy()
