"""From a scenario's words to what a coordinator is asked."""

from __future__ import annotations

from cavalcade.coordination import PlanSettings
from cavalcade.errors import InputError
from cavalcade.scenario import Scenario

SWAY = 0.05
"""Robots that walk are planned for as if their bodies were this much wider on all sides, m."""

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


def settings_of(scenario: Scenario) -> PlanSettings:
    """The options that the scenario's `planner` section gives over the defaults.

    The variant `published` has the paper's plain choices where the section names no others.
    """
    said, default = scenario.planner, PlanSettings()
    published = said.variant == "published"
    return PlanSettings(
        variant="published" if published else "cavalcade",
        constraints=said.constraints or ("static" if published else default.constraints),
        conflict=said.conflict or ("first" if published else default.conflict),
        leaps=default.leaps if said.leaps is None else said.leaps,
        improve=default.improve if said.improve is None else said.improve,
        margin=_margin(scenario),
        iterations=said.budget.iterations or default.iterations,
        seconds=said.budget.seconds,
    )


def _margin(scenario: Scenario) -> float:
    said = scenario.planner.margin
    if said is None:
        return SWAY if scenario.execution.backend == "mujoco" else 0.0
    return float(said)
