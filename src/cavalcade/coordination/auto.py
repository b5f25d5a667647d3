"""The default: cheap methods first, dearer ones where they fail, all within one budget.

Each robot alone; if courses conflict, prioritised planning with orders that are mended, and then
robot by robot anew among the others; then conflict-based search; then the product space.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.course import Course
from cavalcade.coordination.found import Found
from cavalcade.coordination.prioritised import improved, in_order, mended_orders
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.single import RobotPlanner


def solve_auto(
    problem: TeamProblem,
    planner: RobotPlanner,
    settings: PlanSettings,
    alone: tuple[Course, ...],
    budget: Budget,
    rng: np.random.Generator,
) -> Found:
    """Courses without conflicts, or the best that is known.

    Args:
        problem: The team's.
        planner: Of one robot.
        settings: Of the methods.
        alone: Each robot's course regardless of the others.
        budget: Of the call.
        rng: For orders that need luck.
    """
    team = dict(enumerate(alone))
    if not conflicts_of([course.track for course in alone], problem.models, 1):
        return Found(alone, True, "")
    courses = mended_orders(planner, team, budget, rng, 3 * len(team) + 10)
    if courses is not None:
        courses = improved(planner, courses, team, budget)
        if len(team) == 2:
            courses = _cheaper_way_round(planner, courses, team, budget)
        return Found(tuple(courses[k] for k in team), True, "prioritised")
    searched = conflict_search(problem, planner, settings, alone, budget)
    if not searched.solved:
        return searched
    courses = improved(planner, dict(enumerate(searched.courses)), team, budget)
    return Found(tuple(courses[k] for k in team), True, "cbs", searched.counts)


def _cheaper_way_round(
    planner: RobotPlanner,
    courses: dict[int, Course],
    alone: Mapping[int, Course],
    budget: Budget,
) -> dict[int, Course]:
    """Of two robots, either may give way."""
    order = sorted(courses, key=lambda k: (courses[k].cost - alone[k].cost, k), reverse=True)
    other, failed = in_order(planner, order, budget, None, alone)
    if failed is not None:
        return courses
    return min(courses, other, key=lambda found: sum(c.cost for c in found.values()))
