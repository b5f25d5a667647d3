"""From a scenario to its formation planner."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np

from cavalcade.errors import InputError, ScenarioError
from cavalcade.formation import (
    Connection,
    Formation,
    FormationPlanner,
    FormationSettings,
    Imperfections,
    default_settings,
)
from cavalcade.formation.settings import PRESETS, SIMULATION_SPRINGS, SpringLaw, Springs
from cavalcade.scenario import FormationSection, PlannerSection, Scenario, World
from cavalcade.scenario.task import ConnectionSection


def make_planner(scenario: Scenario, world: World, live: bool = False) -> FormationPlanner:
    """The planner of a scenario with a formation, its goals set; `live` as in its class.

    Raises:
        ScenarioError: The planner refuses the scenario's values.
    """
    section = scenario.planner
    try:
        planner = FormationPlanner(
            world.map,
            formation_of(scenario.task.the_formation, len(scenario.robots), section),
            robots=len(scenario.robots),
            model=max(scenario.models, key=lambda model: model.length * model.width),
            settings=settings_of(section),
            variant=section.variant,
            rate=scenario.execution.rate,
            seed=scenario.seed,
            lookahead=section.lookahead,
            expected=expected_of(scenario),
            live=live,
        )
        planner.set_goals(scenario.task.goals)
    except ScenarioError:
        raise
    except InputError as error:
        raise ScenarioError(str(error), file=scenario.file, key="planner") from None
    return planner


def settings_of(section: PlannerSection) -> FormationSettings:
    """The preset's or the default parameters, with those that the scenario names over them."""
    base = (
        default_settings(section.variant) if section.preset is None else PRESETS[section.preset][0]
    )
    names = {field.name for field in fields(FormationSettings)} - {"lookahead"}
    return base.with_values(**{name: getattr(section, name) for name in names})


def expected_of(scenario: Scenario) -> Imperfections:
    """What the planner expects of its robots: what it is told, else what is the case."""
    said, execution = scenario.planner.expect, scenario.execution
    noise = execution.noise if said.noise is None else said.noise
    delay = execution.delay if said.delay is None else said.delay
    error = said.tracking_error
    if error is None:
        legs = execution.backend != "ideal"
        error = max(model.tracking_error for model in scenario.models) if legs else 0.0
    return Imperfections(noise.position, noise.heading, delay.mean, delay.jitter, delay.drop, error)


def formation_of(section: FormationSection, robots: int, planner: PlannerSection) -> Formation:
    """The formation of a scenario or an event; the planner's preset says what springs are like."""
    springs = SIMULATION_SPRINGS if planner.preset is None else PRESETS[planner.preset][1]
    formation = _shape(section, robots, springs)
    if section.connections is None:
        return formation
    return formation.connected(
        _connection(formation, joint, springs) for joint in section.connections
    )


def _shape(section: FormationSection, robots: int, springs: Springs) -> Formation:
    if section.shape == "custom":
        return Formation.custom(section.slots or (), springs=springs)
    # The others are called as their methods are.
    make: Callable[..., Formation] = getattr(Formation, section.shape)
    if section.shape in ("square", "triangle"):
        return make(section.side or 0.0, springs)
    size = section.radius if section.shape == "circle" else section.spacing
    return make(robots, size or 0.0, springs)


def _connection(formation: Formation, joint: ConnectionSection, springs: Springs) -> Connection:
    """A spring of the scenario; what it leaves open is the shape's own, or a diagonal's."""
    law = springs.diagonals
    length = float(np.hypot(*(formation.slots[joint.a] - formation.slots[joint.b])))
    for own in formation.connections:
        if {own.a, own.b} == {joint.a, joint.b}:
            law, length = own.law, own.rest_length
    names = {field.name for field in fields(SpringLaw)}
    said = joint.model_dump(include=names, exclude_none=True)
    rest_length = length if joint.l0 is None else joint.l0
    return Connection(joint.a, joint.b, rest_length, replace(law, **said))
