"""A scenario: everything one run needs, as its file says it.

The sections have modules of their own (`ground`, `task`, `settings`); this is the whole
with what must hold between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from pydantic import PrivateAttr, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from cavalcade.errors import ScenarioError
from cavalcade.robots import RobotModel
from cavalcade.scenario.fields import expected
from cavalcade.scenario.rules import BACKENDS, CHECKS, Parts, check_backend, with_planner_defaults
from cavalcade.scenario.settings import Event
from cavalcade.scenario.task import check_formation


class Scenario(Parts):
    """A validated scenario; immutable. Its file names are absolute after `load_scenario`."""

    _file: Path | None = PrivateAttr(default=None)

    @field_validator("name", "description")
    @classmethod
    def _printable(cls, text: str, info: ValidationInfo) -> str:
        text = text.strip()
        if not text.isprintable() or (info.field_name == "name" and not text):
            raise expected("expected one line of text")
        return text

    @model_validator(mode="before")
    @classmethod
    def _planner_of_the_task(cls, data: Any) -> Any:
        return with_planner_defaults(data)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        CHECKS[self.task.kind](self)
        check_backend(self)
        if self.task.formation is not None:
            self._check_formations()
        return self

    def _check_formations(self) -> None:
        width, whole = min(model.width for model in self.models), len(self.robots)
        check_formation(self.task.the_formation, whole, width, place="task.formation")
        lost: set[int] = set()
        for index, event in enumerate(self.execution.events):
            place = f"execution.events[{index}]"
            self._check_roll(event, lost, place)
            if event.formation is not None:
                team, place = whole - len(lost), f"{place}.formation"
                check_formation(event.formation, team, width, accepted=(whole,), place=place)

    def _check_roll(self, event: Event, lost: set[int], place: str) -> None:
        """Follow who is lost at the moment; `events` are in order of time."""
        robot = event.lose if event.lose is not None else event.rejoin
        if robot is None:
            return
        key = f"{place}.{event.kind}"
        if robot >= len(self.robots):
            raise expected(
                f"there is no robot {robot}; expected 0 to {len(self.robots) - 1}", key=key
            )
        if (robot in lost) == (event.kind == "lose"):
            state = "is lost already" if robot in lost else "is not lost"
            raise expected(f"robot {robot} {state} at {event.at:g} s", key=key)
        lost.symmetric_difference_update({robot})
        if len(lost) == len(self.robots):
            raise expected("no robot would be left", key=key)

    def with_file(self, file: Path | None) -> Self:
        """The same scenario, known to come from `file`."""
        changed = self.model_copy()
        changed._file = file
        return changed

    def with_models(self, models: Sequence[RobotModel]) -> Self:
        """The same scenario with these robots in the place of those that it names."""
        changed = self.model_copy()
        changed._models = tuple(models)
        return changed

    def with_backend(self, backend: str) -> Self:
        """The same scenario with another backend.

        Raises:
            ScenarioError: There is none of that name, or it cannot carry the scenario out.
        """
        if backend not in BACKENDS:
            raise ScenarioError(f"unknown backend {backend!r}", key="backend", choices=BACKENDS)
        execution = self.execution.model_copy(update={"backend": backend})
        changed = self.model_copy(update={"execution": execution})
        try:
            check_backend(changed)
        except PydanticCustomError as error:
            said = error.context or {}
            raise ScenarioError(
                str(said.get("text")),
                file=self.file,
                key=said.get("key"),
                choices=said.get("choices"),
            ) from None
        return changed

    def __eq__(self, other: object) -> bool:
        """By content, wherever it was read from."""
        if not isinstance(other, Scenario):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in Scenario.model_fields)

    def __hash__(self) -> int:
        return hash(tuple(getattr(self, name) for name in Scenario.model_fields))

    @property
    def file(self) -> Path | None:
        """The file it was read from, None if it was made in Python."""
        return self._file

    @property
    def starts(self) -> tuple[tuple[float, float, float], ...]:
        """The start (x, y, yaw) of each robot: m, m, rad, map frame."""
        return tuple(robot.start for robot in self.robots)

    @property
    def goals(self) -> tuple[tuple[float, float, float], ...]:
        """The goal (x, y, yaw) of each robot if goals are individual; else none."""
        return tuple(robot.goal for robot in self.robots if robot.goal is not None)

    @property
    def seed(self) -> int:
        """`execution.seed`."""
        return self.execution.seed


class ResolvedScenario(Scenario):
    """A scenario that says by itself everything that is run: see `resolve_scenario`."""

    @classmethod
    def of(cls, scenario: Scenario) -> ResolvedScenario:
        """The same content, taken for resolved."""
        fields = {name: getattr(scenario, name) for name in Scenario.model_fields}
        resolved = cls.model_construct(set(scenario.model_fields_set), **fields)
        resolved._file, resolved._models = scenario._file, scenario._models
        return resolved
