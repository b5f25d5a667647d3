"""All robots at once: RRT-Connect in the product space (the paper's section III-C, its text).

For any number of robots, though slow for many. What the trees find stops at each node; afterwards
each robot's path is shortened in space and time among those of the others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from itertools import combinations

import numpy as np

from cavalcade.coordination._joint import (
    FOUND,
    SPENT,
    TeamScene,
    Trees,
    edge_free,
    plant,
    search_joint,
    word_between,
)
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.problem import TeamProblem
from cavalcade.coordination.robot_planner import Span, TeamSearch, others_among, spans_of
from cavalcade.coordination.solution import Paths, RobotPath, total_cost
from cavalcade.geometry import Array
from cavalcade.geometry.boxes import footprints_meet
from cavalcade.lattice.collision import Margins, pose_free
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.ground import make_ground
from cavalcade.lattice.motion_limits import footprint, metre_cost, motion_limits, team_limits
from cavalcade.lattice.planner import FOOTING, MARGINS, NOBODY, SpaceTimePlanner, TimedPath
from cavalcade.lattice.primitives import DURATION
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

_ATTEMPT = 200
"""Extensions of the trees before they are planted anew; twice as many every time."""

_ITERATIONS = 30
"""Iterations of the budget that one robot's part of an extension costs, about as long as these."""

_LONGEST = 3200
"""Extensions of one attempt at most."""

_TURN = math.pi / 8.0
"""Who cannot turn by this to both sides drives straight away first, rad."""

_LEADS = (1.0, 0.5, 0.25)
"""How far, m."""

_AGAIN = 6
"""So many further searches for a cheaper plan."""

_ROUNDS = 3
"""How often each path is shortened among the others."""


def solve_joint(
    problem: TeamProblem,
    lattice: SpaceTimePlanner,
    budget: Budget,
    rng: np.random.Generator,
    polish: bool = True,
) -> Paths | None:
    """Paths without conflicts, or None if the budget was spent first.

    They are shortened afterwards if `polish` says so; the paper's planner does not.
    """
    with budget.deadline.paused():
        _get_ready()
    state = rng.integers(0, 2**63, size=1, dtype=np.int64).astype(np.uint64)
    limits = [motion_limits(model) for model in problem.models]
    mean_speed = float(np.cumsum([robot.speed for robot in limits])[-1] / len(limits))
    starts, goals = np.array(problem.starts), np.array(problem.goals)
    share = _ITERATIONS * len(limits)
    levels = MARGINS if _crowded(problem, lattice) else MARGINS[:-1]
    if not problem.ground.flat:
        levels = (*MARGINS[:-1], FOOTING)

    def searched(margins: Margins, attempt: int) -> Paths | None:
        """What one pair of trees finds within so many extensions."""
        team = TeamScene(lattice.grid, NOBODY, team_limits(limits), margins, metre_cost(mean_speed))
        most = max(1, budget.most(attempt * share) // share)
        trees, status, used = plant(starts, goals, most), SPENT, 0
        if polish:
            _lead_out(problem, team, trees)
        for end in budget.deadline.slices(0, most):
            status, nodes, used = search_joint(team, trees, state, used, end)
            if status == FOUND:
                break
        budget.spend(used * share)
        if status != FOUND:
            return None
        paths = _paths_through(problem, team, _shortened(team, nodes, budget.deadline))
        if polish:
            paths = _polished(problem, lattice, paths, margins, budget.deadline)
        return tuple(RobotPath(path, path.cost) for path in paths)

    attempt = _ATTEMPT
    best: Paths | None = None
    while best is None and not budget.spent:
        for margins in levels:
            best = searched(margins, attempt)
            if best is not None or budget.spent:
                break
        attempt = min(2 * attempt, _LONGEST)
    if best is None or not polish:
        return best
    for _ in range(_AGAIN):
        if budget.spent:
            break
        if all(len(path.motion.moves) < 4 for path in best if isinstance(path.motion, TimedPath)):
            break  # straight there: the trees would find the same again
        other = searched(margins, _ATTEMPT)
        if other is not None and total_cost(other) < total_cost(best) - 1e-6:
            best = other
    return best


@cache
def _get_ready() -> None:
    """Load or compile the kernels, once in a process, on a problem of a moment."""
    lattice = SpaceTimePlanner(make_ground(OccupancyMap.empty((4.0, 3.0))))
    limits = [motion_limits(robot_model("spirit"))] * 2
    starts = np.array([[0.6, 1.5, 0.0], [3.4, 1.5, np.pi]])
    team = TeamScene(lattice.grid, NOBODY, team_limits(limits), MARGINS[0], 1.0)
    state = np.ones(1, np.uint64)
    search_joint(team, plant(starts, starts[::-1], 20), state, 0, 20)
    edge_free(team, starts, starts)
    word_between(team, 0, starts[0], starts[1])
    body = footprint(robot_model("spirit"))
    footprints_meet(body, tuple(starts[0].tolist()), body, tuple(starts[1].tolist()), 0.0)


def _crowded(problem: TeamProblem, lattice: SpaceTimePlanner) -> bool:
    """Whether starts or goals ask for the least margins."""
    margins, bodies = MARGINS[-2], [footprint(model) for model in problem.models]
    for poses in (problem.starts, problem.goals):
        if not all(
            pose_free(lattice.grid, body, *pose, margins.ground)
            for body, pose in zip(bodies, poses, strict=True)
        ):
            return True
        for i, j in combinations(range(len(bodies)), 2):
            if footprints_meet(bodies[i], poses[i], bodies[j], poses[j], margins.others):
                return True
    return False


def _lead_out(problem: TeamProblem, team: TeamScene, trees: Trees) -> None:
    """Grow the trees straight on from where robots are too near to something to turn, one by one.

    Nearly all edges to samples begin with an arc or a turn, and none of them would leave.
    """
    for tree, ahead in ((0, 1.0), (1, -1.0)):
        for k in range(len(problem.models)):
            at = int(trees.counts[tree])
            here = trees.nodes[tree, at - 1]
            if at == trees.nodes.shape[1] or _can_turn(problem, team, here, k):
                continue
            for length in (sign * lead for lead in _LEADS for sign in (ahead, -ahead)):
                there = here.copy()
                there[k, :2] += length * np.cos(here[k, 2]), length * np.sin(here[k, 2])
                if edge_free(team, *((here, there) if tree == 0 else (there, here))):
                    trees.nodes[tree, at], trees.parents[tree, at] = there, at - 1
                    trees.counts[tree] += 1
                    break


def _can_turn(problem: TeamProblem, team: TeamScene, poses: Array, k: int) -> bool:
    """Whether robot `k` at its of the poses `(N, 3)` may turn a little to both sides."""
    bodies = [footprint(model) for model in problem.models]
    x, y, yaw = poses[k]
    for turned in ((x, y, yaw + _TURN), (x, y, yaw - _TURN)):
        if not pose_free(team.grid, bodies[k], *turned, team.margins.ground):
            return False
        for j, pose in enumerate(poses):
            if j != k and footprints_meet(
                bodies[k], turned, bodies[j], tuple(pose), team.margins.others
            ):
                return False
    return True


def _shortened(team: TeamScene, nodes: Array, deadline: Deadline) -> Array:
    """The nodes `(M, N, 3)` without those that edges lead past, greedily from the start."""
    kept, here, last = [0], 0, len(nodes) - 1
    while here < last:
        there = last
        while there > here + 1:
            if deadline.late:
                there = here + 1
            elif edge_free(team, nodes[here], nodes[there]):
                break
            else:
                there -= 1
        kept.append(there)
        here = there
    return nodes[kept]


def _paths_through(problem: TeamProblem, team: TeamScene, nodes: Array) -> list[TimedPath]:
    """Each robot's moves along the nodes `(M, N, 3)`; who is there first waits for the others."""
    robots = range(len(problem.models))
    rows: list[list[Array]] = [[] for _ in robots]
    for k in range(len(nodes) - 1):
        edges = [word_between(team, i, nodes[k, i], nodes[k + 1, i])[0] for i in robots]
        longest = max(float(edge[:, DURATION].sum()) for edge in edges)
        for i, edge in enumerate(edges):
            rows[i].extend(edge)
            stand = np.zeros(6)
            stand[DURATION] = longest - float(edge[:, DURATION].sum())
            if stand[DURATION] > 1e-9 and k < len(nodes) - 2:
                rows[i].append(stand)
    return [
        TimedPath(nodes[0, i].copy(), np.array(rows[i]).reshape(-1, 6), motion_limits(model), model)
        for i, model in enumerate(problem.models)
    ]


def _polished(
    problem: TeamProblem,
    lattice: SpaceTimePlanner,
    paths: list[TimedPath],
    margins: Margins,
    deadline: Deadline,
) -> list[TimedPath]:
    """The same, each path shortened among the others' for as long as that helps."""
    for _ in range(_ROUNDS):
        before = sum(path.cost for path in paths)
        for k, path in enumerate(paths):
            rest = [Span(j, other.track()) for j, other in enumerate(paths) if j != k]
            paths[k] = lattice.shortened(path, others_among(problem, rest), margins, deadline)
        if sum(path.cost for path in paths) > before - 1e-6:
            break
    return paths


def solve_merged(search: TeamSearch, group: Sequence[int]) -> Paths | None:
    """The robots of a group planned as one, the others one by one past them."""
    planner, alone = search.planner, search.alone
    part = planner.problem.part(group)
    together = solve_joint(part, search.lattice, search.budget, search.rng)
    if together is None:
        return None
    paths = dict(zip(group, together, strict=True))
    for robot in range(len(alone)):
        if robot not in paths:
            path = planner.plan(robot, spans_of(paths.items()), search.budget)
            if path is None:
                return None
            paths[robot] = path
    return tuple(paths[k] for k in range(len(alone)))
