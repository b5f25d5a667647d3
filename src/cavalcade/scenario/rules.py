"""What must hold between a scenario's sections: rules of its kind of task and of its backend."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr
from pydantic_core import PydanticCustomError

from cavalcade.robots import MODELS, RobotModel
from cavalcade.scenario.commands import METHOD, VARIANT
from cavalcade.scenario.fields import Section, expected
from cavalcade.scenario.ground import WorldSection
from cavalcade.scenario.settings import (
    FORMATION_KEYS,
    TEAM_KEYS,
    TEAM_METHODS,
    TEAM_VARIANTS,
    Delay,
    ExecutionSection,
    Noise,
    PlannerSection,
)
from cavalcade.scenario.task import INDIVIDUAL, Kind, RobotSection, TaskSection, kind_of

SIMULATED = ("ideal", "mujoco")
"""Who moves robots in a time that is ours."""

LIVE = ("ros2", "unitree")
"""Who moves them in a time of their own."""

BACKENDS = (*SIMULATED, *LIVE)
"""Who can move robots."""

SLOWEST, FASTEST = 2.5, 500.0
"""How often a planner is asked, Hz: robots stop 0.5 s after their last command, and there are 500
steps of physics a second."""


class Parts(Section):
    """The sections of a scenario file, before they are looked at together.

    Attributes:
        version: Of the format.
        name: What it is called, also in results.
        description: One line about it.
        world: Where it takes place.
        robots: The team; robots are numbered from 0 in this order.
        task: What it is to do.
        planner: How it plans.
        execution: How the plan is carried out.
    """

    version: Literal[1]
    name: Annotated[str, Field(min_length=1, max_length=200)]
    description: Annotated[str, Field(max_length=2000)] = ""
    world: WorldSection
    robots: Annotated[tuple[RobotSection, ...], Field(min_length=1, max_length=256)]
    task: TaskSection
    planner: PlannerSection = PlannerSection()
    execution: ExecutionSection = ExecutionSection()

    _models: tuple[RobotModel, ...] | None = PrivateAttr(default=None)

    @property
    def models(self) -> tuple[RobotModel, ...]:
        """The model of each robot."""
        return self._models or tuple(robot.the_model for robot in self.robots)

    @property
    def team(self) -> Iterator[tuple[str, RobotSection, RobotModel]]:
        """Each robot's key in the file, section and model."""
        for index, (robot, model) in enumerate(zip(self.robots, self.models, strict=True)):
            yield f"robots[{index}]", robot, model


UNUSED_KEYS: dict[Kind, tuple[str, ...]] = {
    "formation": TEAM_KEYS,
    "individual": FORMATION_KEYS,
    "commands": ("despeckle", *FORMATION_KEYS, *TEAM_KEYS),
}
"""Keys of `planner` that mean nothing to a kind of task."""


def with_planner_defaults(data: Any) -> Any:
    """A scenario's plain data with the planner that its task has by default written out."""
    if not isinstance(data, dict) or not isinstance(data.get("task"), dict):
        return data
    planner, task = data.get("planner", {}), data["task"]
    if not isinstance(planner, dict):
        return data
    kind = kind_of(task.get("commands"), task.get("goals") != INDIVIDUAL)
    defaults = planner
    if kind == "commands":
        defaults = {"method": METHOD, **planner}
    elif kind == "individual":
        published = planner.get("variant") == "published"
        defaults = {
            "method": "auto",
            "constraints": "static" if published else "timed",
            "conflict": "first" if published else "costly",
            "leaps": True,
            "improve": 0,
            **{key: value for key, value in planner.items() if value is not None},
        }
    return data if defaults == planner else {**data, "planner": defaults}


def _check_formation(scenario: Parts) -> None:
    for key, robot, model in scenario.team:
        if robot.goal is not None:
            raise expected(
                "the formation has the goals; expected none here, or task.goals: individual",
                key=f"{key}.goal",
            )
        if model.legs is None:
            text = f"a {model.name} has no place in a formation; expected a robot with legs"
            raise _legless(key, text)
    if scenario.planner.method != "formation":
        raise expected(
            f"method {scenario.planner.method} is for individual goals; expected formation",
            key="planner.method",
        )
    _refuse(scenario, "is for individual goals; the task is a formation")
    if scenario.world.has_heights:
        key = "terrain" if scenario.world.terrain is not None else "generate.kind"
        raise expected(
            "formations need level ground; terrain is for task.goals: individual",
            key=f"world.{key}",
        )


def _check_individual(scenario: Parts) -> None:
    planner, execution = scenario.planner, scenario.execution
    for key, robot, model in scenario.team:
        if robot.goal is None:
            raise expected(
                "missing; with individual goals each robot has one: [x, y, yaw]",
                key=f"{key}.goal",
            )
        _check_ground(scenario.world, key, model)
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
    _refuse(scenario, "is for formations; goals are individual")
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


def _check_commands(scenario: Parts) -> None:
    for key, robot, model in scenario.team:
        if robot.goal is not None:
            raise expected("commands say where it goes", key=f"{key}.goal")
        _check_ground(scenario.world, key, model)
    planner = scenario.planner
    for key, said, known in (
        ("method", planner.method, METHOD),
        ("variant", planner.variant, VARIANT),
    ):
        if said != known:
            raise expected(f"{said} follows no commands; expected {known}", key=f"planner.{key}")
    _refuse(scenario, "is for planners; the task has commands")
    for index, event in enumerate(scenario.execution.events):
        if event.kind in _FOR_FORMATIONS:
            raise expected("is for formations", key=f"execution.events[{index}].{event.kind}")
    task, robots = scenario.task, len(scenario.robots)
    for index, command in enumerate(task.commands or ()):
        if command.robot is not None and command.robot >= robots:
            raise expected(
                f"there is no robot {command.robot}; expected 0 to {robots - 1}, or none for all",
                key=f"task.commands[{index}].robot",
            )
    if task.length > scenario.execution.timeout:
        raise expected(
            f"the task lasts {task.length:g} s; expected at least as much",
            key="execution.timeout",
        )


CHECKS: dict[Kind, Callable[[Parts], None]] = {
    "formation": _check_formation,
    "individual": _check_individual,
    "commands": _check_commands,
}
"""Refuse what does not go together with a kind of task: PydanticCustomError with the key."""

_FOR_FORMATIONS = ("goals", "formation", "lose", "rejoin")
"""Events that mean something to a planner."""


def _refuse(scenario: Parts, why: str) -> None:
    """Refuse keys of `planner` that mean nothing to the task."""
    for key in UNUSED_KEYS[scenario.task.kind]:
        if getattr(scenario.planner, key) != PlannerSection.model_fields[key].default:
            raise expected(why, key=f"planner.{key}")
    world = scenario.world
    if scenario.planner.despeckle > 0.0 and world.map is None and world.movingai is None:
        raise expected(
            f"is for worlds from map files; a world of {world.kind} has no specks",
            key="planner.despeckle",
        )


def _check_ground(world: WorldSection, key: str, model: RobotModel) -> None:
    if world.has_heights and model.legs is None:
        text = f"a {model.name} needs level ground; expected a robot with legs on terrain"
        raise _legless(key, text)


def _legless(key: str, text: str) -> PydanticCustomError:
    legged = (name for name, model in MODELS.items() if model.legs is not None)
    return expected(text, key=f"{key}.model", choices=legged)


def check_backend(scenario: Parts) -> None:
    """Refuse what the backend cannot do.

    Raises:
        PydanticCustomError: One line with the key and what was expected.
    """
    backend = scenario.execution.backend
    physics = backend == "mujoco"
    for index, command in enumerate(scenario.task.commands or ()):
        if not physics and command.leap is not None:
            raise expected(
                f"{backend} robots do not leap when they are told to; expected backend mujoco",
                key=f"task.commands[{index}].leap",
            )
    for index, event in enumerate(scenario.execution.events):
        key, last = f"execution.events[{index}].push", len(scenario.robots) - 1
        if not physics and event.push is not None:
            raise expected(f"{backend} robots cannot be pushed; expected backend mujoco", key=key)
        if event.push is not None and event.push.robot > last:
            text = f"there is no robot {event.push.robot}; expected 0 to {last}"
            raise expected(text, key=f"{key}.robot")
    for key, robot, model in scenario.team if physics else ():
        if model.description is None and (robot.mjcf is None or model.legs is None):
            raise expected(
                f"physics has no masses and joints of a {model.name}; expected a robot with them, "
                "such as with --set 'robots.*.model=go1'",
                key=f"{key}.model",
                choices=(name for name, known in MODELS.items() if known.description is not None),
            )
    if backend == "unitree":
        _check_network(scenario)
    if backend != "ideal" and not SLOWEST <= scenario.execution.rate <= FASTEST:
        where = "in physics" if physics else f"with backend {backend}"
        raise expected(
            f"expected {SLOWEST:g} to {FASTEST:g} {where}: robots stop 0.5 s after a command",
            key="execution.rate",
        )


def _check_network(scenario: Parts) -> None:
    """Refuse a team of Go2s that are not all told apart on the network."""
    said, team, key = scenario.execution.unitree.robots, scenario.robots, "execution.unitree.robots"
    if len(said) != len(team):
        raise expected(
            f"expected the place of each of {len(team)} robots on the network, such as "
            f"[{{interface: eth1}}, {{interface: eth2}}] or [{{domain: 1}}, {{domain: 2}}]; "
            f"got {len(said)}",
            key=key,
        )
    known: dict[tuple[int, str | None], int] = {}
    for index, robot in enumerate(said):
        place = robot.domain, robot.interface
        if place in known:
            text = f"is where robot {known[place]} is; each needs its own interface or domain"
            raise expected(text, key=f"{key}[{index}]")
        known[place] = index
