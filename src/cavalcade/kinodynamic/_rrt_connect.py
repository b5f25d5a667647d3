"""RRT-Connect: both trees grow by turns, each towards a sample and the other to what it reached."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kernels import kernel, subroutine
from cavalcade.kernels.copying import copy_to
from cavalcade.kinodynamic._tree import Tree, nearest
from cavalcade.kinodynamic._tree_extension import PLACES, REACHED, TRAPPED, extend
from cavalcade.kinodynamic._validity import may_turn, rest_at
from cavalcade.kinodynamic.random import between, normal, uniform
from cavalcade.lattice.surface import surface

SOLVED, SPENT, FULL = 0, 1, 2
"""How a search ends: the trees meet; all iterations are spent; a tree has no room for nodes."""

_MOVING = 0.2
"""Share of samples that move; the others rest, and trees may turn there on the spot."""

_NEARBY, _STUCK = 0.15, 0.7
"""Shares of samples just ahead of a node: as a rule, and for a tree left far behind the other."""

_SPREAD, _BEND = 0.3, 0.6
"""Standard deviations: of the speeds' logarithm, and of the directions ahead of a node, rad."""

_GUIDED, _BESIDE = 0.5, 0.15
"""Share of samples beside the guide, and their standard deviation from it, m."""

_REDRAWS = 30


class Sampler(NamedTuple):
    """How states are sampled.

    Attributes:
        rng: `(1,)` state of the random numbers.
        guide: `(G, 2)` x, y of places beside which half of the samples are, if there are any.
        bound: Only where a path of at most this length may lead, m; infinite for everywhere.
    """

    rng: NDArray[np.uint64]
    guide: Array
    bound: float


@subroutine
def sample_state(space, sampler, tree, other, out):
    """Sample a state `(6,)` at nominal height for a tree; returns the nearest node of it.

    The places are uniform on the map but for those beside the guide and, for a tree that the other
    one has left behind, those just ahead of its nodes.
    """
    ground, body, rng, guide = space.ground, space.body, sampler.rng, sampler.guide
    stuck = 4 * tree.used[0] < other.used[0]
    if not body.published and uniform(rng) < (_STUCK if stuck else _NEARBY):
        return _sample_nearby(space, rng, tree, out)
    rows, cols = ground.solid.shape
    a, b = tree.states[0], other.states[0]
    # The place, once more where the path over it would be too long.
    for _ in range(_REDRAWS):
        if guide.shape[0] > 0 and uniform(rng) < _GUIDED:
            k = int(uniform(rng) * guide.shape[0])
            out[0] = guide[k, 0] + _BESIDE * normal(rng)
            out[1] = guide[k, 1] + _BESIDE * normal(rng)
        else:
            out[0] = between(rng, 0.0, cols * ground.cell)
            out[1] = between(rng, 0.0, rows * ground.cell)
        over = math.hypot(out[0] - a[0], out[1] - a[1]) + math.hypot(out[0] - b[0], out[1] - b[1])
        if over < sampler.bound:
            break
    height, along_x, along_y = surface(ground, out[0], out[1])
    out[2] = height + body.h_nom
    out[3], out[4], out[5] = 0.0, 0.0, 0.0
    near = nearest(tree, out)
    # The velocity of some: about the walking speed, roughly away from the node before it.
    if body.published or uniform(rng) < _MOVING:
        speed = min(body.v_nom * math.exp(_SPREAD * normal(rng)), body.v_max)
        angle = between(rng, -math.pi, math.pi)
        if not body.published:
            own = tree.states[near]
            angle = 0.25 * angle + math.atan2(out[1] - own[1], out[0] - own[0])
            if tree.backwards:
                angle += math.pi
        out[3], out[4] = speed * math.cos(angle), speed * math.sin(angle)
        out[5] = along_x * out[3] + along_y * out[4]
        if body.published:
            near = nearest(tree, out)
    return near


@subroutine
def _sample_nearby(space, rng, tree, out):
    """Sample a place of rest a short way ahead of any node, from which it need not turn far."""
    near = int(uniform(rng) * tree.used[0])
    own = tree.states[near]
    angle = tree.yaws[near] + _BEND * normal(rng)
    ahead = between(rng, 0.15, 0.8)
    if tree.backwards:
        ahead = -ahead
    rest_at(space, own[0] + ahead * math.cos(angle), own[1] + ahead * math.sin(angle), out)
    return near


@kernel(nogil=True)
def search(space, trees, sampler, begin, end):
    """Grow both trees until they meet, from iteration `begin` to the one before `end`.

    Returns:
        `SOLVED`, `SPENT` or `FULL`; the number of the next iteration; and the nodes of both trees
        that meet.
    """
    state = np.empty(6)
    for iteration in range(begin, end):
        tree, other = trees
        if tree.yaws.shape[0] - max(tree.used[0], other.used[0]) < 2 * PLACES:
            return FULL, iteration, -1, -1
        if iteration % 2 == 1:
            other, tree = trees
        if iteration < 2:
            # First straight to the other root.
            node = 0
            copy_to(state, other.states[0])
        else:
            node = sample_state(space, sampler, tree, other, state)
        status, node = extend(space, tree, node, state, sampler.rng)
        if status == TRAPPED:
            continue
        far = 0
        if iteration >= 2 or status != REACHED:
            # What this tree has reached, the other one tries to reach.
            copy_to(state, tree.states[node])
            status, far = extend(space, other, nearest(other, state), state, sampler.rng)
        if status == REACHED and _meet(space, tree, node, other, far):
            first, second = (far, node) if tree.backwards else (node, far)
            return SOLVED, iteration + 1, first, second
    return SPENT, end, -1, -1


@subroutine
def _meet(space, tree, node, other, far):
    """Whether the body can go on from one tree to the other in a state that both have."""
    yaw = other.yaws[far]
    wanted = math.atan2(math.sin(yaw), math.cos(yaw))
    return may_turn(space, tree.states[node], tree.yaws[node], wanted)


def solution(trees: tuple[Tree, Tree], first: int, second: int) -> Array:
    """Primitives `(M, SIZE)` from the start to the goal by the nodes that meet."""
    start, goal = trees
    rows = [start.edges[node] for node in reversed(_ancestry(start, first))]
    return np.array(rows + [goal.edges[node] for node in _ancestry(goal, second)])


def _ancestry(tree: Tree, node: int) -> list[int]:
    """A node and those between it and the root, which is left out."""
    nodes = []
    while tree.parents[node] >= 0:
        nodes.append(node)
        node = int(tree.parents[node])
    return nodes
