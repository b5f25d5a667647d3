"""What a scenario may say, but probably does not mean: warnings, each with its key.

What contradicts the kind of task is refused elsewhere (`rules`). Here stands what only the chosen
variant or method makes idle: comparing variants of one file must not end in errors.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from cavalcade.geometry import beyond_a_turn

if TYPE_CHECKING:
    from cavalcade.scenario.model import Scenario

SLOW, FAST = 5.0, 100.0
"""Rates that planners are made for, Hz: below, robots go blind for long; above, there is no time
to think within a cycle."""

_FIXED_ROLES = ("cavalcade-fixed-roles", "fixed-roles", "virtual-structure", "behaviour-based")

IDLE: Mapping[str, tuple[str, ...]] = {
    "d_switch": _FIXED_ROLES,
    "w_min_avoid": ("cavalcade-no-avoidance", "no-avoidance"),
    "w_min_partial": ("virtual-structure", "behaviour-based"),
    "expect": (
        *("cavalcade-no-filter", "published", "fixed-roles", "no-lookahead", "no-springs"),
        *("no-avoidance", "virtual-structure", "behaviour-based"),
    ),
}
"""Variants of the formation planner that make nothing of a key of `planner`."""


class ScenarioWarning(UserWarning):
    """A scenario was read as it is written, but probably not as it was meant."""


def warn_of(scenario: Scenario) -> None:
    """Warn of everything that is probably not meant."""
    place = "" if scenario.file is None else f"{scenario.file}: "
    for key, text in advice(scenario):
        warnings.warn(f"{place}{key}: {text}", ScenarioWarning, stacklevel=3)


def advice(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """Keys, and what is to be said of their values."""
    for key, yaw in _yaws(scenario):
        if beyond_a_turn(yaw):
            yield key, f"a yaw of {yaw:g} rad is more than a turn; expected radians, not degrees"
    if scenario.execution.noise.heading > 1.0:
        yield "execution.noise.heading", "more than 1 rad; expected radians, not degrees"
    rate = scenario.execution.rate
    if not SLOW <= rate <= FAST:
        span = f"{1000.0 / rate:.3g} ms for a cycle"
        yield (
            "execution.rate",
            f"{rate:g} Hz leaves {span}; planners are made for {SLOW:g} to {FAST:g}",
        )
    if scenario.task.kind == "formation":
        yield from _idle_for_formations(scenario)
    elif scenario.task.kind == "individual":
        yield from _idle_for_individual_goals(scenario)


def _yaws(scenario: Scenario) -> Iterator[tuple[str, float]]:
    for k, robot in enumerate(scenario.robots):
        yield f"robots[{k}].start", robot.start[2]
        if robot.goal is not None:
            yield f"robots[{k}].goal", robot.goal[2]
    for k, goal in enumerate(scenario.task.goals):
        yield f"task.goals[{k}]", goal[2]
    for k, obstacle in enumerate(scenario.world.obstacles):
        if obstacle.box is not None:
            yield f"world.obstacles[{k}].box.yaw", obstacle.box.yaw
    for k, event in enumerate(scenario.execution.events):
        for goal in event.goals or ():
            yield f"execution.events[{k}].goals", goal[2]
        for name in ("add", "remove", "move"):
            obstacle = getattr(event, name)
            if obstacle is not None and obstacle.box is not None:
                yield f"execution.events[{k}].{name}.box.yaw", obstacle.box.yaw


def _idle_for_formations(scenario: Scenario) -> Iterator[tuple[str, str]]:
    planner, untold = scenario.planner, type(scenario.planner)()
    for key, variants in IDLE.items():
        if getattr(planner, key) != getattr(untold, key) and planner.variant in variants:
            yield f"planner.{key}", f"has no effect: the variant {planner.variant} does not use it"
    for key, limit in (("v_max_x", "max_speed_x"), ("v_max_y", "max_speed_y")):
        asked = getattr(planner, key)
        slowest = min(getattr(model, limit) for model in scenario.models)
        if asked is not None and asked > slowest:
            yield f"planner.{key}", f"has no effect above {slowest:g}, the robots' own limit, m/s"


def _idle_for_individual_goals(scenario: Scenario) -> Iterator[tuple[str, str]]:
    planner = scenario.planner
    published = planner.variant == "published"
    usual = {
        "constraints": "static" if published else "timed",
        "conflict": "first" if published else "costly",
        "improve": 0,
    }
    for key, value in usual.items():
        if getattr(planner, key) in (None, value):
            continue
        if planner.method == "joint":
            yield f"planner.{key}", "has no effect: the method joint does not use it"
        elif key == "improve" and published:
            yield f"planner.{key}", "has no effect: the variant published does not use it"
