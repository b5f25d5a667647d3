"""What walks and leaps have in common: duration, states, heading, length."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel, subroutine
from cavalcade.kinodynamic._connect import is_level, is_straight, walk_heading, walk_state
from cavalcade.kinodynamic._leap import leap_duration, leap_state
from cavalcade.kinodynamic.parameters import CONNECT, END, KIND, START, TIME


@subroutine
def edge_duration(edge):
    """Duration of a primitive, s."""
    return edge[TIME] if edge[KIND] == CONNECT else leap_duration(edge)


@subroutine
def edge_heading(edge, last):
    """Cosine and sine of the yaw at the start or, if `last`, the end of a primitive."""
    if edge[KIND] == CONNECT:
        return walk_heading(edge, last)
    at = END if last else START
    speed = math.hypot(edge[at + 3], edge[at + 4])
    return edge[at + 3] / speed, edge[at + 4] / speed


@subroutine
def edge_yaw(edge, last):
    """Yaw at the start or, if `last`, the end of a primitive, rad."""
    cos, sin = edge_heading(edge, last)
    return math.atan2(sin, cos)


@subroutine
def edge_length(space, edge):
    """Length of the body centre's path in space, sampled every dt, m."""
    span = edge_duration(edge)
    if edge[KIND] == CONNECT and is_level(space.ground, edge) and is_straight(edge):
        return math.hypot(edge[END] - edge[START], edge[END + 1] - edge[START + 1])
    count = max(int(math.ceil(span / space.body.dt - 1e-9)), 1)
    state = np.empty(6)
    x, y, z = edge[START], edge[START + 1], edge[START + 2]
    total = 0.0
    for k in range(1, count + 1):
        if edge[KIND] == CONNECT:
            walk_state(space, edge, span * k / count, state)
        else:
            leap_state(edge, span * k / count, state)
        total += math.sqrt((state[0] - x) ** 2 + (state[1] - y) ** 2 + (state[2] - z) ** 2)
        x, y, z = state[0], state[1], state[2]
    return total


@kernel
def path_length(space, edges):
    """Length of a path of primitives `(M, SIZE)`, m."""
    total = 0.0
    for k in range(edges.shape[0]):
        total += edge_length(space, edges[k])
    return total
