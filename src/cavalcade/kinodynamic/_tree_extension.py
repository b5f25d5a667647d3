"""Extending a tree towards a state: CONNECT, and leaps where the ground is in the way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.geometry import Array
from cavalcade.kernels import kernel, subroutine
from cavalcade.kernels.copying import copy_to
from cavalcade.kinodynamic._connect import walk_state
from cavalcade.kinodynamic._leap_over_barrier import Line, find_barrier, leap_over
from cavalcade.kinodynamic._leap_random import random_leap
from cavalcade.kinodynamic._tree import add_node, connect, make_walk_from
from cavalcade.kinodynamic._validity import rest_at, stands_still
from cavalcade.kinodynamic.parameters import END, GROUND, MOTION, OK, SIZE, START, TIME
from cavalcade.lattice.surface import surface

TRAPPED, ADVANCED, REACHED = 0, 1, 2

_BACK_UP = 0.5
"""Share that is kept of what is valid of a CONNECT that moves at an end."""

_LEAST_LENGTH, _LEAST_STEPS = 0.1, 7
"""Parts of a CONNECT that are shorter than this are not kept: straight ones in m, others in dt."""

_DRAWS, _RANDOM_DRAWS = 18, 10
"""Tries of leaps: for each barrier, and at each node by the published planner."""

_BARRIERS = 8
"""Barriers that one extension crosses at most."""

_RUN_UP = 1.0
"""Length of the walk before and after a leap, m."""

PLACES = 8 * (_BARRIERS + 1)
"""Nodes that one extension may add."""


class Work(NamedTuple):
    """Arrays that an extension writes to, made once.

    Attributes:
        walk, leap, link: `(SIZE,)` the CONNECT towards the sample, the leap over what stops it,
            and the CONNECTs before and after the leap.
        scratch: `(12,)` room for two states.
    """

    walk: Array
    leap: Array
    link: Array
    scratch: Array


@subroutine
def make_work():
    """Arrays for one extension."""
    return Work(np.empty(SIZE), np.empty(SIZE), np.empty(SIZE), np.empty(12))


@subroutine
def extend(space, tree, node, state, rng):
    """Extend a tree from a node: `TRAPPED`, `ADVANCED` or `REACHED`, and the last node added."""
    work = make_work()
    status = TRAPPED
    for _ in range(_BARRIERS):
        found, until = connect(space, tree, node, state, work.walk, work.scratch)
        if found == OK:
            return REACHED, tree.used[0] - 1
        if space.body.published:
            return _extend_published(space, tree, node, state, until, rng, work)
        over = -1
        if space.body.leaps and found == GROUND:
            over = _cross(space, tree, node, state, until, rng, work)
        if over < 0:
            end = _advance(space, tree, node, state, until, work)
            if end >= 0:
                return ADVANCED, end
            return status, node
        node, status = over, ADVANCED
    return status, node


@subroutine
def _advance(space, tree, node, state, until, work):
    """Add what is valid of a CONNECT: the node, or -1 if it is too little."""
    own, edge, stop = tree.states[node], work.walk, work.scratch[:6]
    if until <= 0.0:
        return -1
    if stands_still(own) and stands_still(state) and not space.body.published:
        # A straight line, of which any part can be walked from rest to rest.
        walk_state(space, edge, edge[TIME] - until if tree.backwards else until, stop)
        if math.hypot(stop[0] - own[0], stop[1] - own[1]) < _LEAST_LENGTH:
            return -1
        rest_at(space, stop[0], stop[1], stop)
        allowed = make_walk_from(space, tree, own, stop, edge)
        return add_node(tree, node, edge) if allowed else -1
    until *= _BACK_UP
    if until <= _LEAST_STEPS * space.body.dt:
        return -1
    truncate(space, edge, tree.backwards, until, stop)
    return add_node(tree, node, edge)


@subroutine
def truncate(space, edge, backwards, until, scratch):
    """Shorten a CONNECT to its first (`backwards`: last) `until` s; a part of a cubic is one."""
    walk_state(space, edge, edge[TIME] - until if backwards else until, scratch[:6])
    copy_to(edge[START:] if backwards else edge[END:], scratch[:6])
    edge[TIME] = until


@subroutine
def _cross(space, tree, node, state, until, rng, work):
    """Add a leap over what stops a walk to a state, and the walk to it: the node behind, or -1."""
    own, leap = tree.states[node], work.leap
    dx, dy = state[0] - own[0], state[1] - own[1]
    away = math.hypot(dx, dy)
    if away < 0.3:
        return -1
    # Along the straight line to the state, in the direction in which the body travels.
    sign = -1.0 if tree.backwards else 1.0
    line = Line(own[0], own[1], sign * dx / away, sign * dy / away)
    until = max(until, 0.0)
    stop = work.scratch[:6]
    walk_state(space, work.walk, work.walk[TIME] - until if tree.backwards else until, stop)
    at = line.cos * (stop[0] - own[0]) + line.sin * (stop[1] - own[1])
    barrier = find_barrier(space, line, at, tree.backwards)
    if math.isnan(barrier.walk) or math.isnan(barrier.landing):
        return -1
    near, far = (END, START) if tree.backwards else (START, END)
    for attempt in range(_DRAWS):
        if not leap_over(space, line, barrier, attempt, rng, leap, work.scratch):
            continue
        before = tree.used[0]
        end = _link(space, tree, node, leap[near : near + 6], line, work)
        if end < 0:
            tree.used[0] = before
            continue
        end = add_node(tree, end, leap)
        # Come to rest behind it, for other paths on; the leap's end remains a node, too.
        _stop(space, tree, end, leap[far : far + 6], line, work)
        return end
    return -1


@subroutine
def _link(space, tree, node, target, line, work):
    """Walk from a node to where a leap begins (backwards: from where it ends): its node, or -1.

    With a run-up at walking speed where there is room, else at once, else from rest.
    """
    own, mid = tree.states[node], np.empty(6)
    back = _RUN_UP if tree.backwards else -_RUN_UP
    far = math.hypot(target[0] - own[0], target[1] - own[1]) > 1.5 * _RUN_UP
    for attempt in range(0 if far else 1, 3):
        before = node
        if attempt != 1:
            _beside(space, target, line, back, space.body.v_nom if attempt == 0 else 0.0, mid)
            found, _ = connect(space, tree, node, mid, work.link, work.scratch)
            if found != OK:
                continue
            before = tree.used[0] - 1
        found, _ = connect(space, tree, before, target, work.link, work.scratch)
        if found == OK:
            return tree.used[0] - 1
        if attempt == 1 and far and found != MOTION:
            break
    return -1


@subroutine
def _stop(space, tree, node, state, line, work):
    """Add a place of rest within a run-up behind a leap, the farthest of a few."""
    rest = np.empty(6)
    ahead = -1.0 if tree.backwards else 1.0
    for k in range(3):
        _beside(space, state, line, ahead * _RUN_UP * (1.0 - 0.25 * k), 0.0, rest)
        found, _ = connect(space, tree, node, rest, work.link, work.scratch)
        if found == OK:
            return


@subroutine
def _beside(space, state, line, length, speed, out):
    """The state `length` m further along a line, at nominal height, with a speed along it."""
    out[0], out[1] = state[0] + length * line.cos, state[1] + length * line.sin
    height, along_x, along_y = surface(space.ground, out[0], out[1])
    out[2] = height + space.body.h_nom
    out[3], out[4] = speed * line.cos, speed * line.sin
    out[5] = along_x * out[3] + along_y * out[4]


@kernel
def walk_ahead(space, tree):
    """Walk straight ahead from the start (backwards: into the goal), where turning needs room."""
    work, state = make_work(), np.empty(6)
    root = tree.states[0]
    line = Line(root[0], root[1], math.cos(tree.yaws[0]), math.sin(tree.yaws[0]))
    step = -0.2 if tree.backwards else 0.2
    for k in range(8):
        _beside(space, root, line, step * (k + 1), 0.0, state)
        found, _ = connect(space, tree, 0, state, work.link, work.scratch)
        if found != OK:
            break


@subroutine
def _extend_published(space, tree, node, state, until, rng, work):
    """What the published planner does where CONNECT fails: leaps compete with its valid part."""
    best, least = -1, math.inf
    before = tree.used[0]
    end = _advance(space, tree, node, state, until, work)
    if end >= 0:
        best, least = end, _apart(tree.states[end], state)
    if space.body.leaps:
        leap, at = work.leap, START if tree.backwards else END
        for _ in range(_RANDOM_DRAWS):
            if not random_leap(space, tree.states[node], tree.backwards, rng, leap, work.scratch):
                continue
            away = _apart(leap[at : at + 6], state)
            if away < least:
                tree.used[0] = before
                best, least = add_node(tree, node, leap), away
    if best < 0:
        return TRAPPED, node
    return ADVANCED, best


@subroutine
def _apart(a, b):
    """Distance between states as `nearest` measures it, |dp| + |dv|."""
    shift, speed = 0.0, 0.0
    for k in range(3):
        shift += (a[k] - b[k]) ** 2
        speed += (a[k + 3] - b[k + 3]) ** 2
    return math.sqrt(shift) + math.sqrt(speed)
