"""The parts of a scenario, before they are looked at together."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, PrivateAttr

from cavalcade.robots import RobotModel
from cavalcade.scenario.fields import Section
from cavalcade.scenario.ground import WorldSection
from cavalcade.scenario.settings import ExecutionSection, PlannerSection
from cavalcade.scenario.task import RobotSection, TaskSection


class Parts(Section):
    """The sections of a scenario file, as the rules of its task and backend see them."""

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
