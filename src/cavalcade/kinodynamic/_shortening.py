"""Shorter paths: string pulling on the grid's path, the farthest CONNECTs, shortcuts, no stops.

A path is its primitives `(M, SIZE)`; `yaw (2,)` is that of the start and that of the goal, rad.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel, subroutine
from cavalcade.kernels.copying import copy_rows, copy_to
from cavalcade.kinodynamic._connect import (
    make_walk,
    some_state_invalid,
    turns_too_fast,
    walk_problem,
    walk_state,
)
from cavalcade.kinodynamic._primitives import edge_heading, edge_length, edge_yaw, path_length
from cavalcade.kinodynamic._validity import may_turn, rest_at, stands_still
from cavalcade.kinodynamic.parameters import CONNECT, END, KIND, OK, SIZE, START, TIME
from cavalcade.kinodynamic.random import uniform
from cavalcade.lattice.surface import surface

_LONGER = 1.003
"""A path without a stop may be this much longer than one with it."""


@subroutine
def _arrival(edges, k, yaw):
    """Yaw with which the body arrives where primitive `k` of a path begins, rad."""
    return edge_yaw(edges[k - 1], True) if k > 0 else yaw[0]


@subroutine
def _departure(edges, k, yaw):
    """Yaw with which the body sets off where primitive `k` of a path begins, rad."""
    if k < edges.shape[0]:
        return edge_yaw(edges[k], False)
    return math.atan2(math.sin(yaw[1]), math.cos(yaw[1]))


@subroutine
def _joined(space, edge, arrival, departure):
    """Whether a body can turn from a yaw before a primitive and to one after it, where it rests.

    Both in rad; nan where any will do.
    """
    if not may_turn(space, edge[START : START + 6], arrival, edge_yaw(edge, False)):
        return False
    if math.isnan(departure):
        return True
    return may_turn(space, edge[END : END + 6], edge_yaw(edge, True), departure)


@subroutine
def _valid_walk(space, s0, s1, arrival, departure, edge, scratch):
    """Lay a CONNECT out between states of a path; whether it is valid there, see `_joined`."""
    if not make_walk(space, s0, s1, edge) or turns_too_fast(space.body, edge):
        return False
    if some_state_invalid(space, edge, scratch):
        return False
    if not _joined(space, edge, arrival, departure):
        return False
    return walk_problem(space, edge, False, scratch)[0] == OK


@kernel(nogil=True)
def pull_string(space, points, yaw):
    """Walks from rest to rest along straight lines between points `(K, 2)` of a path.

    Each is as long as it can be found by doubling and halving. There are none if two neighbouring
    points cannot be joined so.
    """
    last = points.shape[0] - 1
    edges = np.empty((last, SIZE))
    edge, scratch = np.empty(SIZE), np.empty(6)
    begin, end = np.empty(6), np.empty(6)
    rest_at(space, points[0, 0], points[0, 1], begin)
    at, kept = 0, 0
    while at < last:
        # The walk reaches `good` and not `bad`; steps grow until there is one that it does not.
        good, bad, step = at, last + 1, 1
        arrival = _arrival(edges, kept, yaw)
        while bad - good > 1 and good < last:
            to = min(at + step, last) if bad > last else (good + bad) // 2
            rest_at(space, points[to, 0], points[to, 1], end)
            departure = _departure(edges, last, yaw) if to == last else math.nan
            if _valid_walk(space, begin, end, arrival, departure, edge, scratch):
                good = to
                copy_to(edges[kept], edge)
                step *= 4
            else:
                bad = to
        if good == at:
            return edges[:0].copy()
        at = good
        copy_to(begin, edges[kept, END : END + 6])
        kept += 1
    return edges[:kept].copy()


@kernel(nogil=True)
def shorten(space, edges, yaw):
    """From the start on, CONNECTs to the farthest later states where they are shorter."""
    count = edges.shape[0]
    out = np.empty((count, SIZE))
    edge, scratch = np.empty(SIZE), np.empty(6)
    lengths = np.empty(count + 1)
    lengths[0] = 0.0
    for k in range(count):
        lengths[k + 1] = lengths[k] + edge_length(space, edges[k])
    kept, i = 0, 0
    while i < count:
        arrival = _arrival(out, kept, yaw)
        found = False
        for j in range(count, i + 1, -1):
            departure = _departure(edges, j, yaw)
            s0, s1 = edges[i, START : START + 6], edges[j - 1, END : END + 6]
            if not _valid_walk(space, s0, s1, arrival, departure, edge, scratch):
                continue
            if edge_length(space, edge) > lengths[j] - lengths[i] - 1e-6:
                continue
            copy_to(out[kept], edge)
            i, found = j, True
            break
        if not found:
            copy_to(out[kept], edges[i])
            i += 1
        kept += 1
    return out[:kept].copy()


@kernel(nogil=True)
def shortcut(space, rng, edges, yaw):
    """The path with a CONNECT between two random places if that is shorter; and whether it is."""
    count = edges.shape[0]
    i, j = int(uniform(rng) * count), int(uniform(rng) * count)
    a, b = uniform(rng), uniform(rng)
    if i > j:
        i, j, a, b = j, i, b, a
    if i == j or edges[i, KIND] != CONNECT or edges[j, KIND] != CONNECT:
        return edges, False
    scratch, s0, s1 = np.empty(6), np.empty(6), np.empty(6)
    first, middle, last = edges[i].copy(), np.empty(SIZE), edges[j].copy()
    _place(space, edges[i], a, s0)
    _place(space, edges[j], b, s1)
    if not _part(space, first, s0, True, a) or not _part(space, last, s1, False, b):
        return edges, False
    arrival, departure = edge_yaw(first, True), edge_yaw(last, False)
    if not _valid_walk(space, s0, s1, arrival, departure, middle, scratch):
        return edges, False
    # It is shorter, and what is left of the primitives that it cuts fits to their neighbours.
    old = path_length(space, edges[i : j + 1])
    new = edge_length(space, first) + edge_length(space, middle)
    if new + edge_length(space, last) > old - 1e-4:
        return edges, False
    if not _joined(space, first, _arrival(edges, i, yaw), edge_yaw(middle, False)):
        return edges, False
    if not _joined(space, last, edge_yaw(middle, True), _departure(edges, j + 1, yaw)):
        return edges, False
    out = np.empty((i + 1 + 1 + count - j, SIZE))
    copy_rows(out, edges[:i])
    copy_to(out[i], first)
    copy_to(out[i + 1], middle)
    copy_to(out[i + 2], last)
    copy_rows(out[i + 3 :], edges[j + 1 :])
    return out, True


@subroutine
def _place(space, edge, part, out):
    """A state on a CONNECT: at rest if it leads from rest to rest along a line, else as it is."""
    walk_state(space, edge, part * edge[TIME], out)
    if stands_still(edge[START : START + 6]) and stands_still(edge[END : END + 6]):
        rest_at(space, out[0], out[1], out)


@subroutine
def _part(space, edge, state, first, part):
    """Keep a CONNECT up to a state on it or, unless `first`, from there on."""
    at = END if first else START
    if stands_still(state):
        if first:
            return make_walk(space, edge[START : START + 6].copy(), state, edge)
        return make_walk(space, state, edge[END : END + 6].copy(), edge)
    share = part if first else 1.0 - part
    if share * edge[TIME] < space.body.dt:
        return False
    copy_to(edge[at:], state)
    edge[TIME] *= share
    return True


@kernel
def round_corners(space, edges, yaw):
    """Walk through places of rest between CONNECTs where that is hardly any longer, in place."""
    v_nom = space.body.v_nom
    scratch, state = np.empty(6), np.empty(6)
    first, last = np.empty(SIZE), np.empty(SIZE)
    for i in range(edges.shape[0] - 1):
        if edges[i, KIND] != CONNECT or edges[i + 1, KIND] != CONNECT:
            continue
        copy_to(state, edges[i, END : END + 6])
        if not stands_still(state):
            continue
        # Through the same place in the direction between both walks, unless they nearly oppose.
        c0, s0 = edge_heading(edges[i], True)
        c1, s1 = edge_heading(edges[i + 1], False)
        cos, sin = c0 + c1, s0 + s1
        norm = math.hypot(cos, sin)
        if norm < 0.5:
            continue
        begin, end = edges[i, START : START + 6], edges[i + 1, END : END + 6]
        arrival, departure = _arrival(edges, i, yaw), _departure(edges, i + 2, yaw)
        old = edge_length(space, edges[i]) + edge_length(space, edges[i + 1])
        along = surface(space.ground, state[0], state[1])
        for speed in (v_nom, 0.6 * v_nom, 0.3 * v_nom):
            state[3], state[4] = speed * cos / norm, speed * sin / norm
            state[5] = along[1] * state[3] + along[2] * state[4]
            # The second walk's forces are looked at first: that costs least.
            if not make_walk(space, state, end, last) or turns_too_fast(space.body, last):
                continue
            if not _valid_walk(space, begin, state, arrival, math.nan, first, scratch):
                continue
            if not _valid_walk(space, state, end, math.nan, departure, last, scratch):
                continue
            new = edge_length(space, first) + edge_length(space, last)
            if new <= _LONGER * old:
                copy_to(edges[i], first)
                copy_to(edges[i + 1], last)
                break
