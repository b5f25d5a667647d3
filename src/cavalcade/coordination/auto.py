"""The default: cheap methods first, dearer ones where they fail, all within one budget.

Each robot alone; if paths conflict, prioritised planning with orders that are mended, and then
robot by robot anew among the others. Where a few robots are coupled, a short conflict-based search
and a short one in the product space. Then all three at length.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.prioritised import improved, in_order, mended_orders
from cavalcade.coordination.problem import PlanSettings
from cavalcade.coordination.robot_planner import EFFORT, RobotPlanner
from cavalcade.coordination.solution import Paths, RobotPath, Solution, total_cost

_FEW = 4
"""So few robots in conflict are searched for conflicts and planned as one, with a share of the
budget, before orders are tried at length."""

_SHARE = 0.05

Together = Callable[[Budget], Paths | None]
"""Plans the robots in conflict as one and the others past them; None if it finds nothing."""


def solve_auto(
    planner: RobotPlanner,
    settings: PlanSettings,
    alone: Paths,
    budget: Budget,
    rng: np.random.Generator,
    together: Together | None = None,
) -> Solution:
    """Paths without conflicts, or the best that is known.

    Args:
        planner: Of one robot.
        settings: Of the methods.
        alone: Each robot's path regardless of the others.
        budget: Of the call.
        rng: Draws orders once mending goes round in circles.
        together: The search in the product space.
    """
    team = dict(enumerate(alone))
    conflicts = conflicts_of([path.track for path in alone], planner.problem.models, 1)
    if not conflicts:
        return Solution(alone, True, "")

    def better(paths: dict[int, RobotPath] | Paths, method: str) -> Solution:
        """What was found, with the robots planned anew that lose most by it."""
        start = dict(enumerate(paths)) if isinstance(paths, tuple) else paths
        found = improved(planner, start, team, budget)
        if method == "prioritised" and len(team) == 2:
            found = _cheaper_order(planner, found, team, budget)
        return Solution(tuple(found[k] for k in team), True, method)

    coupled = {robot for conflict in conflicts for robot in (conflict.i, conflict.j)}
    paths = mended_orders(planner, team, budget, rng, len(team) + 2, EFFORT // 4)
    if paths is None and len(coupled) <= _FEW:
        part = budget.share(_SHARE)
        searched = conflict_search(planner, settings, alone, part)
        budget.spend(part.used)
        if searched.solved:
            return replace(better(searched.paths, "cbs"), counts=searched.counts)
        if together is not None:
            part = budget.share(_SHARE)
            merged = together(part)
            budget.spend(part.used)
            if merged is not None:
                return better(merged, "joint")
    if paths is None:
        paths = mended_orders(planner, team, budget, rng, 3 * len(team) + 10)
    if paths is not None:
        return better(paths, "prioritised")
    searched = conflict_search(planner, settings, alone, budget)
    if searched.solved:
        return replace(better(searched.paths, "cbs"), counts=searched.counts)
    merged = None if together is None else together(budget)
    return searched if merged is None else Solution(merged, True, "joint")


def _cheaper_order(
    planner: RobotPlanner,
    paths: dict[int, RobotPath],
    alone: Mapping[int, RobotPath],
    budget: Budget,
) -> dict[int, RobotPath]:
    """Of two robots, either may give way."""
    order = sorted(paths, key=lambda k: (paths[k].cost - alone[k].cost, k), reverse=True)
    other, failed = in_order(planner, order, budget, None, alone, effort=EFFORT // 4)
    if failed is not None:
        return paths
    return min(paths, other, key=total_cost)
