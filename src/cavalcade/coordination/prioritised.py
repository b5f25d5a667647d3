"""Prioritised planning: each robot avoids, in time, the paths of those before it.

After Erdmann & Lozano-Pérez, Algorithmica 2, 1987; orders are mended when they fail, as in
Bennewitz et al., ICRA 2001: who finds no path goes first, and then those before it start later.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.problem import PlanSettings
from cavalcade.coordination.robot_planner import EFFORT, RobotPlanner, Span, spans_of
from cavalcade.coordination.solution import Paths, RobotPath, Solution

_DELAYS = (2.0, 4.0, 8.0, 16.0)
"""s that robots wait at their starts where no order helps."""

_CORE = 0.3
"""Of a body's size: what shy robots keep off."""

LEAVE = 3.0
"""s that robots are given to leave their starts before others come past, once that is needed."""


def in_order(
    planner: RobotPlanner,
    order: Sequence[int],
    budget: Budget,
    delays: Mapping[int, float] | None = None,
    alone: Mapping[int, RobotPath] | None = None,
    leave: float = 0.0,
    shy: bool = False,
    effort: int = EFFORT,
) -> tuple[dict[int, RobotPath], int | None]:
    """Plan robots one after the other, each past the paths of those before it.

    Args:
        planner: Of one robot.
        order: All robots, the most important one first.
        budget: Of the call.
        delays: Robots that stand at their starts first, s.
        alone: Paths of robots regardless of others, to begin with.
        leave: For so long the starts of those who are still to be planned are taken, s.
        shy: Robots keep off the middle of the paths that later ones have alone, so that both give
            way where there is space for two, but not beside one that keeps to the middle.
        effort: Iterations that each robot may take.

    Returns:
        The paths, and the robot that found none or None.
    """
    paths: dict[int, RobotPath] = {}
    for place, robot in enumerate(order):
        spans = spans_of(paths.items())
        if leave > 0.0:
            spans += [Span(k, planner.standing(k), 0.0, leave) for k in order[place + 1 :]]
        if shy and alone is not None:
            spans += [Span(k, alone[k].track, scale=_CORE) for k in order[place + 1 :]]
        delay = (delays or {}).get(robot, 0.0)
        if delay > 0.0:
            path = planner.delayed(robot, spans, delay, budget)
        elif not spans and alone is not None:
            path = alone[robot]
        else:
            path = planner.plan(robot, spans, budget, effort)
        if path is None:
            return paths, robot
        paths[robot] = path
    return paths, None


def solve_sequential(
    planner: RobotPlanner,
    settings: PlanSettings,
    alone: Paths,
    budget: Budget,
) -> Solution:
    """One robot after the other, in the order of the problem (the paper's Algorithm 2).

    Each avoids the paths of all before it; conflicts that are left become constraints.

    Args:
        planner: Of one robot.
        settings: Of the constraints.
        alone: Each robot's path regardless of the others.
        budget: Of the call.
    """
    order = range(len(alone))
    waits = (0.0,) if settings.constraints == "static" else (0.0, LEAVE)
    paths: dict[int, RobotPath] = {}
    for leave in waits:
        paths, failed = in_order(planner, order, budget, None, dict(enumerate(alone)), leave)
        if failed is None:
            break
    root = tuple(paths.get(k, alone[k]) for k in order)
    tracks = [path.track for path in root]
    if not conflicts_of(tracks, planner.problem.models, 1, settings.distance):
        return Solution(root, True, "sequential")
    # Somebody found no path past those before, or the trees' paths still meet.
    outcome = conflict_search(planner, settings, root, budget)
    return Solution(outcome.paths, outcome.solved, "sequential", outcome.counts)


def mended_orders(
    planner: RobotPlanner,
    alone: Mapping[int, RobotPath],
    budget: Budget,
    rng: np.random.Generator,
    attempts: int,
    effort: int = EFFORT,
) -> dict[int, RobotPath] | None:
    """Paths of all robots by the first order that works, mended after each failure.

    Args:
        planner: Of one robot.
        alone: Each robot's path regardless of the others.
        budget: Of the call.
        rng: Draws delays and orders once mending goes round in circles.
        attempts: Orders at most.
        effort: Iterations that each robot may take.
    """
    order = sorted(alone, key=lambda robot: (-round(alone[robot].cost, 3), robot))
    tried: set[tuple[tuple[int, ...], tuple[tuple[int, float], ...]]] = set()
    delays: dict[int, float] = {}
    leave, shy = 0.0, False
    for attempt in range(attempts):
        tried.add((tuple(order), tuple(sorted(delays.items()))))
        paths, failed = in_order(planner, order, budget, delays, alone, leave, shy, effort)
        if failed is None:
            return paths
        if budget.spent:
            return None
        # In turn: the robot goes first; the others leave it time to get away; all are shy.
        leave, shy = (0.0, False) if attempt % 3 == 0 else (LEAVE, attempt % 3 == 2)
        if attempt % 3:
            continue
        order = [failed, *(robot for robot in order if robot != failed)]
        delays.pop(failed, None)
        while (tuple(order), tuple(sorted(delays.items()))) in tried:
            order = [int(robot) for robot in rng.permutation(order)]
            late = rng.integers(1, len(order) + 1)
            chosen = rng.permutation(order)[:late]
            delays = {int(robot): float(rng.choice(_DELAYS)) for robot in chosen}
    return None


def improved(
    planner: RobotPlanner,
    paths: Mapping[int, RobotPath],
    alone: Mapping[int, RobotPath],
    budget: Budget,
    rounds: int = 2,
) -> dict[int, RobotPath]:
    """The same with robots planned anew among all others, one at a time, while that is cheaper.

    Those that lose most by the others come first; robots that lose less than a hundredth stay.
    """
    best = dict(paths)
    for _ in range(rounds):
        changed = False
        losses = {robot: best[robot].cost - alone[robot].cost for robot in best}
        for robot in sorted(losses, key=lambda k: (-losses[k], k)):
            if losses[robot] < 0.01 * alone[robot].cost or budget.spent:
                break
            spans = spans_of((k, path) for k, path in best.items() if k != robot)
            path = planner.plan(robot, spans, budget, EFFORT // 4)
            if path is not None and path.cost < best[robot].cost - 1e-6:
                best[robot] = path
                changed = True
        if not changed:
            break
    return best
