"""Conflict-based search (CBS) for body trajectories (the paper's Algorithm 4).

A node of the tree holds a path for each robot and what each has to avoid. The cheapest node is
taken; if two of its paths conflict, one child has the first robot avoid the second one's body
while they were in conflict, the other child the reverse. Bounded-complete at best: paths come
from a search with steps, and constraints are bodies over time, as in Kottinger et al., IROS 2022.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count

from cavalcade.coordination.conflicts import Conflict, conflicts_of
from cavalcade.coordination.joint import solve_joint
from cavalcade.coordination.problem import PlanSettings
from cavalcade.coordination.robot_planner import Span, TeamSearch
from cavalcade.coordination.solution import Paths, Solution, total_cost
from cavalcade.lattice.planner import TRACK_STEP

_PAD = 0.5
"""A constraint holds this long before and after the conflict, s."""

_LENIENT = 2
"""So often two robots may conflict on a branch before one has to avoid the other's whole path."""

_MERGE = 6
"""After so many conflicts of two robots on a branch they are planned as one."""

_EARLY = 3.0
"""Conflicts before this are about leaving the starts, s."""

_PAIRS = 3
"""So many pairs in conflict are looked at to find the most telling conflict."""

_MOST_NODES = 400
"""Nodes of the tree at most."""


@dataclass(frozen=True, eq=False)
class _Node:
    paths: Paths
    avoid: tuple[tuple[Span, ...], ...]
    conflicts: list[Conflict]
    met: Mapping[tuple[int, int], int]

    @property
    def cost(self) -> float:
        return total_cost(self.paths)


def conflict_search(search: TeamSearch, root: Paths, merging: bool = False) -> Solution:
    """Resolve the conflicts of paths that were planned regardless of each other.

    If `merging`, two robots that keep conflicting are planned as one, regardless of the others;
    else they are left to constraints.
    """
    planner, settings, budget = search.planner, search.settings, search.budget
    problem = planner.problem
    order = count()

    def node(
        paths: Paths,
        avoid: tuple[tuple[Span, ...], ...],
        met: Mapping[tuple[int, int], int],
    ) -> _Node:
        tracks = [path.track for path in paths]
        found = conflicts_of(tracks, problem.models, distance=settings.distance)
        return _Node(paths, avoid, found, met)

    def child(parent: _Node, conflict: Conflict, robot: int, other: int) -> _Node | None:
        pair = (conflict.i, conflict.j)
        met = {**parent.met, pair: parent.met.get(pair, 0) + 1}
        spans = _constraint(parent, conflict, other, settings, met[pair] > _LENIENT)
        avoid = (*parent.avoid[robot], *spans)
        paths, avoids = list(parent.paths), list(parent.avoid)
        path = planner.plan(robot, avoid, budget)
        if path is None and conflict.begin < _EARLY:
            # The other one's path leads over this one's start. Let this one leave past where the
            # other one stands, and the other one avoid all of that.
            stay = Span(other, planner.standing(other), 0.0, _EARLY)
            avoid = (*parent.avoid[robot], stay)
            path = planner.plan(robot, avoid, budget)
            if path is not None:
                avoids[other] = (*parent.avoid[other], Span(robot, path.track))
                giving_way = planner.plan(other, avoids[other], budget)
                if giving_way is None:
                    return None
                paths[other] = giving_way
        if path is None:
            return None
        paths[robot], avoids[robot] = path, avoid
        return node(tuple(paths), tuple(avoids), met)

    def merged(parent: _Node, conflict: Conflict) -> list[_Node]:
        pair = (conflict.i, conflict.j)
        together = solve_joint(problem.part(pair), search.lattice, budget, search.rng)
        if together is None:
            return []
        paths, avoids = list(parent.paths), list(parent.avoid)
        for robot, path in zip(pair, together, strict=True):
            paths[robot], avoids[robot] = path, ()
        return [node(tuple(paths), tuple(avoids), {**parent.met, pair: 0})]

    def children(parent: _Node) -> list[_Node]:
        best: list[_Node] = []
        least = -math.inf
        for conflict in _choice(parent.conflicts, settings.conflict):
            if merging and parent.met.get((conflict.i, conflict.j), 0) >= _MERGE:
                together = merged(parent, conflict)
                if together:
                    return together
            made = [
                child(parent, conflict, conflict.i, conflict.j),
                child(parent, conflict, conflict.j, conflict.i),
            ]
            found = [one for one in made if one is not None]
            gain = min((one.cost for one in found), default=math.inf) - parent.cost
            # A conflict with a single way out says more than one with two.
            gain += (2 - len(found)) * 1e6
            if gain > least:
                best, least = found, gain
            if budget.spent:
                break
        return best

    first = node(root, tuple(() for _ in root), {})
    queue = [(first.cost, len(first.conflicts), next(order), first)]
    nodes = 0
    last = first
    while queue and nodes < _MOST_NODES and not budget.spent:
        _, _, _, last = heapq.heappop(queue)
        nodes += 1
        if not last.conflicts:
            return Solution(last.paths, True, "cbs", {"conflict_nodes": nodes})
        for made in children(last):
            heapq.heappush(queue, (made.cost, len(made.conflicts), next(order), made))
    return Solution(last.paths, False, "cbs", {"conflict_nodes": nodes})


def _choice(conflicts: list[Conflict], rule: str) -> list[Conflict]:
    """The conflicts to branch on: one, or for `costly` the earliest ones of some pairs."""
    if rule == "first":
        return [min(conflicts, key=lambda c: (c.i, c.j, c.begin))]
    if rule == "earliest":
        return conflicts[:1]
    pairs: dict[tuple[int, int], Conflict] = {}
    for conflict in conflicts:
        pairs.setdefault((conflict.i, conflict.j), conflict)
    return list(pairs.values())[:_PAIRS]


def _constraint(
    node: _Node, conflict: Conflict, other: int, settings: PlanSettings, whole: bool
) -> list[Span]:
    """What the robot that gives way has to avoid."""
    track = node.paths[other].track
    if settings.constraints == "static":
        first = min(int(conflict.begin / TRACK_STEP), len(track) - 1)
        last = len(track) if conflict.end == math.inf else int(conflict.end / TRACK_STEP) + 1
        poses = track[first : max(last, first + 1) : 5]
        return [Span(other, pose[None]) for pose in poses]
    if whole:
        return [Span(other, track)]
    return [Span(other, track, conflict.begin - _PAD, conflict.end + _PAD)]
