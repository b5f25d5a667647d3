"""The default: cheap methods first, dearer ones where they fail, all within one budget.

Each robot alone; if paths conflict, prioritised planning with orders that are mended, and then
robot by robot anew among the others. Where a few robots are coupled, a short conflict-based search
and a short one in the product space. Then all three at length.
"""

from __future__ import annotations

from dataclasses import replace

from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.joint import solve_merged
from cavalcade.coordination.prioritised import improved, in_order, mended_orders
from cavalcade.coordination.robot_planner import EFFORT, TeamSearch
from cavalcade.coordination.solution import Paths, Solution, total_cost

_FEW = 4
"""So few robots in conflict are searched for conflicts and planned as one, with a share of the
budget, before orders are tried at length."""

_SHARE = 0.05


def solve_auto(search: TeamSearch) -> Solution:
    """Paths without conflicts, or the best that is known."""
    alone, budget, problem = search.alone, search.budget, search.planner.problem
    conflicts = conflicts_of([path.track for path in alone], problem.models, 1)
    if not conflicts:
        return Solution(alone, True, "")
    coupled = sorted({robot for conflict in conflicts for robot in (conflict.i, conflict.j)})
    paths = mended_orders(search, len(alone) + 2, EFFORT // 4)
    if paths is None and len(coupled) <= _FEW:
        part = replace(search, budget=budget.share(_SHARE))
        searched = conflict_search(part, alone)
        budget.spend(part.budget.used)
        if searched.solved:
            return replace(searched, paths=improved(search, searched.paths))
        if problem.ground.flat:
            part = replace(search, budget=budget.share(_SHARE))
            merged = solve_merged(part, coupled)
            budget.spend(part.budget.used)
            if merged is not None:
                return Solution(improved(search, merged), True, "joint")
    if paths is None:
        paths = mended_orders(search, 3 * len(alone) + 10)
    if paths is not None:
        paths = improved(search, paths)
        if len(paths) == 2:
            paths = _cheaper_order(search, paths)
        return Solution(paths, True, "prioritised")
    searched = conflict_search(search, alone)
    if searched.solved:
        return replace(searched, paths=improved(search, searched.paths))
    merged = solve_merged(search, coupled) if problem.ground.flat else None
    return searched if merged is None else Solution(merged, True, "joint")


def _cheaper_order(search: TeamSearch, paths: Paths) -> Paths:
    """Of two robots, either may give way."""
    losses = [path.cost - own.cost for path, own in zip(paths, search.alone, strict=True)]
    order = sorted(range(2), key=lambda k: (losses[k], k), reverse=True)
    other, failed = in_order(search, order, effort=EFFORT // 4)
    return paths if failed is not None else min(paths, (other[0], other[1]), key=total_cost)
