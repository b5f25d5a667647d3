"""A tree of primitives: one grows from the start, another one, backwards in time, from the goal."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kernels import subroutine
from cavalcade.kernels.copying import copy_to
from cavalcade.kinodynamic._connect import make_walk, turns_too_fast, walk_heading, walk_problem
from cavalcade.kinodynamic._primitives import edge_yaw
from cavalcade.kinodynamic._validity import may_turn
from cavalcade.kinodynamic.parameters import END, MOTION, OK, SIZE, START


class Tree(NamedTuple):
    """Nodes, of whose `N` places the first `used[0]` are taken.

    Attributes:
        backwards: Whether it grows backwards in time, from the goal.
        states: `(N, 6)`.
        yaws: `(N,)` with which the body arrives or, in a tree from the goal, sets off, rad.
        parents: `(N,)`; -1 of the root.
        edges: `(N, SIZE)` the primitive between parent and node, in forward time.
        used: `(1,)`.
    """

    backwards: bool
    states: Array
    yaws: Array
    parents: NDArray[np.int64]
    edges: Array
    used: NDArray[np.int64]


def make_tree(size: int, backwards: bool, state: Array, yaw: float) -> Tree:
    """A tree of its root alone, with `size` places."""
    tree = Tree(
        backwards,
        np.empty((size, 6)),
        np.empty(size),
        np.empty(size, np.int64),
        np.empty((size, SIZE)),
        np.ones(1, np.int64),
    )
    tree.states[0], tree.yaws[0], tree.parents[0] = state, yaw, -1
    return tree


def enlarged(tree: Tree) -> Tree:
    """The same tree with twice the places."""
    larger: dict[str, Any] = {}
    for name in ("states", "yaws", "parents", "edges"):
        array = getattr(tree, name)
        larger[name] = np.concatenate([array, np.empty_like(array)])
    return tree._replace(**larger)


@subroutine
def add_node(tree, parent, edge):
    """Add the far end of a primitive; returns its number."""
    node = tree.used[0]
    far = START if tree.backwards else END
    copy_to(tree.edges[node], edge)
    copy_to(tree.states[node], edge[far : far + 6])
    tree.yaws[node] = edge_yaw(edge, not tree.backwards)
    tree.parents[node] = parent
    tree.used[0] = node + 1
    return node


@subroutine
def nearest(tree, state):
    """The node with the least |dp| + |dv|."""
    best, least = 0, math.inf
    for i in range(tree.used[0]):
        s = tree.states[i]
        dx, dy, dz = s[0] - state[0], s[1] - state[1], s[2] - state[2]
        apart = math.sqrt(dx * dx + dy * dy + dz * dz)
        if apart < least:
            vx, vy, vz = s[3] - state[3], s[4] - state[4], s[5] - state[5]
            apart += math.sqrt(vx * vx + vy * vy + vz * vz)
            if apart < least:
                best, least = i, apart
    return best


@subroutine
def make_walk_from(space, tree, own, state, edge):
    """Lay a CONNECT out between a tree's state and another one, in the tree's direction of time."""
    if tree.backwards:
        return make_walk(space, state, own, edge)
    return make_walk(space, own, state, edge)


@subroutine
def connect(space, tree, node, state, edge, scratch):
    """Add a CONNECT from a node to a state, in the tree's direction of time, if it is valid.

    Returns:
        What is wrong with it, as `walk_problem`, `OK` if it is the tree's last node now; and the
        time from the node on up to which nothing is, s. The primitive stands in `edge`.
    """
    own = tree.states[node]
    if not make_walk_from(space, tree, own, state, edge) or turns_too_fast(space.body, edge):
        return MOTION, -1.0
    cos, sin = walk_heading(edge, tree.backwards)
    if not may_turn(space, own, tree.yaws[node], math.atan2(sin, cos)):
        return MOTION, -1.0
    found, until = walk_problem(space, edge, tree.backwards, scratch[:6])
    if found == OK:
        add_node(tree, node, edge)
    return found, until
