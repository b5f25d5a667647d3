"""What a kind of task needs to be done: its policy, its fleet, its metrics and its drawings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

from cavalcade.execution.loop import Execution
from cavalcade.execution.policy import Policy
from cavalcade.fleet import CommandDelay, Fleet, IdealFleet, LocalisationNoise
from cavalcade.jobs.reporter import Reporter
from cavalcade.metrics.plan_result import PlanResult
from cavalcade.metrics.run_summary import summarise
from cavalcade.metrics.summary import Summary
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
        reporter: Reporter,
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
        """
        if self.scenario.execution.backend == "mujoco":
            from cavalcade.execution.physics_fleet import physics_fleet

            return physics_fleet(self.scenario, self.world, self.turning)
        return self.ideal_fleet()

    def ideal_fleet(self) -> Fleet:
        """Ideal robots with the scenario's noise and delays."""
        execution = self.scenario.execution
        return IdealFleet(
            self.scenario.models,
            self.scenario.starts,
            noise=LocalisationNoise(execution.noise.position, execution.noise.heading),
            delay=CommandDelay(execution.delay.mean, execution.delay.jitter, execution.delay.drop),
            seed=self.scenario.seed,
        )

    def make_policy(self, fleet: Fleet) -> Policy:
        """What says where these robots go.

        Raises:
            ScenarioError: The scenario's values are refused.
        """
        if self._policy is None:
            return self.own_policy(fleet)
        if isinstance(self._policy, Policy):
            return self._policy
        return self._policy(self.scenario, self.world)

    def own_policy(self, fleet: Fleet) -> Policy:
        """The policy that the task has by itself."""
        raise NotImplementedError

    def summarise(self, policy: Policy, done: Execution) -> Summary:
        """What it came to."""
        return summarise(self.scenario, self.world, done.recording, done.outcome)

    def draw(self, recording: Recording, policy: Policy, summary: Summary, folder: Path) -> None:
        """Its figures."""
        from cavalcade.drawing.formation import make_figures

        make_figures(self.scenario, self.world, recording, summary, folder)

    def write_replay(
        self, recording: Recording, policy: Policy, summary: Summary, path: Path
    ) -> None:
        """Its replay."""
        from cavalcade.drawing.replay.page import write_replay

        write_replay(path, self.scenario, self.world, recording=recording, summary=summary)
