"""The scenario that is being built: plain data as in its file, checked at every step.

A draft may lack things that can be added yet, such as robots or a goal; what contradicts the rules
of scenario files is refused, in the words that a file would be refused with.
"""

from __future__ import annotations

import copy
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.errors import ScenarioError
from cavalcade.robots import RobotModel, is_model_file
from cavalcade.scenario import (
    ResolvedScenario,
    Scenario,
    World,
    check_starts,
    make_world,
    parse_scenario,
    resolve_scenario,
    scenario_text,
)
from cavalcade.scenario.fields import OneLine
from cavalcade.scenario.ground import WorldSection
from cavalcade.scenario.overrides import apply_overrides
from cavalcade.scenario.shipped import find_scenario, read_text
from cavalcade.scenario.spellings import with_current_spelling
from cavalcade.scenario.task import INDIVIDUAL
from cavalcade.studio.build.completing import completed
from cavalcade.yaml_text import parse_yaml

Pose = tuple[float, float, float]
"""x, y in m, yaw in rad, map frame."""

STEPS = 500
"""How many steps can be undone."""

EMPTY: Mapping[str, Any] = {
    "version": 1,
    "name": "my-scenario",
    "world": {"empty": {"size": [14.0, 10.0]}},
}
"""What a new draft holds."""


@dataclass(frozen=True)
class Checked:
    """Data that may stand in a draft.

    Attributes:
        data: The data itself; must not be changed.
        scenario: The same, None while something is missing.
        missing: What is missing, in words; None if nothing is.
        shown: The scenario to show: with stand-ins for what is missing.
        world: Its ground.
        plan_notes, ground_notes: What is probably not meant, in words, and of the ground alone.
        source, seed: What the ground was made of.
    """

    data: dict[str, Any]
    scenario: Scenario | None
    missing: str | None
    shown: ResolvedScenario
    world: World
    plan_notes: tuple[str, ...]
    ground_notes: tuple[str, ...]
    source: WorldSection
    seed: int

    @property
    def notes(self) -> tuple[str, ...]:
        """What is probably not meant, in words."""
        return (*self.ground_notes, *self.plan_notes)

    @property
    def without_stand_ins(self) -> ResolvedScenario:
        """The scenario as a scene may show it: with no goals where some are missing."""
        if self.missing is None:
            return self.shown
        robots = tuple(one.model_copy(update={"goal": None}) for one in self.shown.robots)
        task = self.shown.task.model_copy(update={"goals": (), "formation": None})
        return self.shown.model_copy(update={"robots": robots, "task": task})

    @property
    def robots(self) -> tuple[tuple[RobotModel, Pose], ...]:
        """Model and start of each robot that there is; stand-ins are none."""
        count = len(self.data.get("robots") or ())
        return tuple(zip(self.shown.models[:count], self.shown.starts[:count], strict=True))

    @property
    def goals(self) -> tuple[Pose, ...]:
        """Goals of the formation, or of each robot, as far as there are any."""
        task = self.data.get("task") or {}
        if task.get("goals") == INDIVIDUAL:
            return self.shown.goals[: len(self.robots)]
        return self.shown.task.goals if task.get("goals") else ()


class Draft:
    """A scenario that is built step by step; each step can be undone and done again.

    Attributes:
        changed: Called after every change.
    """

    def __init__(self) -> None:
        self.changed: list[Callable[[], None]] = []
        self._state = _check(copy.deepcopy(dict(EMPTY)), None)
        self._steps = [self._state.data]  # the data alone: grounds can be large
        self._now = 0

    @property
    def state(self) -> Checked:
        """What it holds at the moment."""
        return self._state

    @property
    def data(self) -> dict[str, Any]:
        """Plain data as in a file, with absolute names of files; must not be changed."""
        return self.state.data

    @property
    def scenario(self) -> Scenario | None:
        """The scenario; None while something is missing."""
        return self.state.scenario

    @property
    def error(self) -> str | None:
        """What is missing before it is a scenario; None if nothing is."""
        return self.state.missing

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        return self._now > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step."""
        return self._now < len(self._steps) - 1

    def set(self, path: str, value: Any) -> None:
        """Change a value; None takes it away.

        Args:
            path: Dotted, as with `--set`: `robots[0].start`, `planner.lookahead`.
            value: Plain data.

        Raises:
            InputError: The draft would be none; it stays as it was.
        """
        top = path.partition(".")[0].partition("[")[0]
        data = dict(self.data)
        if top in data:
            data[top] = copy.deepcopy(data[top])
        apply_overrides(data, {path: plain(value)}, None)
        self.replace(without_nulls(data))

    def replace(self, data: Mapping[str, Any]) -> None:
        """Put other data in the place of all there is.

        Raises:
            InputError: They make no draft; it stays as it was.
        """
        checked = self.check(data)
        if checked.data == self.data:
            return
        self._state = checked
        self._steps = [*self._steps[: self._now + 1], checked.data][-STEPS:]
        self._now = len(self._steps) - 1
        self._tell()

    def check(self, data: Mapping[str, Any]) -> Checked:
        """What the draft would hold with these data.

        Raises:
            InputError: They make no draft.
        """
        return _check(plain(data), self.state)

    def undo(self) -> bool:
        """Take the last step back; whether there was one.

        Raises:
            InputError: A file that was used then is not there any more.
        """
        return self._go(self._now - 1)

    def redo(self) -> bool:
        """Do again what was undone; whether there was something."""
        return self._go(self._now + 1)

    def load(self, name_or_file: str | Path) -> None:
        """Take over a shipped scenario, a file or what a run has left in its folder.

        Raises:
            InputError: It cannot be used; the draft stays as it was.
        """
        file = find_scenario(name_or_file)
        data = parse_yaml(read_text(file), file=str(file))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # they are told when the draft is checked
            parse_scenario(data, file)
            data = with_current_spelling(data, file)
        try:
            self.replace(without_nulls(with_names(data, lambda name: _below(file, name))))
        except ScenarioError as error:
            raise error.at(file=error.file or file, key=error.key) from None

    def export(self, folder: Path | None = None) -> str:
        """The YAML of a file that `cavalcade run` takes.

        Args:
            folder: Names of files are relative to it; None: they are absolute.

        Raises:
            ScenarioError: Something is missing.
        """
        if self.scenario is None:
            raise ScenarioError(self.error or "is not finished", key="draft")
        data = self.data
        if folder is not None:
            here = folder.resolve()
            data = with_names(data, lambda name: Path(os.path.relpath(name, here)).as_posix())
        return text_of(data)

    def _go(self, index: int) -> bool:
        if not 0 <= index < len(self._steps):
            return False
        self._state = _check(self._steps[index], self._state)
        self._now = index
        self._tell()
        return True

    def _tell(self) -> None:
        for act in tuple(self.changed):
            act()


def text_of(data: Mapping[str, Any]) -> str:
    """Data of a scenario as YAML, with each obstacle, robot and event on a line."""
    lined = {**data}
    for section, key in (("world", "obstacles"), (None, "robots"), ("execution", "events")):
        place = data if section is None else data.get(section)
        if place is None or not place.get(key):
            continue
        lines = [OneLine(item) for item in place[key]]
        if section is None:
            lined[key] = lines
        else:
            lined[section] = {**lined[section], key: lines}
    return scenario_text(lined)


def plain(value: Any) -> Any:
    """Values of numpy, tuples and paths as a file has them; all in copies of their own."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    return str(value) if isinstance(value, str | Path) else value


def without_nulls(data: Any) -> Any:
    """The same without keys that say nothing, and without mappings that then say nothing."""
    if isinstance(data, list):
        return [without_nulls(item) for item in data]
    if not isinstance(data, dict):
        return data
    said = ((key, item, without_nulls(item)) for key, item in data.items() if item is not None)
    return {key: new for key, item, new in said if new != {} or item == {}}


def with_names(data: Mapping[str, Any], change: Callable[[str], str]) -> dict[str, Any]:
    """A valid scenario's data with other names of files."""
    changed: dict[str, Any] = copy.deepcopy(dict(data))
    world = changed["world"]
    places = [(world, "map"), (world, "terrain")]
    places += [(world.get(kind) or {}, "file") for kind in ("movingai", "barn")]
    for robot in changed.get("robots") or ():
        places.append((robot, "mjcf"))
        if is_model_file(robot.get("model", "")):
            places.append((robot, "model"))
    for place, key in places:
        if place.get(key) is not None:
            place[key] = change(str(place[key]))
    return changed


def names_of(data: Mapping[str, Any]) -> list[str]:
    """The files that a valid scenario's data name."""
    found: list[str] = []

    def note(name: str) -> str:
        found.append(name)
        return name

    with_names(data, note)
    return found


def _below(file: Path, name: str) -> str:
    return os.path.normpath(file.resolve().parent / name)


def _check(data: dict[str, Any], before: Checked | None) -> Checked:
    """Check data as a file would be; what is known of `before` is not made again."""
    missing: str | None = None
    scenario: Scenario | None = None
    with _heard() as said:
        try:
            whole = scenario = parse_scenario(data)
        except ScenarioError as error:
            filled = completed(data)
            if filled == data:
                raise
            missing, whole = str(error), parse_scenario(filled)
    shown = _resolved(whole, before)
    if before is not None and _same_ground(shown, before.shown):
        world, ground_notes = before.world, before.ground_notes
    else:
        with _heard() as ground_said:
            world = make_world(shown)
        ground_notes = _words(ground_said)
    if data.get("robots"):
        check_starts(shown, world.base, world.shapes, world.terrain)
    return Checked(
        data, scenario, missing, shown, world, _words(said), ground_notes, whole.world, whole.seed
    )


@contextmanager
def _heard() -> Iterator[list[warnings.WarningMessage]]:
    """Warnings, for the page instead of the terminal."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        yield said


def _words(said: Iterable[warnings.WarningMessage]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(str(one.message) for one in said))


def _resolved(whole: Scenario, before: Checked | None) -> ResolvedScenario:
    """With the obstacles that were generated already, where they would be the same."""
    if before is not None and (before.source, before.seed) == (whole.world, whole.seed):
        return ResolvedScenario.of(whole.model_copy(update={"world": before.shown.world}))
    return resolve_scenario(whole)


def _same_ground(one: Scenario, other: Scenario) -> bool:
    return (
        one.world == other.world
        and one.planner.despeckle == other.planner.despeckle
        and one.execution.events == other.execution.events
    )
