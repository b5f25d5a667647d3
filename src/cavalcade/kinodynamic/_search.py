"""RRT-Connect with two trees."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.kinodynamic._extend import PLACES, REACHED, TRAPPED, grow
from cavalcade.kinodynamic._trees import may_turn, nearest
from cavalcade.kinodynamic.random import between, normal, uniform
from cavalcade.lattice.surface import surface

FOUND, SPENT, FULL = 0, 1, 2

_MOVING = 0.2
"""Share of samples that move; the others rest, and trees may turn there on the spot."""

_NEARBY, _STUCK = 0.15, 0.7
"""Shares of samples just ahead of a node: as a rule, and for a tree left far behind the other."""

_SPREAD = 0.3
_BEND = 0.6
_GUIDED = 0.5
_BESIDE = 0.15
_REDRAWS = 30


@njit(cache=True)
def draw_state(ground, body, rng, forest, tree, guide, bound, out):
    """Sample a state `(6,)` at nominal height.

    Half of the places are drawn beside `guide (G, 2)`, if there is one, the others uniformly on
    the map; where the way over them would be longer than `bound` m, again.

    Returns:
        The nearest node of the tree.
    """
    stuck = 4 * forest.used[tree] < forest.used[1 - tree]
    if not body.published and uniform(rng) < (_STUCK if stuck else _NEARBY):
        return _draw_nearby(ground, body, rng, forest, tree, out)
    rows, cols = ground.solid.shape
    a, b = forest.states[0, 0], forest.states[1, 0]
    for _ in range(_REDRAWS):
        if guide.shape[0] > 0 and uniform(rng) < _GUIDED:
            k = int(uniform(rng) * guide.shape[0])
            out[0] = guide[k, 0] + _BESIDE * normal(rng)
            out[1] = guide[k, 1] + _BESIDE * normal(rng)
        else:
            out[0] = between(rng, 0.0, cols * ground.cell)
            out[1] = between(rng, 0.0, rows * ground.cell)
        over = math.hypot(out[0] - a[0], out[1] - a[1]) + math.hypot(out[0] - b[0], out[1] - b[1])
        if over < bound:
            break
    height, along_x, along_y = surface(ground, out[0], out[1])
    out[2] = height + body.h_nom
    out[3], out[4], out[5] = 0.0, 0.0, 0.0
    near = nearest(forest, tree, out)
    if body.published or uniform(rng) < _MOVING:
        speed = min(body.v_nom * math.exp(_SPREAD * normal(rng)), body.v_max)
        angle = between(rng, -math.pi, math.pi)
        if not body.published:
            own = forest.states[tree, near]
            angle = 0.25 * angle + math.atan2(out[1] - own[1], out[0] - own[0])
            if tree == 1:
                angle += math.pi
        out[3], out[4] = speed * math.cos(angle), speed * math.sin(angle)
        out[5] = along_x * out[3] + along_y * out[4]
        if body.published:
            near = nearest(forest, tree, out)
    return near


@njit(cache=True)
def _draw_nearby(ground, body, rng, forest, tree, out):
    """Sample a place of rest a short way ahead of any node: a way on where it cannot turn far."""
    near = int(uniform(rng) * forest.used[tree])
    own = forest.states[tree, near]
    angle = forest.yaws[tree, near] + _BEND * normal(rng)
    way = between(rng, 0.15, 0.8)
    if tree == 1:
        way = -way
    out[0], out[1] = own[0] + way * math.cos(angle), own[1] + way * math.sin(angle)
    out[2] = surface(ground, out[0], out[1])[0] + body.h_nom
    out[3], out[4], out[5] = 0.0, 0.0, 0.0
    return near


@njit(cache=True)
def search(ground, body, discs, leaps, rng, forest, guide, bound, begin, end):
    """Grow both trees until they meet.

    Args:
        forest: With both roots.
        guide, bound: Where to sample, see `draw_state`.
        begin, end: Numbers of the first iteration and of the one after the last.

    Returns:
        `FOUND`, `SPENT` or `FULL` (no room for nodes); the number of the next iteration; and the
        nodes of both trees that meet.
    """
    state = np.empty(6)
    for iteration in range(begin, end):
        if forest.states.shape[1] - max(forest.used[0], forest.used[1]) < 2 * PLACES:
            return FULL, iteration, -1, -1
        tree = iteration % 2
        if iteration < 2:
            # First straight to the other root.
            node = 0
            for k in range(6):
                state[k] = forest.states[1 - tree, 0, k]
        else:
            node = draw_state(ground, body, rng, forest, tree, guide, bound, state)
        status, node = grow(ground, body, discs, leaps, rng, forest, tree, node, state)
        if status == TRAPPED:
            continue
        other = 1 - tree
        if iteration < 2 and status == REACHED:
            if _meet(ground, body, discs, forest, tree, node, 0):
                return (
                    (FOUND, iteration + 1, node, 0)
                    if tree == 0
                    else (FOUND, iteration + 1, 0, node)
                )
            continue
        for k in range(6):
            state[k] = forest.states[tree, node, k]
        near = nearest(forest, other, state)
        status, far = grow(ground, body, discs, leaps, rng, forest, other, near, state)
        if status == REACHED and _meet(ground, body, discs, forest, tree, node, far):
            if tree == 0:
                return FOUND, iteration + 1, node, far
            return FOUND, iteration + 1, far, node
    return SPENT, end, -1, -1


@njit(cache=True)
def _meet(ground, body, discs, forest, tree, node, far):
    """Whether the body can go on from one tree to the other in a state that both have."""
    yaw = forest.yaws[1 - tree, far]
    return may_turn(
        ground,
        body,
        discs,
        forest.states[tree, node],
        forest.yaws[tree, node],
        math.cos(yaw),
        math.sin(yaw),
    )


@njit(cache=True)
def route(forest, first, second):
    """Primitives `(M, SIZE)` from the start to the goal by the nodes that meet."""
    count = 0
    node = first
    while forest.parents[0, node] >= 0:
        count += 1
        node = forest.parents[0, node]
    ahead = count
    node = second
    while forest.parents[1, node] >= 0:
        count += 1
        node = forest.parents[1, node]
    edges = np.empty((count, forest.edges.shape[2]))
    node, k = first, ahead - 1
    while forest.parents[0, node] >= 0:
        edges[k] = forest.edges[0, node]
        node, k = forest.parents[0, node], k - 1
    node, k = second, ahead
    while forest.parents[1, node] >= 0:
        edges[k] = forest.edges[1, node]
        node, k = forest.parents[1, node], k + 1
    return edges
