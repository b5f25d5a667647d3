"""From primitives to the samples of a trajectory."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.geometry.trajectory import FLIGHT as FLYING
from cavalcade.geometry.trajectory import LANDING, TAKE_OFF, WALK
from cavalcade.kinodynamic._leap import leap_state
from cavalcade.kinodynamic._shortening import edge_duration
from cavalcade.kinodynamic._stance import STILL, walk_state
from cavalcade.kinodynamic._trees import edge_heading, stands_still
from cavalcade.kinodynamic._turn import turn_on_spot, wrapped
from cavalcade.kinodynamic.parameters import CONNECT, END, FLIGHT, KIND, LAND, START, TIME


@njit(cache=True)
def sample(ground, body, discs, edges, begin, yaw):
    """Samples of a way at most dt apart, with the ends of phases.

    Args:
        edges: `(M, SIZE)`.
        begin: `(6,)` state at the start.
        yaw: `(2,)` at the start and the goal, rad.

    Returns:
        Times `(T,)`, states `(T, 6)`, yaws `(T,)` and phases `(T,)`.
    """
    size = 4
    most = 2.0 * math.pi / body.yaw_rate
    for k in range(edges.shape[0]):
        size += int((edge_duration(edges[k]) + most) / body.dt) + 8
    size += int(most / body.dt)
    time, states = np.empty(size), np.empty((size, 6))
    yaws, phases = np.empty(size), np.empty(size, np.int8)
    time[0], yaws[0], phases[0] = 0.0, yaw[0], WALK
    states[0] = begin
    at = 0
    for k in range(edges.shape[0]):
        edge = edges[k]
        if stands_still(edge[START : START + 6]):
            cos, sin = edge_heading(edge, False)
            at = _turn(ground, body, discs, math.atan2(sin, cos), at, time, states, yaws, phases)
        if edge[KIND] == CONNECT:
            at = _stretch(ground, body, edge, 0.0, edge[TIME], WALK, at, time, states, yaws, phases)
        else:
            a = edge[TIME]
            b = a + edge[FLIGHT]
            c = b + edge[LAND]
            at = _stretch(ground, body, edge, 0.0, a, TAKE_OFF, at, time, states, yaws, phases)
            at = _stretch(ground, body, edge, a, b, FLYING, at, time, states, yaws, phases)
            at = _stretch(ground, body, edge, b, c, LANDING, at, time, states, yaws, phases)
            phases[at] = WALK
        for i in range(6):
            states[at, i] = edge[END + i]
    at = _turn(ground, body, discs, yaw[1], at, time, states, yaws, phases)
    phases[at] = WALK
    at += 1
    return time[:at].copy(), states[:at].copy(), yaws[:at].copy(), phases[:at].copy()


@njit(cache=True)
def _turn(ground, body, discs, wanted, at, time, states, yaws, phases):
    """Append samples of a turn on the spot; returns the number of the last one."""
    s = states[at]
    turn = turn_on_spot(ground, body, discs, s[0], s[1], s[2], yaws[at], wanted)
    if math.isnan(turn):
        turn = wrapped(wanted - yaws[at])
    if abs(turn) < 1e-9:
        return at
    span = abs(turn) / body.yaw_rate
    count = max(int(math.ceil(span / body.dt - 1e-9)), 1)
    first = at
    for k in range(1, count + 1):
        at += 1
        time[at] = time[first] + span * k / count
        states[at] = states[first]
        yaws[at] = yaws[first] + turn * k / count
        phases[at - 1] = WALK
    return at


@njit(cache=True)
def _stretch(ground, body, edge, t0, t1, phase, at, time, states, yaws, phases):
    """Append samples of a primitive from t0 to t1; returns the number of the last one."""
    count = max(int(math.ceil((t1 - t0) / body.dt - 1e-9)), 1)
    first = at
    # The state at which a phase begins is that of its primitive, also where speeds jump.
    if t0 == 0.0:
        for i in range(6):
            states[at, i] = edge[START + i]
    for k in range(1, count + 1):
        at += 1
        t = t0 + (t1 - t0) * k / count
        time[at] = time[first] + (t1 - t0) * k / count
        if edge[KIND] == CONNECT:
            walk_state(ground, body, edge, t, states[at])
        else:
            leap_state(edge, t, states[at])
        vx, vy = states[at, 3], states[at, 4]
        if vx * vx + vy * vy > STILL * STILL:
            yaws[at] = yaws[at - 1] + wrapped(math.atan2(vy, vx) - yaws[at - 1])
        elif k == count:
            cos, sin = edge_heading(edge, True)
            yaws[at] = yaws[at - 1] + wrapped(math.atan2(sin, cos) - yaws[at - 1])
        else:
            yaws[at] = yaws[at - 1]
        phases[at - 1] = phase
    return at
