"""One robot after the other, in the order of the scenario (the paper's Algorithm 2)."""

from __future__ import annotations

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.course import Course
from cavalcade.coordination.found import Found
from cavalcade.coordination.prioritised import LEAVE, in_order
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.single import RobotPlanner


def solve_sequential(
    problem: TeamProblem,
    planner: RobotPlanner,
    settings: PlanSettings,
    alone: tuple[Course, ...],
    budget: Budget,
) -> Found:
    """Each robot avoids the courses of all before it; conflicts that are left become constraints.

    Args:
        problem: The team's.
        planner: Of one robot.
        settings: Of the constraints.
        alone: Each robot's course regardless of the others.
        budget: Of the call.
    """
    order = range(len(alone))
    waits = (0.0,) if settings.constraints == "static" else (0.0, LEAVE)
    courses: dict[int, Course] = {}
    for leave in waits:
        courses, failed = in_order(planner, order, budget, None, dict(enumerate(alone)), leave)
        if failed is None:
            break
    root = tuple(courses.get(k, alone[k]) for k in order)
    if not conflicts_of([c.track for c in root], problem.models, 1, settings.distance):
        return Found(root, True, "sequential")
    # Somebody found no way past those before, or the trees' courses still meet.
    outcome = conflict_search(problem, planner, settings, root, budget)
    return Found(outcome.courses, outcome.solved, "sequential", outcome.counts)
