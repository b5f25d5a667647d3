"""Coordination of robots that have goals of their own: sequential, joint, conflict-based, auto.

The names below are imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cavalcade.coordination.plan import METHODS, plan_team
    from cavalcade.coordination.problem import PlanSettings, TeamProblem, problem_of
    from cavalcade.coordination.result import TeamPlan

_HOME = {
    "METHODS": "plan",
    "PlanSettings": "problem",
    "TeamPlan": "result",
    "TeamProblem": "problem",
    "plan_team": "plan",
    "problem_of": "problem",
}

__all__ = [
    "METHODS",
    "PlanSettings",
    "TeamPlan",
    "TeamProblem",
    "plan_team",
    "problem_of",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value
