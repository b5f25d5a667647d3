"""The parts of a scenario that rules look at together."""

from __future__ import annotations

from typing import Protocol

from cavalcade.robots import RobotModel
from cavalcade.scenario.ground import WorldSection
from cavalcade.scenario.settings import ExecutionSection, PlannerSection
from cavalcade.scenario.task import RobotSection, TaskSection


class Parts(Protocol):
    """A scenario, as the rules of its task and backend see it."""

    @property
    def world(self) -> WorldSection:
        """Where it takes place."""

    @property
    def robots(self) -> tuple[RobotSection, ...]:
        """The team as the file names it."""

    @property
    def models(self) -> tuple[RobotModel, ...]:
        """The model of each robot."""

    @property
    def task(self) -> TaskSection:
        """What the team is to do."""

    @property
    def planner(self) -> PlannerSection:
        """How it plans."""

    @property
    def execution(self) -> ExecutionSection:
        """How the plan is carried out."""
