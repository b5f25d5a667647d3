"""Plans for robots with goals of their own: made and measured."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence

import numpy as np

from cavalcade.coordination import PlanSettings
from cavalcade.coordination.result import TeamPlan
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.jobs.reporter import JobReporter
from cavalcade.lattice.ground import make_ground
from cavalcade.locomotion import leg_lengths, plan_footholds
from cavalcade.metrics.plan_summary import PlanResult, summarise_plan
from cavalcade.scenario import ResolvedScenario, Scenario, World

SWAY = 0.05
"""Robots that walk are planned for as if their bodies were this much wider on all sides, m."""

Coordinator = Callable[[Scenario, World], TeamPlan]
"""What makes a team plan; tests and users may bring their own."""


def make_plan(
    scenario: ResolvedScenario,
    world: World,
    coordinator: Coordinator | None = None,
    reporter: JobReporter | None = None,
) -> PlanResult:
    """Plan and measure the plan, without files; by `coordinator` if not the scenario's method."""
    started = clock.perf_counter()
    with (reporter or JobReporter(scenario.name, quiet=True)).planning(scenario):
        team = (coordinator or coordinate)(scenario, world)
    footholds, stretches = _plan_feet(scenario, world, team.trajectories)
    summary = summarise_plan(scenario, world, team, stretches, clock.perf_counter() - started)
    return PlanResult(team, footholds, summary)


def coordinate(scenario: Scenario, world: World) -> TeamPlan:
    """The plan of the scenario's own method."""
    from cavalcade.coordination import plan_team, problem_of

    return plan_team(
        problem_of(scenario, world),
        scenario.planner.method,
        settings_of(scenario),
        scenario.seed,
    )


def settings_of(scenario: Scenario) -> PlanSettings:
    """The options that the scenario's `planner` section gives over the defaults.

    The variant `published` has the paper's plain choices where the section names no others.
    """
    said, default = scenario.planner, PlanSettings()
    published = said.variant == "published"
    margin = said.margin
    if margin is None:
        margin = 0.0 if scenario.execution.backend == "ideal" else SWAY
    return PlanSettings(
        variant="published" if published else "cavalcade",
        constraints=said.constraints or ("static" if published else default.constraints),
        conflict=said.conflict or ("first" if published else default.conflict),
        leaps=default.leaps if said.leaps is None else said.leaps,
        improve=default.improve if said.improve is None else said.improve,
        margin=float(margin),
        iterations=said.budget.iterations or default.iterations,
        seconds=said.budget.seconds,
    )


def _plan_feet(
    scenario: Scenario, world: World, trajectories: Sequence[Trajectory | None]
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Footholds `(M, 6)` of each robot, and how far its legs stretch to them `(M,)`, m."""
    ground = make_ground(world.map, world.terrain)
    origin = world.map.origin
    footholds: list[Array] = []
    stretches: list[Array] = []
    for model, trajectory in zip(scenario.models, trajectories, strict=True):
        feet, stretch = np.zeros((0, 6)), np.zeros(0)
        if trajectory is not None and model.legs is not None:
            feet = plan_footholds(trajectory, model, ground, origin)
            stretch = leg_lengths(feet, trajectory, model, ground, origin)
        footholds.append(feet)
        stretches.append(stretch)
    return tuple(footholds), tuple(stretches)
