"""From a scenario's words to the settings of a coordinator."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from cavalcade.coordination.problem import PlanSettings
from cavalcade.errors import InputError
from cavalcade.scenario import PlannerSection, Scenario

METHODS = ("sequential", "joint", "cbs", "auto")


def require_own_goals(scenario: Scenario) -> None:
    """Refuse a scenario whose goals are those of a formation.

    Raises:
        InputError: It is one.
    """
    if not scenario.task.individual:
        raise InputError(
            "plan is for robots with goals of their own (task.goals: individual); "
            "use `cavalcade run` for formations",
            file=scenario.file or scenario.name,
            key="task.goals",
        )


def with_method(scenario: Scenario, method: str | None) -> Scenario:
    """The scenario with another method; itself if that is None.

    Raises:
        InputError: There is no such method.
    """
    if method is None or method == scenario.planner.method:
        return scenario
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}", key="method", choices=METHODS)
    planner = scenario.planner.model_copy(update={"method": method})
    return scenario.model_copy(update={"planner": planner})


def settings_of(section: PlannerSection) -> PlanSettings:
    """The settings that the section names over the defaults.

    The variant `published` has the paper's plain choices where the section names no others.
    """
    plain = {"constraints": "static", "conflict": "first"}
    said: dict[str, Any] = dict(plain) if section.variant == "published" else {}
    said |= {
        field.name: getattr(section, field.name)
        for field in fields(PlanSettings)
        if getattr(section, field.name, None) is not None
    }
    budget = section.budget
    if budget.iterations is not None:
        said["iterations"] = budget.iterations
    return PlanSettings(**said, seconds=budget.seconds)
