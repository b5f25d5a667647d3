"""Kernel of the search in the product space: RRT-Connect over the poses of all robots at once.

The paper's joint planner, as its text describes it, for any number of robots: what is sampled is
one point of the joint space, the robots' places biased away from each other, and an edge counts
only if no robot meets the ground or, at the same time, another robot. At nodes all robots rest, so
that edges can be driven from either tree.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.boxes import footprints_meet
from cavalcade.kernels import kernel, subroutine
from cavalcade.kernels.copying import copy_rows
from cavalcade.kinodynamic.random import uniform
from cavalcade.lattice.collision import Grid, Margins, Others, Scene, moves_free, pose_free
from cavalcade.lattice.dubins import MOST_MOVES, connect, no_words, take_cheapest
from cavalcade.lattice.motion_limits import footprint_of, member
from cavalcade.lattice.primitives import duration_of, sample_moves

FOUND, SPENT = 0, 2
_TRIES = 20
"""Places tried for each robot of a sample."""

_REACH = 4.0
"""Largest step of a robot in one extension, m."""

_STRIDE = 32
"""Of the first looks at whether robots meet."""


class TeamScene(NamedTuple):
    """A team on its ground: what stays the same for the whole of a search.

    Attributes:
        grid: The ground.
        nobody: `Others` of whom there are none: within the team all is tested by itself.
        team: `(N,)` the robots' limits, see `cavalcade.lattice.motion_limits.member`.
        margins: From the ground and between the robots.
        metre_cost: What a metre costs; a second costs 1.
    """

    grid: Grid
    nobody: Others
    team: NDArray[np.void]
    margins: Margins
    metre_cost: float


class Trees(NamedTuple):
    """Those of the starts and of the goals.

    Attributes:
        nodes: `(2, C, N, 3)` poses of all robots; the roots come first.
        parents: `(2, C)` by number; -1 of the roots.
        counts: `(2,)` nodes.
    """

    nodes: Array
    parents: NDArray[np.int64]
    counts: NDArray[np.int64]


def plant(starts: Array, goals: Array, most: int) -> Trees:
    """The roots alone, poses `(N, 3)`, with room for `most` extensions."""
    nodes = np.empty((2, most + 2, *starts.shape))
    nodes[0, 0], nodes[1, 0] = starts, goals
    return Trees(nodes, np.full((2, most + 2), -1), np.ones(2, dtype=np.int64))


@kernel
def word_between(team, k, a, b):
    """The cheapest word `(M, 6)` of robot `k` from rest at `a` to rest at `b`; whether any."""
    limits = member(team.team, k)
    scene = Scene(team.grid, team.nobody, limits, team.margins, team.metre_cost)
    words = no_words()
    number = connect(a, 0.0, b, 0.0, limits, team.metre_cost, words)
    for _ in range(number):
        pick, count = take_cheapest(words, number)
        word = words.moves[pick, :count]
        if moves_free(scene, (a[0], a[1], a[2]), word, 0.0, False):
            return word.copy(), True
    return words.moves[0, :0].copy(), False


@kernel
def edge_free(team, a, b):
    """Whether all robots get from poses `a` to `b` `(N, 3)` at once."""
    n = len(team.team)
    # Each alone first.
    longest = 0.0
    moves = np.zeros((n, MOST_MOVES, 6))
    sizes = np.zeros(n, dtype=np.int64)
    for k in range(n):
        rows, good = word_between(team, k, a[k], b[k])
        if not good:
            return False
        sizes[k] = len(rows)
        copy_rows(moves[k], rows)
        longest = max(longest, duration_of(rows))
    # Then all against all, at the same times.
    step = team.margins.time_step
    count = int(math.ceil(longest / step)) + 1
    # Few looks first: who meets is mostly seen in them.
    for stride in (_STRIDE, 1):
        looks = (count - 1) // stride + 1
        times = np.empty(looks)
        for i in range(looks):
            times[i] = min(i * stride * step, longest)
        tracks = np.empty((n, looks, 6))
        for k in range(n):
            track = sample_moves(a[k], moves[k, : sizes[k]], member(team.team, k), times)
            copy_rows(tracks[k], track)
        for i in range(looks):
            for j in range(n):
                one = footprint_of(member(team.team, j))
                here = (tracks[j, i, 0], tracks[j, i, 1], tracks[j, i, 2])
                for k in range(j):
                    other = footprint_of(member(team.team, k))
                    there = (tracks[k, i, 0], tracks[k, i, 1], tracks[k, i, 2])
                    if footprints_meet(one, here, other, there, team.margins.others):
                        return False
    return True


@subroutine
def _sample(team, rng, out):
    """One point of the joint space: free places, each later one away from the earlier ones."""
    cell, solid = team.grid.cell, team.grid.solid
    height, width = solid.shape[0] * cell, solid.shape[1] * cell
    for k in range(len(team.team)):
        footprint = footprint_of(member(team.team, k))
        best = -1.0
        for _ in range(_TRIES):
            x, y = uniform(rng) * width, uniform(rng) * height
            yaw = (2.0 * uniform(rng) - 1.0) * math.pi
            if not pose_free(team.grid, footprint, x, y, yaw, 0.0):
                continue
            gap = math.inf
            for j in range(k):
                away = math.sqrt((x - out[j, 0]) ** 2 + (y - out[j, 1]) ** 2)
                gap = min(gap, away - team.team[j].half_length - footprint.half_length)
            if gap > best:
                best = gap
                out[k, 0], out[k, 1], out[k, 2] = x, y, yaw
            if best > 2.0 * footprint.half_length:
                break
        if best < 0.0:
            return False
    return True


@subroutine
def _nearest(nodes, count, point):
    """The node whose robots are nearest to those of a point, by the sum of their distances."""
    best, least = 0, math.inf
    for i in range(count):
        total = 0.0
        for k in range(point.shape[0]):
            total += math.sqrt(
                (nodes[i, k, 0] - point[k, 0]) ** 2 + (nodes[i, k, 1] - point[k, 1]) ** 2
            )
        if total < least:
            best, least = i, total
    return best


@subroutine
def _towards(node, point, share, forward, out):
    """Poses between a node and a point, headed towards it (`forward`) or away from it."""
    for k in range(len(node)):
        dx, dy = point[k, 0] - node[k, 0], point[k, 1] - node[k, 1]
        gap = math.sqrt(dx * dx + dy * dy)
        part = share * min(1.0, _REACH / max(gap, 1e-9))
        out[k, 0], out[k, 1] = node[k, 0] + part * dx, node[k, 1] + part * dy
        out[k, 2] = math.atan2(dy, dx) if forward else math.atan2(-dy, -dx)


@kernel(nogil=True)
def search_joint(team, trees, rng, begin, end):
    """Grow two trees of poses of all robots from extension `begin` to `end` or until they meet.

    Returns:
        FOUND or SPENT; poses `(M, N, 3)`, starts and goals included, at which all stop on their
        paths; extensions so far.
    """
    nodes, parents, counts = trees
    n = len(team.team)
    if begin == 0 and edge_free(team, nodes[0, 0], nodes[1, 0]):
        direct = np.empty((2, n, 3))
        copy_rows(direct[0], nodes[0, 0])
        copy_rows(direct[1], nodes[1, 0])
        return FOUND, direct, 1
    point = np.empty((n, 3))
    fresh = np.empty((n, 3))
    # The trees take turns: one is extended towards a sample, then joined with the other.
    for extension in range(begin, end):
        mine = extension % 2
        other = 1 - mine
        if not _sample(team, rng, point):
            continue
        near = _nearest(nodes[mine], counts[mine], point)
        extended = False
        for share in (1.0, 0.5, 0.25):
            _towards(nodes[mine, near], point, share, mine == 0, fresh)
            # Edges lead away from the first tree's root and towards the second one's.
            a, b = (nodes[mine, near], fresh) if mine == 0 else (fresh, nodes[mine, near])
            extended = edge_free(team, a, b)
            if extended:
                break
        if not extended:
            continue
        at = counts[mine]
        copy_rows(nodes[mine, at], fresh)
        parents[mine, at] = near
        counts[mine] += 1
        there = _nearest(nodes[other], counts[other], fresh)
        a, b = (fresh, nodes[other, there]) if mine == 0 else (nodes[other, there], fresh)
        if edge_free(team, a, b):
            first, last = (at, there) if mine == 0 else (there, at)
            return FOUND, _path(nodes, parents, first, last), extension + 1
    return SPENT, np.empty((0, n, 3)), end


@subroutine
def _path(nodes, parents, first, last):
    """From the root of the first tree over the two nodes to the root of the second tree."""
    ahead, behind = 0, 0
    path = np.empty((2 * nodes.shape[1], nodes.shape[2], 3))
    # The first tree's part is written from the middle back, the second one's from there on.
    middle = nodes.shape[1]
    while first >= 0:
        ahead += 1
        copy_rows(path[middle - ahead], nodes[0, first])
        first = parents[0, first]
    while last >= 0:
        copy_rows(path[middle + behind], nodes[1, last])
        behind += 1
        last = parents[1, last]
    return path[middle - ahead : middle + behind].copy()
