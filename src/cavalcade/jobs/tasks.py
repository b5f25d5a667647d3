"""The kinds of task: each with its policy, its fleet and its metrics. They are told apart here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, cast

from cavalcade.execution.command_player import CommandPlayer
from cavalcade.execution.fleets import (
    go2_fleet,
    ideal_fleet,
    physics_fleet,
    ros2_fleet,
    tracking_fleet,
)
from cavalcade.execution.formation_policy import make_planner
from cavalcade.execution.loop import Execution
from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.policy import Policy
from cavalcade.execution.time_scaling import EXACT, WALKING
from cavalcade.fleet import Fleet, IdealFleet, LeapingFleet
from cavalcade.jobs.driven import driven_plan
from cavalcade.jobs.planning import make_plan
from cavalcade.jobs.reporter import JobReporter
from cavalcade.metrics.command_tracking import summarise_commands
from cavalcade.metrics.plan_summary import PlanResult
from cavalcade.metrics.run_summary import summarise
from cavalcade.metrics.summary import Summary, rounded, rounded_each
from cavalcade.recording.frames import Recording
from cavalcade.scenario import ResolvedScenario, World
from cavalcade.scenario.settings import Budget

PolicyMaker = Callable[[ResolvedScenario, World], Policy]


class Task:
    """A scenario on its ground, to be carried out under a policy of somebody's own.

    The kinds of task derive from it and say what they do otherwise.

    Args:
        scenario: The resolved one.
        world: Its ground.
        reporter: Told what goes on.
        policy: Makes the policy, or is it; None for the task's own.
    """

    turning: ClassVar[float | None] = None
    """Change of the yaw rate that walking robots are allowed, rad/s²; None for the gait's own."""

    def __init__(
        self,
        scenario: ResolvedScenario,
        world: World,
        reporter: JobReporter,
        policy: PolicyMaker | Policy | None = None,
    ) -> None:
        self.scenario = scenario
        self.world = world
        self.reporter = reporter
        self._policy = policy

    @property
    def budget(self) -> Budget:
        """Of the control loop."""
        return self.scenario.planner.budget

    @property
    def planned(self) -> PlanResult | None:
        """The plan that is carried out, if there is one."""
        return None

    def make_fleet(self) -> Fleet:
        """The robots at their starts, as the scenario's backend moves them.

        Raises:
            InputError: What the backend needs is not installed.
            FleetError: A robot of the real world is not heard.
        """
        if self.scenario.execution.backend == "ros2":
            return ros2_fleet(self.scenario)
        if self.scenario.execution.backend == "unitree":
            return go2_fleet(self.scenario)
        if self.scenario.execution.backend == "mujoco":
            return physics_fleet(self.scenario, self.world, self.turning)
        return self.ideal_fleet()

    def ideal_fleet(self) -> Fleet:
        """Ideal robots with the scenario's noise and delays."""
        return ideal_fleet(self.scenario)

    def make_policy(self, fleet: Fleet) -> Policy:
        """What says where these robots go.

        Raises:
            ScenarioError: The scenario's values are refused.
        """
        if self._policy is None:
            return self.own_policy(fleet)
        # A class that makes policies has all their attributes, too.
        if isinstance(self._policy, type) or not isinstance(self._policy, Policy):
            return self._policy(self.scenario, self.world)
        return self._policy

    def own_policy(self, fleet: Fleet) -> Policy:
        """The policy that the task has by itself."""
        raise NotImplementedError

    def summarise(self, policy: Policy, done: Execution) -> Summary:
        """What it came to."""
        return summarise(self.scenario, self.world, done.recording, done.outcome)

    def driven_plan(
        self, policy: Policy, recording: Recording, summary: Summary
    ) -> PlanResult | None:
        """The plan as it was driven, with the run's summary, for figures and replay."""
        return None


class FormationTask(Task):
    """A team keeps a formation whose centre visits goals."""

    def own_policy(self, fleet: Fleet) -> Policy:
        """The formation planner with its goals set."""
        return make_planner(self.scenario, self.world)


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
        made, scenario = cast(PlanResult, self.planned), self.scenario
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

    def driven_plan(
        self, policy: Policy, recording: Recording, summary: Summary
    ) -> PlanResult | None:
        """With the motion that came of it, if it was solved."""
        made = self.planned
        if made is None:
            return None
        if made.solved:
            made = driven_plan(made, recording, cast(PlanFollower, policy), self.scenario)
        return replace(made, summary=summary)


class CommandTask(Task):
    """Robots do what they are told, without a planner."""

    def own_policy(self, fleet: Fleet) -> Policy:
        """What plays the commands."""
        leaper = fleet if isinstance(fleet, LeapingFleet) else None
        return CommandPlayer(self.scenario, self.world.terrain, leaper)

    def summarise(self, policy: Policy, done: Execution) -> Summary:
        """With how well commanded velocities were followed."""
        events = self.scenario.execution.events
        pushes = [(event.at, event.push.robot) for event in events if event.push is not None]
        commanded = summarise_commands(done.recording, pushes)
        return replace(super().summarise(policy, done), commanded=commanded)


TASKS: dict[str, type[Task]] = {
    "formation": FormationTask,
    "individual": IndividualTask,
    "commands": CommandTask,
}
"""By the kind that a scenario's `task` has."""
