"""Robots with goals of their own: plan, then follow the plan."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import cast

import numpy as np

from cavalcade.coordination import PlanSettings
from cavalcade.coordination.result import TeamPlan
from cavalcade.execution.loop import Execution
from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.policy import Policy
from cavalcade.execution.time_scaling import EXACT, WALKING
from cavalcade.execution.tracking_fleet import tracking_fleet
from cavalcade.fleet import Fleet, IdealFleet, LeapingFleet
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.jobs.footholds import plan_feet
from cavalcade.jobs.reporter import Reporter
from cavalcade.jobs.task import Task
from cavalcade.metrics.plan_result import PlanResult
from cavalcade.metrics.plan_summary import summarise_plan
from cavalcade.metrics.summary import Summary, rounded, rounded_each
from cavalcade.recording.frames import Recording
from cavalcade.scenario import ResolvedScenario, Scenario, World
from cavalcade.scenario.settings import Budget

SWAY = 0.05
"""Robots that walk are planned for as if their bodies were this much wider on all sides, m."""

Coordinator = Callable[[Scenario, World], TeamPlan]
"""What makes a team plan; tests and users may bring their own."""


class IndividualTask(Task):
    """Each robot goes to a goal of its own, as one plan for all says.

    Without a plan nobody moves, and the run ends at once with the planner's reason. A policy of
    somebody's own needs no plan: then it is a task like any other.
    """

    turning = 4.0  # plans turn from one bend into the next at once, and on the spot with this

    @property
    def budget(self) -> Budget:
        """None of the control loop: the scenario's is the search's."""
        return super().budget if self._policy is not None else Budget()

    @cached_property
    def planned(self) -> PlanResult | None:
        """The plan, made when it is first asked for."""
        if self._policy is not None:
            return None
        return make_plan(self.scenario, self.world, reporter=self.reporter)

    def ideal_fleet(self) -> Fleet:
        """Ideal robots with the limits that plans keep to."""
        if self.planned is None:
            return super().ideal_fleet()
        return tracking_fleet(self.scenario, self.planned.trajectories)

    def own_policy(self, fleet: Fleet) -> PlanFollower:
        """What follows the plan."""
        made, scenario = self._made, self.scenario
        refusal = None if made.solved else made.summary.detail or made.reason
        return PlanFollower(
            made.trajectories,
            scenario.models,
            scenario.starts,
            scenario.goals,
            scenario.execution.rate,
            refusal,
            EXACT if isinstance(fleet, IdealFleet) else WALKING,
            fleet if isinstance(fleet, LeapingFleet) else None,
            self.world.terrain,
        )

    def summarise(self, policy: Policy, done: Execution) -> Summary:
        """Of the run; planning is that of the plan, and what formations alone have is null."""
        if self.planned is None:
            return super().summarise(policy, done)
        made, planned = self.planned, self.planned.summary
        if not made.solved:
            outcome = replace(
                done.outcome,
                reason=made.reason,
                detail=planned.detail or "",
                involved=made.plan.involved,
            )
            done = replace(done, outcome=outcome)
        summary = super().summarise(policy, done)
        return replace(
            summary,
            wall_time_s=rounded((summary.wall_time_s or 0.0) + (planned.wall_time_s or 0.0)),
            leader_changes=None,
            role_changes=None,
            planning_time_s=planned.planning_time_s,
            lower_bound_m=planned.lower_bound_m,
            goal_moved_m=planned.goal_moved_m,
            margin_m=planned.margin_m,
            delay_s=rounded_each(cast(PlanFollower, policy).delays.tolist()),
        )

    def draw(self, recording: Recording, policy: Policy, summary: Summary, folder: Path) -> None:
        """The figures of the plan, as it was driven."""
        if self.planned is None:
            super().draw(recording, policy, summary, folder)
            return
        from cavalcade.drawing.plans import make_plan_figures

        shown = self._as_driven(recording, policy, summary)
        make_plan_figures(self.scenario, self.world, shown, folder)

    def write_replay(
        self, recording: Recording, policy: Policy, summary: Summary, path: Path
    ) -> None:
        """The replay of the plan, as it was driven."""
        if self.planned is None:
            super().write_replay(recording, policy, summary, path)
            return
        from cavalcade.drawing.replay.page import write_replay

        plan = self._as_driven(recording, policy, summary)
        write_replay(
            path, self.scenario, self.world, recording=recording, plan=plan, summary=summary
        )

    @property
    def _made(self) -> PlanResult:
        return cast(PlanResult, self.planned)

    def _as_driven(self, recording: Recording, policy: Policy, summary: Summary) -> PlanResult:
        made = replace(self._made, summary=summary)
        if not self._made.solved:
            return made
        return replace(made, plan=_as_driven(made, recording, cast(PlanFollower, policy)))


def make_plan(
    scenario: ResolvedScenario,
    world: World,
    coordinator: Coordinator | None = None,
    reporter: Reporter | None = None,
) -> PlanResult:
    """Plan and measure the plan, without files.

    Args:
        scenario: With individual goals.
        world: Its ground.
        coordinator: Instead of the scenario's method.
        reporter: Told what goes on.
    """
    started = clock.perf_counter()
    with (reporter or Reporter(scenario.name, quiet=True)).planning(scenario):
        team = (coordinator or coordinate)(scenario, world)
    footholds, stretches = plan_feet(scenario, world, team.trajectories)
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


def _as_driven(made: PlanResult, recording: Recording, follower: PlanFollower) -> TeamPlan:
    """The plan with the poses that were driven, at the heights and phases of the robots' progress.

    A robot's ends with the cycle in which its plan ends, or with the run.
    """
    driven: list[Trajectory | None] = []
    delays = follower.delays_at(recording.time)
    for robot, path in enumerate(made.trajectories):
        if path is None:
            driven.append(None)
            continue
        progress = recording.time - delays[:, robot]
        cycles = 1 + int(np.searchsorted(progress, path.duration - 1e-9))
        time, progress = recording.time[:cycles], progress[:cycles]
        poses = recording.poses[:cycles, robot]
        height = np.interp(progress, path.time, path.position[:, 2])
        position = np.column_stack([poses[:, :2], height])
        before = np.clip(np.searchsorted(path.time, progress + 1e-9) - 1, 0, len(path.time) - 1)
        velocity = np.gradient(position, time, axis=0) if len(time) > 1 else np.zeros((1, 3))
        driven.append(
            Trajectory(time, position, velocity, np.unwrap(poses[:, 2]), path.phase[before])
        )
    return replace(made.plan, trajectories=tuple(driven))
