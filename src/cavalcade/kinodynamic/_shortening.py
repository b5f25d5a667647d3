"""Shorter ways: CONNECT to the farthest later state, shortcuts, no needless stops."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.kinodynamic._leap import leap_duration, leap_state
from cavalcade.kinodynamic._stance import (
    is_level,
    is_straight,
    make_walk,
    turns_too_fast,
    walk_meets_something,
    walk_problem,
    walk_state,
)
from cavalcade.kinodynamic._trees import edge_heading, may_turn, stands_still
from cavalcade.kinodynamic.parameters import CONNECT, END, KIND, OK, SIZE, START, TIME
from cavalcade.kinodynamic.random import uniform
from cavalcade.lattice.surface import surface

_LONGER = 1.003
"""A way without a stop may be this much longer than one with it."""


@njit(cache=True)
def edge_duration(edge):
    """Duration of a primitive, s."""
    return edge[TIME] if edge[KIND] == CONNECT else leap_duration(edge)


@njit(cache=True)
def edge_state(ground, body, edge, t, out):
    """State `(6,)` of a primitive at time `t` after its start."""
    if edge[KIND] == CONNECT:
        walk_state(ground, body, edge, t, out)
    else:
        leap_state(edge, t, out)


@njit(cache=True)
def edge_length(ground, body, edge):
    """Length of the way of the body's centre in space, sampled every dt, m."""
    span = edge_duration(edge)
    if edge[KIND] == CONNECT and is_level(ground, edge) and is_straight(edge):
        return math.hypot(edge[END] - edge[START], edge[END + 1] - edge[START + 1])
    count = max(int(math.ceil(span / body.dt - 1e-9)), 1)
    state = np.empty(6)
    x, y, z = edge[START], edge[START + 1], edge[START + 2]
    total = 0.0
    for k in range(1, count + 1):
        edge_state(ground, body, edge, span * k / count, state)
        total += math.sqrt((state[0] - x) ** 2 + (state[1] - y) ** 2 + (state[2] - z) ** 2)
        x, y, z = state[0], state[1], state[2]
    return total


@njit(cache=True)
def total_length(ground, body, edges):
    """Length of a way of primitives `(M, SIZE)`, m."""
    total = 0.0
    for k in range(edges.shape[0]):
        total += edge_length(ground, body, edges[k])
    return total


@njit(cache=True)
def joined(ground, body, discs, before, after, yaw, edge):
    """Whether a body can turn from one primitive to the next one where it rests between them.

    Args:
        before, after: The primitives around `edge`; those of kind -1 are none.
        yaw: `(2,)` at the start and the goal, used where there is none.
        edge: Checked against both.
    """
    cos, sin = edge_heading(edge, False)
    if before[KIND] < 0.0:
        arrival = yaw[0]
    else:
        c, s = edge_heading(before, True)
        arrival = math.atan2(s, c)
    if not may_turn(ground, body, discs, edge[START : START + 6], arrival, cos, sin):
        return False
    cos, sin = edge_heading(edge, True)
    if after[KIND] < 0.0:
        c, s = math.cos(yaw[1]), math.sin(yaw[1])
    else:
        c, s = edge_heading(after, False)
    return may_turn(ground, body, discs, edge[END : END + 6], math.atan2(sin, cos), c, s)


@njit(cache=True)
def valid_walk(ground, body, discs, s0, s1, before, after, yaw, edge, scratch):
    """Lay a CONNECT out between states of a way; whether it is valid there."""
    if not make_walk(ground, body, s0, s1, edge) or turns_too_fast(body, edge):
        return False
    if walk_meets_something(ground, body, discs, edge, scratch):
        return False
    if not joined(ground, body, discs, before, after, yaw, edge):
        return False
    return walk_problem(ground, body, discs, edge, False, scratch)[0] == OK


@njit(cache=True)
def shorten(ground, body, discs, edges, yaw):
    """The way with CONNECTs to the farthest later states that can be reached so, from the start on.

    Args:
        edges: `(M, SIZE)`.
        yaw: `(2,)` at the start and the goal.

    Returns:
        `(K, SIZE)` with K <= M.
    """
    count = edges.shape[0]
    out = np.empty((count, SIZE))
    edge, scratch, none = np.empty(SIZE), np.empty(6), np.full(SIZE, -1.0)
    lengths = np.empty(count + 1)
    lengths[0] = 0.0
    for k in range(count):
        lengths[k + 1] = lengths[k] + edge_length(ground, body, edges[k])
    kept, i = 0, 0
    while i < count:
        before = out[kept - 1] if kept > 0 else none
        found = False
        for j in range(count, i + 1, -1):
            after = edges[j] if j < count else none
            s0, s1 = edges[i, START : START + 6], edges[j - 1, END : END + 6]
            if not valid_walk(ground, body, discs, s0, s1, before, after, yaw, edge, scratch):
                continue
            if edge_length(ground, body, edge) > lengths[j] - lengths[i] - 1e-6:
                continue
            out[kept] = edge
            i, found = j, True
            break
        if not found:
            out[kept] = edges[i]
            i += 1
        kept += 1
    return out[:kept].copy()


@njit(cache=True)
def shortcut(ground, body, discs, rng, edges, yaw):
    """Try a CONNECT between two random places of the way.

    Returns:
        The way, changed if that made it shorter, and whether it did.
    """
    count = edges.shape[0]
    i, j = int(uniform(rng) * count), int(uniform(rng) * count)
    a, b = uniform(rng), uniform(rng)
    if i > j:
        i, j, a, b = j, i, b, a
    if i == j or edges[i, KIND] != CONNECT or edges[j, KIND] != CONNECT:
        return edges, False
    none, scratch = np.full(SIZE, -1.0), np.empty(6)
    s0, s1 = np.empty(6), np.empty(6)
    first, middle, last = edges[i].copy(), np.empty(SIZE), edges[j].copy()
    before = edges[i - 1] if i > 0 else none
    after = edges[j + 1] if j + 1 < count else none
    _place(ground, body, edges[i], a, s0)
    _place(ground, body, edges[j], b, s1)
    if not _part(ground, body, first, s0, True, a) or not _part(ground, body, last, s1, False, b):
        return edges, False
    if not valid_walk(ground, body, discs, s0, s1, first, last, yaw, middle, scratch):
        return edges, False
    old = total_length(ground, body, edges[i : j + 1])
    new = edge_length(ground, body, first) + edge_length(ground, body, middle)
    if new + edge_length(ground, body, last) > old - 1e-4:
        return edges, False
    if not joined(ground, body, discs, before, middle, yaw, first):
        return edges, False
    if not joined(ground, body, discs, middle, after, yaw, last):
        return edges, False
    out = np.empty((i + 1 + 1 + count - j, SIZE))
    out[:i] = edges[:i]
    out[i], out[i + 1], out[i + 2] = first, middle, last
    out[i + 3 :] = edges[j + 1 :]
    return out, True


@njit(cache=True)
def _place(ground, body, edge, part, out):
    """A state on a CONNECT: at rest if it leads from rest to rest along a line, else as it is."""
    walk_state(ground, body, edge, part * edge[TIME], out)
    if stands_still(edge[START : START + 6]) and stands_still(edge[END : END + 6]):
        out[2] = surface(ground, out[0], out[1])[0] + body.h_nom
        out[3], out[4], out[5] = 0.0, 0.0, 0.0


@njit(cache=True)
def _part(ground, body, edge, state, first, part):
    """Keep a CONNECT up to a state on it or, unless `first`, from there on."""
    at = END if first else START
    if stands_still(state):
        if first:
            return make_walk(ground, body, edge[START : START + 6].copy(), state, edge)
        return make_walk(ground, body, state, edge[END : END + 6].copy(), edge)
    share = part if first else 1.0 - part
    if share * edge[TIME] < body.dt:
        return False
    for k in range(6):
        edge[at + k] = state[k]
    edge[TIME] *= share
    return True


@njit(cache=True)
def round_corners(ground, body, discs, edges, yaw):
    """Walk through places of rest between two CONNECTs where that is hardly any longer, in place.

    Returns:
        How many are gone.
    """
    count = edges.shape[0]
    none, scratch = np.full(SIZE, -1.0), np.empty(6)
    state, first, last = np.empty(6), np.empty(SIZE), np.empty(SIZE)
    gone = 0
    for i in range(count - 1):
        if edges[i, KIND] != CONNECT or edges[i + 1, KIND] != CONNECT:
            continue
        for k in range(6):
            state[k] = edges[i, END + k]
        if not stands_still(state):
            continue
        c0, s0 = edge_heading(edges[i], True)
        c1, s1 = edge_heading(edges[i + 1], False)
        cos, sin = c0 + c1, s0 + s1
        norm = math.hypot(cos, sin)
        if norm < 0.5:
            continue
        before = edges[i - 1] if i > 0 else none
        after = edges[i + 2] if i + 2 < count else none
        old = edge_length(ground, body, edges[i]) + edge_length(ground, body, edges[i + 1])
        along = surface(ground, state[0], state[1])
        for speed in (body.v_nom, 0.6 * body.v_nom, 0.3 * body.v_nom):
            state[3], state[4] = speed * cos / norm, speed * sin / norm
            state[5] = along[1] * state[3] + along[2] * state[4]
            begin, end = edges[i, START : START + 6], edges[i + 1, END : END + 6]
            if not make_walk(ground, body, state, end, last) or turns_too_fast(body, last):
                continue
            if not valid_walk(ground, body, discs, begin, state, before, none, yaw, first, scratch):
                continue
            if not valid_walk(ground, body, discs, state, end, none, after, yaw, last, scratch):
                continue
            new = edge_length(ground, body, first) + edge_length(ground, body, last)
            if new <= _LONGER * old:
                edges[i], edges[i + 1] = first, last
                gone += 1
                break
    return gone
