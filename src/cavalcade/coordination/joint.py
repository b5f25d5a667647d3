"""All robots at once: RRT-Connect in the product space (the paper's section III-C, its text).

For any number of robots, though slow for many. What the trees find stops at each node; afterwards
each robot's way is shortened in space and time among those of the others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.coordination._joint import FOUND, search_joint, shorten_joint, word_between
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.course import Course
from cavalcade.coordination.problem import TeamProblem
from cavalcade.coordination.single import RobotPlanner, spans_of
from cavalcade.geometry import Array
from cavalcade.lattice.planner import CAREFUL, NOBODY, Care, TimedPlanner, Way, others_of
from cavalcade.lattice.primitives import DURATION
from cavalcade.lattice.shortening import shorten

_ATTEMPT = 200
"""Extensions of the trees before they are planted anew; twice as many every time."""

_PRICE = 30
"""Iterations of the budget that one robot's part of an extension costs, about as long as these."""

_LONGEST = 3200
"""Extensions of one attempt at most."""

_AGAIN = 6
"""So many further searches for a cheaper plan."""

_ROUNDS = 3
"""How often each way is shortened among the others."""


def solve_joint(
    problem: TeamProblem,
    timed: TimedPlanner,
    budget: Budget,
    rng: np.random.Generator,
    polish: bool = True,
) -> tuple[Course, ...] | None:
    """Courses without conflicts, or None if the budget was spent first.

    Args:
        problem: The team's.
        timed: Whose ground, price and movers are used.
        budget: Of the call.
        rng: Seeds the trees.
        polish: Shorten the ways afterwards; the paper's planner does not.
    """
    attempt = _ATTEMPT
    state = rng.integers(0, 2**63, size=1, dtype=np.int64).astype(np.uint64)
    best: tuple[Course, ...] | None = None
    while best is None and not budget.spent:
        for care in CAREFUL:
            best = _searched(problem, timed, budget, state, care, attempt, polish)
            if best is not None or budget.spent:
                break
        attempt = min(2 * attempt, _LONGEST)
    if best is None or not polish:
        return best
    for _ in range(_AGAIN):
        if budget.spent:
            break
        if all(len(course.motion.moves) < 4 for course in best if isinstance(course.motion, Way)):
            break  # straight there: the trees would find the same again
        other = _searched(problem, timed, budget, state, care, _ATTEMPT, polish)
        if other is not None and _total(other) < _total(best) - 1e-6:
            best = other
    return best


def _total(courses: tuple[Course, ...]) -> float:
    return sum(course.cost for course in courses)


def _searched(
    problem: TeamProblem,
    timed: TimedPlanner,
    budget: Budget,
    state: NDArray[np.uint64],
    care: Care,
    attempt: int,
    polish: bool,
) -> tuple[Course, ...] | None:
    """What one pair of trees finds within so many extensions."""
    movers = np.array([timed.mover(model) for model in problem.models])
    starts = np.array(problem.starts, dtype=float)
    goals = np.array(problem.goals, dtype=float)
    price = timed.price_for(movers.mean(axis=0))
    margins, steps = np.array([care.ground, care.others]), np.array(care.steps)
    ground, nobody = timed.grid, tuple(NOBODY)
    share = _PRICE * len(movers)
    status, path, used = search_joint(
        ground,
        nobody,
        movers,
        starts,
        goals,
        price,
        margins,
        steps,
        state,
        max(1, budget.most(attempt * share) // share),
    )
    budget.spend(used * share)
    if status != FOUND:
        return None
    path = shorten_joint(ground, nobody, movers, path, price, margins, steps)
    ways = _ways(problem, timed, movers, path, price, care)
    if polish:
        ways = _polished(problem, timed, ways, care)
    return tuple(Course(way, timed.cost(way)) for way in ways)


def _ways(
    problem: TeamProblem,
    timed: TimedPlanner,
    movers: Array,
    path: Array,
    price: float,
    care: Care,
) -> list[Way]:
    """Each robot's moves along the joint path; who is there first waits for the others."""
    margins, steps = np.array([care.ground, care.others]), np.array(care.steps)
    rows: list[list[Array]] = [[] for _ in movers]
    for k in range(len(path) - 1):
        edges = [
            word_between(
                timed.grid, tuple(NOBODY), mover, path[k, i], path[k + 1, i], price, margins, steps
            )[0]
            for i, mover in enumerate(movers)
        ]
        longest = max(float(edge[:, DURATION].sum()) for edge in edges)
        for i, edge in enumerate(edges):
            rows[i].extend(edge)
            stand = np.zeros(6)
            stand[DURATION] = longest - float(edge[:, DURATION].sum())
            if stand[DURATION] > 1e-9 and k < len(path) - 2:
                rows[i].append(stand)
    return [
        Way(path[0, i].copy(), np.array(rows[i]).reshape(-1, 6), movers[i], problem.models[i])
        for i in range(len(movers))
    ]


def _polished(problem: TeamProblem, timed: TimedPlanner, ways: list[Way], care: Care) -> list[Way]:
    """The same, each way shortened among the others' for as long as that helps."""
    margins, steps = np.array([care.ground, care.others]), np.array(care.steps)
    for _ in range(_ROUNDS):
        before = sum(timed.cost(way) for way in ways)
        for k, way in enumerate(ways):
            rest = [j for j in range(len(ways)) if j != k]
            others = others_of(
                [ways[j].track() for j in rest],
                [problem.models[j] for j in rest],
                [(i, 0.0, np.inf) for i in range(len(rest))],
            )
            moves = shorten(
                timed.grid,
                tuple(others),
                way.mover,
                way.start,
                way.moves,
                margins,
                steps,
                timed.price_for(way.mover),
                3,
            )
            ways[k] = Way(way.start, moves, way.mover, way.model)
        if sum(timed.cost(way) for way in ways) > before - 1e-6:
            break
    return ways


def solve_merged(
    problem: TeamProblem,
    timed: TimedPlanner,
    planner: RobotPlanner,
    alone: tuple[Course, ...],
    budget: Budget,
    rng: np.random.Generator,
) -> tuple[Course, ...] | None:
    """Robots whose own courses conflict planned as one, the others one by one past them.

    Args:
        problem: The team's.
        timed: Whose ground, price and movers are used.
        planner: Of one robot.
        alone: Each robot's course regardless of the others.
        budget: Of the call.
        rng: Seeds the trees.
    """
    conflicts = conflicts_of([course.track for course in alone], problem.models, 1)
    group = sorted({robot for conflict in conflicts for robot in (conflict.i, conflict.j)})
    part = TeamProblem(
        problem.ground,
        tuple(problem.models[k] for k in group),
        tuple(problem.starts[k] for k in group),
        tuple(problem.goals[k] for k in group),
    )
    together = solve_joint(part, timed, budget, rng)
    if together is None:
        return None
    courses = dict(zip(group, together, strict=True))
    for robot in range(len(alone)):
        if robot not in courses:
            course = planner.plan(robot, spans_of(courses.items()), budget)
            if course is None:
                return None
            courses[robot] = course
    return tuple(courses[k] for k in range(len(alone)))
