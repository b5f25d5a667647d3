"""The two trees: one grows from the start, the other one, backwards in time, from the goal."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kinodynamic._stance import (
    STILL,
    make_walk,
    turns_too_fast,
    walk_heading,
    walk_problem,
)
from cavalcade.kinodynamic._turn import turn_on_spot
from cavalcade.kinodynamic.parameters import CONNECT, END, KIND, MOTION, SIZE, START


class Forest(NamedTuple):
    """Nodes of tree 0 (start) and 1 (goal); `used (2,)` of the `N` places are taken.

    Attributes:
        states: `(2, N, 6)`.
        yaws: `(2, N)` with which the body arrives (tree 0) or sets off (tree 1), rad.
        parents: `(2, N)`; -1 of the roots.
        edges: `(2, N, SIZE)` the primitive between parent and node, in forward time.
        used: `(2,)`.
    """

    states: Array
    yaws: Array
    parents: NDArray[np.int64]
    edges: Array
    used: NDArray[np.int64]


def make_forest(size: int, old: Forest | None = None) -> Forest:
    """A forest of `size` places for each tree, with the nodes of an older, smaller one."""
    forest = Forest(
        np.empty((2, size, 6)),
        np.empty((2, size)),
        np.empty((2, size), np.int64),
        np.empty((2, size, SIZE)),
        np.zeros(2, np.int64),
    )
    if old is not None:
        places = old.yaws.shape[1]
        for new, before in zip(forest[:4], old[:4], strict=True):
            new[:, :places] = before
        forest.used[:] = old.used
    return forest


@njit(cache=True)
def plant(forest, tree, state, yaw):
    """The root of a tree."""
    forest.states[tree, 0] = state
    forest.yaws[tree, 0] = yaw
    forest.parents[tree, 0] = -1
    forest.used[tree] = 1


@njit(cache=True)
def attach(forest, tree, parent, edge):
    """Add the far end of a primitive; returns its number."""
    node = forest.used[tree]
    far = END if tree == 0 else START
    for k in range(SIZE):
        forest.edges[tree, node, k] = edge[k]
    for k in range(6):
        forest.states[tree, node, k] = edge[far + k]
    cos, sin = edge_heading(edge, tree == 0)
    forest.yaws[tree, node] = math.atan2(sin, cos)
    forest.parents[tree, node] = parent
    forest.used[tree] = node + 1
    return node


@njit(cache=True)
def edge_heading(edge, last):
    """Cosine and sine of the yaw at the start or, if `last`, the end of a primitive."""
    if edge[KIND] == CONNECT:
        return walk_heading(edge, last)
    at = END if last else START
    speed = math.hypot(edge[at + 3], edge[at + 4])
    return edge[at + 3] / speed, edge[at + 4] / speed


@njit(cache=True)
def nearest(forest, tree, state):
    """The node with the least |dp| + |dv|."""
    best, least = 0, math.inf
    for i in range(forest.used[tree]):
        s = forest.states[tree, i]
        dx, dy, dz = s[0] - state[0], s[1] - state[1], s[2] - state[2]
        way = math.sqrt(dx * dx + dy * dy + dz * dz)
        if way < least:
            vx, vy, vz = s[3] - state[3], s[4] - state[4], s[5] - state[5]
            way += math.sqrt(vx * vx + vy * vy + vz * vz)
            if way < least:
                best, least = i, way
    return best


@njit(cache=True)
def stands_still(state):
    """Whether a body in this state rests and may turn on the spot."""
    return state[3] * state[3] + state[4] * state[4] <= STILL * STILL


@njit(cache=True)
def may_turn(ground, body, discs, state, yaw, cos, sin):
    """Whether a body at rest can turn between a yaw and a direction; a moving one need not."""
    if not stands_still(state):
        return True
    turn = turn_on_spot(
        ground, body, discs, state[0], state[1], state[2], yaw, math.atan2(sin, cos)
    )
    return not math.isnan(turn)


@njit(cache=True)
def try_walk(ground, body, discs, forest, tree, node, state, edge, scratch):
    """CONNECT between a node and a state, in the direction of time of the node's tree.

    Returns:
        What is wrong with it, as `walk_problem`; and the time from the node on up to which
        nothing is, s. The primitive stands in `edge`.
    """
    own = forest.states[tree, node]
    if tree == 0:
        allowed = make_walk(ground, body, own, state, edge)
    else:
        allowed = make_walk(ground, body, state, own, edge)
    if not allowed or turns_too_fast(body, edge):
        return MOTION, -1.0
    cos, sin = walk_heading(edge, tree == 1)
    if not may_turn(ground, body, discs, own, forest.yaws[tree, node], cos, sin):
        return MOTION, -1.0
    return walk_problem(ground, body, discs, edge, tree == 1, scratch[:6])
