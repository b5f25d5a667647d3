"""Growing a tree towards a state: CONNECT, and leaps where the ground is in the way."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.kinodynamic._leap_aimed import aimed_leap, find_barrier
from cavalcade.kinodynamic._leap_random import random_leap
from cavalcade.kinodynamic._stance import make_walk, walk_state
from cavalcade.kinodynamic._trees import attach, stands_still, try_walk
from cavalcade.kinodynamic.parameters import END, GROUND, MOTION, OK, SIZE, START, TIME
from cavalcade.lattice.surface import surface

TRAPPED, ADVANCED, REACHED = 0, 1, 2

_LEAST_WAY = 0.1
_BACK_UP = 0.5
_LEAST_STEPS = 7
_DRAWS = 18
_BARRIERS = 8
_RUN_UP = 1.0
PLACES = 8 * (_BARRIERS + 1)
"""Nodes that growing once may add."""


@njit(cache=True)
def grow(ground, body, discs, leaps, rng, forest, tree, node, state):
    """Extend a tree from a node towards a state.

    Returns:
        `TRAPPED`, `ADVANCED` or `REACHED`, and the last node added.
    """
    edge, leap, link = np.empty(SIZE), np.empty(SIZE), np.empty(SIZE)
    scratch, draw = np.empty(12), np.empty(6)
    line = np.empty(4)
    status = TRAPPED
    for _ in range(_BARRIERS):
        found, until = try_walk(ground, body, discs, forest, tree, node, state, edge, scratch)
        if found == OK:
            return REACHED, attach(forest, tree, node, edge)
        if body.published:
            return _published(
                ground, body, discs, leaps, rng, forest, tree, node, state, edge, until, scratch
            )
        over = -1
        if leaps and found == GROUND:
            over = _leap_over(
                ground,
                body,
                discs,
                rng,
                forest,
                tree,
                node,
                state,
                edge,
                until,
                line,
                draw,
                leap,
                scratch,
                link,
            )
        if over < 0:
            end = _advance(ground, body, forest, tree, node, state, edge, until, scratch)
            if end >= 0:
                return ADVANCED, end
            return status, node
        node, status = over, ADVANCED
    return status, node


@njit(cache=True)
def _advance(ground, body, forest, tree, node, state, edge, until, scratch):
    """Add what is valid of a CONNECT: the node, or -1 if it is too little."""
    own = forest.states[tree, node]
    if until <= 0.0:
        return -1
    if stands_still(own) and stands_still(state) and not body.published:
        # A straight line, of which any part can be walked from rest to rest.
        span = edge[TIME]
        walk_state(ground, body, edge, until if tree == 0 else span - until, scratch[:6])
        if math.hypot(scratch[0] - own[0], scratch[1] - own[1]) < _LEAST_WAY:
            return -1
        scratch[2] = surface(ground, scratch[0], scratch[1])[0] + body.h_nom
        scratch[3], scratch[4], scratch[5] = 0.0, 0.0, 0.0
        if tree == 0:
            allowed = make_walk(ground, body, own, scratch[:6], edge)
        else:
            allowed = make_walk(ground, body, scratch[:6], own, edge)
        return attach(forest, tree, node, edge) if allowed else -1
    until *= _BACK_UP
    if until <= _LEAST_STEPS * body.dt:
        return -1
    cut(ground, body, edge, tree, until, scratch)
    return attach(forest, tree, node, edge)


@njit(cache=True)
def cut(ground, body, edge, tree, until, scratch):
    """Shorten a CONNECT to its first (tree 1: last) `until` s; a part of a cubic is one, too."""
    span = edge[TIME]
    if tree == 0:
        walk_state(ground, body, edge, until, scratch[:6])
        for k in range(6):
            edge[END + k] = scratch[k]
    else:
        walk_state(ground, body, edge, span - until, scratch[:6])
        for k in range(6):
            edge[START + k] = scratch[k]
    edge[TIME] = until


@njit(cache=True)
def _leap_over(
    ground,
    body,
    discs,
    rng,
    forest,
    tree,
    node,
    state,
    edge,
    until,
    line,
    draw,
    leap,
    scratch,
    link,
):
    """Add a leap over what stops a walk from a node to a state, and the way to it.

    Returns:
        The node behind the leap, or -1.
    """
    own = forest.states[tree, node]
    dx, dy = state[0] - own[0], state[1] - own[1]
    away = math.hypot(dx, dy)
    if away < 0.3:
        return -1
    sign = 1.0 if tree == 0 else -1.0
    cos, sin = sign * dx / away, sign * dy / away
    span = edge[TIME]
    until = max(until, 0.0)
    walk_state(ground, body, edge, until if tree == 0 else span - until, scratch[:6])
    at = cos * (scratch[0] - own[0]) + sin * (scratch[1] - own[1])
    walk, take_off, landing = find_barrier(ground, body, own[0], own[1], cos, sin, at, tree == 1)
    if math.isnan(walk) or math.isnan(landing):
        return -1
    line[0], line[1], line[2], line[3] = own[0], own[1], cos, sin
    far = START if tree == 1 else END
    near = END if tree == 1 else START
    for attempt in range(_DRAWS):
        if not aimed_leap(
            ground, body, discs, line, walk, take_off, landing, attempt, rng, draw, leap, scratch
        ):
            continue
        before = forest.used[tree]
        end = _link(
            ground, body, discs, forest, tree, node, leap[near : near + 6], line, link, scratch
        )
        if end < 0:
            forest.used[tree] = before
            continue
        end = attach(forest, tree, end, leap)
        # Come to rest behind it, for other ways on; the leap's end remains a node, too.
        _stop(ground, body, discs, forest, tree, end, leap[far : far + 6], line, link, scratch)
        return end
    return -1


@njit(cache=True)
def _link(ground, body, discs, forest, tree, node, target, line, edge, scratch):
    """Walk from a node to where a leap begins (tree 1: from where it ends to the node)."""
    own = forest.states[tree, node]
    back = -1.0 if tree == 0 else 1.0
    way = math.hypot(target[0] - own[0], target[1] - own[1])
    mid = np.empty(6)
    if way > 1.5 * _RUN_UP:
        _beside(ground, body, target, line, back * _RUN_UP, body.v_nom, mid)
        found, _ = try_walk(ground, body, discs, forest, tree, node, mid, edge, scratch)
        if found == OK:
            middle = attach(forest, tree, node, edge)
            found, _ = try_walk(ground, body, discs, forest, tree, middle, target, edge, scratch)
            if found == OK:
                return attach(forest, tree, middle, edge)
    found, _ = try_walk(ground, body, discs, forest, tree, node, target, edge, scratch)
    if found == OK:
        return attach(forest, tree, node, edge)
    if found != MOTION and way > 1.5 * _RUN_UP:
        return -1
    _beside(ground, body, target, line, back * _RUN_UP, 0.0, mid)
    found, _ = try_walk(ground, body, discs, forest, tree, node, mid, edge, scratch)
    if found != OK:
        return -1
    middle = attach(forest, tree, node, edge)
    found, _ = try_walk(ground, body, discs, forest, tree, middle, target, edge, scratch)
    if found != OK:
        return -1
    return attach(forest, tree, middle, edge)


@njit(cache=True)
def _stop(ground, body, discs, forest, tree, node, state, line, edge, scratch):
    rest = np.empty(6)
    ahead = 1.0 if tree == 0 else -1.0
    for k in range(3):
        _beside(ground, body, state, line, ahead * _RUN_UP * (1.0 - 0.25 * k), 0.0, rest)
        found, _ = try_walk(ground, body, discs, forest, tree, node, rest, edge, scratch)
        if found == OK:
            attach(forest, tree, node, edge)
            return


@njit(cache=True)
def _beside(ground, body, state, line, way, speed, out):
    """The state `way` m further along a line, at nominal height, with a speed along it."""
    cos, sin = line[2], line[3]
    out[0], out[1] = state[0] + way * cos, state[1] + way * sin
    height, along_x, along_y = surface(ground, out[0], out[1])
    out[2] = height + body.h_nom
    out[3], out[4] = speed * cos, speed * sin
    out[5] = along_x * out[3] + along_y * out[4]


@njit(cache=True)
def sprout(ground, body, discs, forest):
    """Walk straight ahead from the start and straight into the goal, where turning needs room."""
    edge, scratch, state = np.empty(SIZE), np.empty(12), np.empty(6)
    line = np.empty(4)
    for tree in range(2):
        root = forest.states[tree, 0]
        line[2], line[3] = math.cos(forest.yaws[tree, 0]), math.sin(forest.yaws[tree, 0])
        way = 0.2 if tree == 0 else -0.2
        for k in range(8):
            _beside(ground, body, root, line, way * (k + 1), 0.0, state)
            found, _ = try_walk(ground, body, discs, forest, tree, 0, state, edge, scratch)
            if found != OK:
                break
            attach(forest, tree, 0, edge)


@njit(cache=True)
def _published(ground, body, discs, leaps, rng, forest, tree, node, state, edge, until, scratch):
    """What the published planner does where CONNECT fails: leaps compete with the partial way."""
    best = -1
    least = math.inf
    before = forest.used[tree]
    end = _advance(ground, body, forest, tree, node, state, edge, until, scratch)
    if end >= 0:
        best, least = end, _apart(forest.states[tree, end], state)
    if leaps:
        for _ in range(10):
            if not random_leap(
                ground, body, discs, rng, forest.states[tree, node], tree, edge, scratch
            ):
                continue
            at = END if tree == 0 else START
            away = _apart(edge[at : at + 6], state)
            if away < least:
                forest.used[tree] = before
                best, least = attach(forest, tree, node, edge), away
    if best < 0:
        return TRAPPED, node
    return ADVANCED, best


@njit(cache=True)
def _apart(a, b):
    way, speed = 0.0, 0.0
    for k in range(3):
        way += (a[k] - b[k]) ** 2
        speed += (a[k + 3] - b[k + 3]) ** 2
    return math.sqrt(way) + math.sqrt(speed)
