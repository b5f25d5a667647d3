"""The kinds of task, a formation, individual goals or commands: what each needs and excludes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from cavalcade.robots import MODELS
from cavalcade.scenario.commands import METHOD, VARIANT, check_commands
from cavalcade.scenario.fields import expected
from cavalcade.scenario.settings import (
    FORMATION_KEYS,
    TEAM_KEYS,
    TEAM_METHODS,
    TEAM_VARIANTS,
    Delay,
    Noise,
    PlannerSection,
)
from cavalcade.scenario.task import INDIVIDUAL

if TYPE_CHECKING:
    from cavalcade.scenario.model import Scenario


def with_planner_defaults(data: Any) -> Any:
    """A scenario's plain data with the planner that its task has by default written out."""
    if not isinstance(data, dict) or not isinstance(data.get("task"), dict):
        return data
    planner = data.get("planner", {})
    if data["task"].get("commands") is not None and isinstance(planner, dict):
        return {**data, "planner": {"method": METHOD, **planner}}
    if data["task"].get("goals") != INDIVIDUAL or not isinstance(planner, dict):
        return data
    published = planner.get("variant") == "published"
    defaults = {
        "method": "auto",
        "constraints": "static" if published else "timed",
        "conflict": "first" if published else "costly",
        "leaps": True,
        "improve": 0,
    }
    said = {key: value for key, value in planner.items() if value is not None}
    return {**data, "planner": {**defaults, **said}}


def check_kind(scenario: Scenario) -> None:
    """Refuse what does not go together with the task.

    Raises:
        PydanticCustomError: One line with the key and what was expected.
    """
    if scenario.task.commands is not None:
        _check_commanded(scenario)
    elif scenario.task.individual:
        _check_individual(scenario)
    else:
        _check_formation(scenario)


def _check_individual(scenario: Scenario) -> None:
    planner, execution = scenario.planner, scenario.execution
    for index, (robot, model) in enumerate(zip(scenario.robots, scenario.models, strict=True)):
        if robot.goal is None:
            raise expected(
                "missing; with individual goals each robot has one: [x, y, yaw]",
                key=f"robots[{index}].goal",
            )
        if scenario.world.has_heights and model.legs is None:
            raise expected(
                f"a {model.name} needs level ground; expected a robot with legs on terrain",
                key=f"robots[{index}].model",
                choices=_legged(),
            )
    if planner.method not in TEAM_METHODS:
        raise expected(
            f"method {planner.method} has no individual goals",
            key="planner.method",
            choices=TEAM_METHODS,
        )
    if planner.variant not in TEAM_VARIANTS:
        raise expected(
            f"method {planner.method} has no variant {planner.variant}",
            key="planner.variant",
            choices=TEAM_VARIANTS,
        )
    _refuse(planner, FORMATION_KEYS, "is for formations; goals are individual")
    for key, said, default in (
        ("events", execution.events, ()),
        ("noise", execution.noise, Noise()),
        ("delay", execution.delay, Delay()),
    ):
        if said != default:
            raise expected(
                "individual goals are planned ahead, for a world that stays as it is; "
                f"expected no {key}",
                key=f"execution.{key}",
            )


def _check_commanded(scenario: Scenario) -> None:
    for index, (robot, model) in enumerate(zip(scenario.robots, scenario.models, strict=True)):
        if robot.goal is not None:
            raise expected("commands say where it goes", key=f"robots[{index}].goal")
        if scenario.world.has_heights and model.legs is None:
            raise expected(
                f"a {model.name} needs level ground; expected a robot with legs on terrain",
                key=f"robots[{index}].model",
                choices=_legged(),
            )
    planner = scenario.planner
    for key, said, known in (
        ("method", planner.method, METHOD),
        ("variant", planner.variant, VARIANT),
    ):
        if said != known:
            raise expected(f"{said} follows no commands; expected {known}", key=f"planner.{key}")
    _refuse(planner, (*FORMATION_KEYS, *TEAM_KEYS), "is for planners; the task has commands")
    for index, event in enumerate(scenario.execution.events):
        if event.kind in _FOR_FORMATIONS:
            raise expected("is for formations", key=f"execution.events[{index}].{event.kind}")
    check_commands(scenario)


_FOR_FORMATIONS = ("goals", "formation", "lose", "rejoin")
"""Events that mean something to a planner."""


def _check_formation(scenario: Scenario) -> None:
    for index, (robot, model) in enumerate(zip(scenario.robots, scenario.models, strict=True)):
        if robot.goal is not None:
            raise expected(
                "the formation has the goals; expected none here, or task.goals: individual",
                key=f"robots[{index}].goal",
            )
        if model.legs is None:
            raise expected(
                f"a {model.name} has no place in a formation; expected a robot with legs",
                key=f"robots[{index}].model",
                choices=_legged(),
            )
    if scenario.planner.method != "formation":
        raise expected(
            f"method {scenario.planner.method} is for individual goals; expected formation",
            key="planner.method",
        )
    _refuse(scenario.planner, TEAM_KEYS, "is for individual goals; the task is a formation")
    if scenario.world.has_heights:
        key = "terrain" if scenario.world.terrain is not None else "generate.kind"
        raise expected(
            "formations need level ground; terrain is for task.goals: individual",
            key=f"world.{key}",
        )


def _refuse(planner: PlannerSection, keys: tuple[str, ...], why: str) -> None:
    for key in keys:
        if getattr(planner, key) != PlannerSection.model_fields[key].default:
            raise expected(why, key=f"planner.{key}")


def _legged() -> tuple[str, ...]:
    return tuple(name for name, model in MODELS.items() if model.legs is not None)
