"""Plans for inflated bodies, for robots that do not go exactly where they are sent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.result import TeamPlan
from cavalcade.robots import RobotModel

_SMALLEST = 0.2
"""A margin less than this part of what was asked for is none."""

_SHARE = 0.5
"""Part of what is left of the budget for a search with margins, of which there may be another."""


def plan_inflated(
    problem: TeamProblem,
    settings: PlanSettings,
    plan: Callable[[TeamProblem, PlanSettings], TeamPlan],
) -> TeamPlan:
    """The plan for bodies that are inflated by `settings.margin`, or by less where that has none.

    Where start, goal or ground leave a robot no space for it, its margin is halved, then given up;
    where the search finds nothing, those of all robots are. `plan` is a single search.
    """
    margins = [settings.margin] * len(problem.models)
    budget = Budget(settings.iterations, settings.seconds)
    searching = 0.0
    while True:
        inflating = any(margins)
        share = budget.share(_SHARE if inflating else 1.0)
        answer = plan(
            replace(problem, models=tuple(map(inflated, problem.models, margins))),
            replace(settings, iterations=share.iterations, seconds=share.seconds, margin=0.0),
        )
        budget.spend(answer.iterations)
        searching += answer.planning_time
        refused = answer.reason == "infeasible"
        tight = [k for k in answer.involved if margins[k]] if refused else range(len(margins))
        if answer.solved or not inflating or not tight:
            return replace(
                answer,
                iterations=budget.used,
                planning_time=searching,
                margins=tuple(margins),
            )
        for k in tight:
            half = 0.5 * margins[k]
            margins[k] = half if half >= _SMALLEST * settings.margin else 0.0


def inflated(model: RobotModel, margin: float) -> RobotModel:
    """The robot with a footprint that is `margin` m wider on all sides."""
    if not margin:
        return model
    return replace(model, length=model.length + 2.0 * margin, width=model.width + 2.0 * margin)
