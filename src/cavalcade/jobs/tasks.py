"""The kinds of task, and the one place where they are told apart."""

from __future__ import annotations

from dataclasses import replace

from cavalcade.execution.command_player import CommandPlayer
from cavalcade.execution.formation_policy import make_planner
from cavalcade.execution.loop import Execution
from cavalcade.execution.policy import Policy
from cavalcade.fleet import Fleet, LeapingFleet
from cavalcade.jobs.individual_task import IndividualTask
from cavalcade.jobs.reporter import Reporter
from cavalcade.jobs.task import PolicyMaker, Task
from cavalcade.metrics.command_tracking import summarise_commands
from cavalcade.metrics.summary import Summary
from cavalcade.scenario import ResolvedScenario, World


class FormationTask(Task):
    """A team keeps a formation whose centre visits goals."""

    def own_policy(self, fleet: Fleet) -> Policy:
        """The formation planner with its goals set."""
        return make_planner(self.scenario, self.world)


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


_TASKS: dict[str, type[Task]] = {
    "formation": FormationTask,
    "individual": IndividualTask,
    "commands": CommandTask,
}


def task_of(
    scenario: ResolvedScenario,
    world: World,
    reporter: Reporter,
    policy: PolicyMaker | Policy | None = None,
) -> Task:
    """The task of a scenario; arguments as of `Task`."""
    return _TASKS[scenario.task.kind](scenario, world, reporter, policy)
