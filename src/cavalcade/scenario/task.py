"""The team and what it is asked to do: robots, the formation and its goals."""

from __future__ import annotations

import math
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationInfo,
    field_validator,
    model_validator,
)

from cavalcade.errors import InputError
from cavalcade.robots import RobotModel, is_model_file, load_model, robot_model
from cavalcade.scenario.commands import WAIT, Commands
from cavalcade.scenario.fields import (
    File,
    Index,
    Length,
    NotNegative,
    Point,
    Pose,
    Positive,
    Section,
    below_file,
    checked_path,
    expected,
)

_SIZE_KEY = {
    "square": "side",
    "triangle": "side",
    "line": "spacing",
    "column": "spacing",
    "wedge": "spacing",
    "circle": "radius",
}
_SIZES = {"triangle": 1.15}  # the paper's; 1 m for all others
_SLOTS = {"square": 4, "triangle": 3}
INDIVIDUAL = "individual"
Kind = Literal["formation", "individual", "commands"]


class ModelSection(Section):
    """Something with a robot's model.

    Attributes:
        model: A known model's name, or a file (`*.yaml`) with one of your own.
    """

    model: str = "go1"

    _read: RobotModel | None = PrivateAttr(default=None)

    @field_validator("model")
    @classmethod
    def _below_the_file(cls, name: str, info: ValidationInfo) -> str:
        if not is_model_file(name):
            return name
        return str(below_file(Path(checked_path(name)), info))

    @model_validator(mode="after")
    def _known(self) -> Self:
        try:
            if is_model_file(self.model):
                self._read = load_model(self.model)
            else:
                robot_model(self.model)
        except InputError as error:
            text = ": ".join(part for part in (error.file, error.key, error.message) if part)
            raise expected(text, key="model", choices=error.choices) from None
        return self

    @property
    def the_model(self) -> RobotModel:
        """The model itself; one of a file as it was when this was read."""
        if not is_model_file(self.model):
            return robot_model(self.model)
        return self._read or load_model(self.model)


class RobotSection(ModelSection):
    """One robot.

    Attributes:
        start (m, m, rad): Pose [x, y, yaw] in the map frame at the beginning.
        goal (m, m, rad): Its own goal [x, y, yaw], with `task.goals: individual`.
        mjcf: A MuJoCo model of your own for physics: footprint and speeds are those of `model`,
            masses, joints and shapes of this file.
    """

    start: Pose
    goal: Pose | None = None
    mjcf: File | None = None


class ConnectionSection(Section):
    """A spring and damper between two slots (paper, section 2.5).

    A value that is null is the shape's own: the preset's for sides and diagonals.

    Attributes:
        a, b: The slots it joins, from 0.
        l0 (m): Rest length; null is the distance of the two slots.
        k_rep (1/(m s)): Stiffness when shortened.
        k_att (1/(m s)): Stiffness when stretched.
        dv_max_att (m/s): Largest change of velocity by attraction.
        b_att: Damping while the two approach.
        b_rep: Damping while they drift apart.
    """

    a: Index
    b: Index
    l0: Length | None = None
    k_rep: NotNegative | None = None
    k_att: NotNegative | None = None
    dv_max_att: NotNegative | None = None
    b_att: NotNegative | None = None
    b_rep: NotNegative | None = None


class FormationSection(Section):
    """A shape with its size: after loading, exactly the size that the shape needs is set.

    Of `side` and `spacing` each is taken for the other.

    Attributes:
        shape: Its name.
        side (m): Of a square (1.0 if not given) or triangle (1.15).
        spacing (m): Between neighbours of a line, column or wedge (1.0 if not given).
        radius (m): Of a circle (1.0 if not given).
        slots (m): Of a custom shape: points [x, y] in the formation's frame, x forward, the
            leader's first.
        connections: Springs; null means the shape's own, `[]` none.
    """

    shape: Literal["square", "line", "column", "wedge", "triangle", "circle", "custom"]
    side: Length | None = None
    spacing: Length | None = None
    radius: Length | None = None
    slots: Annotated[tuple[Point, ...], Field(min_length=1, max_length=256)] | None = None
    connections: Annotated[tuple[ConnectionSection, ...], Field(max_length=10_000)] | None = None

    @model_validator(mode="before")
    @classmethod
    def _size(cls, data: Any) -> Any:
        shape = data.get("shape") if isinstance(data, dict) else None
        if not isinstance(shape, str) or shape not in _SIZE_KEY:
            return data
        key = _SIZE_KEY[shape]
        same = {"side": "spacing", "spacing": "side"}.get(key)
        given = dict(data)
        if same and given.get(same) is not None and given.get(key) is None:
            given[key] = given.pop(same)
        if given.get(key) is None:
            given[key] = _SIZES.get(shape, 1.0)
        return given

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        wanted = _SIZE_KEY.get(self.shape, "slots")
        for key in ("side", "spacing", "radius", "slots"):
            if getattr(self, key) is None and key == wanted:
                raise expected("expected a list of points [x, y]", key=key)
            if getattr(self, key) is not None and key != wanted:
                raise expected(f"a {self.shape} takes no {key}; expected {wanted}", key=key)
        seen: set[frozenset[int]] = set()
        for index, joint in enumerate(self.connections or ()):
            pair = frozenset((joint.a, joint.b))
            if len(pair) == 1 or pair in seen:
                raise expected(
                    "expected two different slots, each pair once", key=f"connections[{index}]"
                )
            seen.add(pair)
        return self

    @property
    def slot_count(self) -> int | None:
        """How many robots the shape takes; None if any number."""
        return len(self.slots) if self.slots is not None else _SLOTS.get(self.shape)

    def closest_slots(self, robots: int) -> float:
        """Smallest distance between two slots in m for that many robots; inf for one robot."""
        if self.slots is not None:
            return min((math.dist(p, q) for p, q in combinations(self.slots, 2)), default=math.inf)
        if robots < 2:
            return math.inf
        if self.radius is not None:
            return 2.0 * self.radius * math.sin(math.pi / robots)
        return self.side or self.spacing or 0.0


def _goals_schema(schema: dict[str, Any]) -> None:
    """A list of poses, or the one word."""
    kept = {
        key: schema.pop(key) for key in ("type", "items", "minItems", "maxItems") if key in schema
    }
    schema["anyOf"] = [{**kept, "minItems": 1}, {"const": INDIVIDUAL, "type": "string"}]


def _task_schema(schema: dict[str, Any]) -> None:
    """Goals, or commands."""
    schema.pop("required", None)
    schema["anyOf"] = [{"required": ["goals"]}, {"required": ["commands"]}]


class TaskSection(Section):
    """What the team does: a formation that visits goals, a goal for each robot, or commands.

    Attributes:
        formation: The shape; with goals of its centre only.
        goals (m, m, rad): Poses [x, y, yaw] that the formation's centre visits in order; or
            `individual`: each robot has a `goal` of its own.
        commands: In the place of formation and goals: what robots do, without a planner.
        duration (s): How long commands last at least; by default until 2 s after the last one.
    """

    model_config = ConfigDict(json_schema_extra=_task_schema)

    formation: FormationSection | None = None
    goals: Annotated[tuple[Pose, ...], Field(max_length=1000, json_schema_extra=_goals_schema)]
    commands: Commands | None = None
    duration: Positive | None = None

    @model_validator(mode="before")
    @classmethod
    def _no_goals(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("commands") is None:
            return data
        for key in ("goals", "formation"):
            if data.get(key):
                raise expected("commands take the place of goals and formation", key=key)
        return {**data, "goals": ()}

    @field_validator("goals", mode="before")
    @classmethod
    def _poses(cls, value: Any) -> Any:
        if isinstance(value, str):
            if value != INDIVIDUAL:
                raise expected("expected poses [x, y, yaw] of the formation, or individual")
            return ()
        if isinstance(value, list) and not value:
            raise expected("expected at least 1, got 0")
        return value

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if self.commands is not None:
            return self
        if self.duration is not None:
            raise expected("is for commands", key="duration")
        individual = self.kind == INDIVIDUAL
        if individual and self.formation is not None:
            raise expected("individual goals take no formation", key="formation")
        if not individual and self.formation is None:
            wanted = ", ".join(FormationSection.model_fields)
            raise expected(f"missing; expected a mapping with {wanted}", key="formation")
        return self

    @property
    def kind(self) -> Kind:
        """What is to be done: keep a `formation`, reach `individual` goals, follow `commands`."""
        return kind_of(self.commands, self.goals)

    @property
    def headline(self) -> str:
        """What is to be done, in a word or two."""
        if self.commands is not None:
            return "commanded"
        return "individual goals" if self.formation is None else self.formation.shape

    @property
    def length(self) -> float:
        """How long commands take at least, s; 0 without."""
        if self.duration is not None or not self.commands:
            return self.duration or 0.0
        return self.commands[-1].at + WAIT

    @property
    def the_formation(self) -> FormationSection:
        """The formation of a task that has one.

        Raises:
            InputError: Goals are individual.
        """
        if self.formation is None:
            raise InputError("goals are individual; expected a formation", key="task.formation")
        return self.formation


def kind_of(commands: object, goals: object) -> Kind:
    """The kind of a task with these commands, None for none, and goals of the formation, if any."""
    if commands is not None:
        return "commands"
    return "formation" if goals else "individual"


def check_formation(
    formation: FormationSection,
    robots: int,
    width: float,
    accepted: tuple[int, ...] = (),
    place: str | None = None,
) -> None:
    """Refuse a formation that a team cannot take up.

    Args:
        width: Of a robot's body, m.
        accepted: Other numbers of slots that are right too.
        place: Its key, for errors; None where the formation itself is what is validated.

    Raises:
        PydanticCustomError: One line with the key and what was expected.
    """
    count = formation.slot_count
    if count is not None and count != robots and count not in accepted:
        text = f"the {formation.shape} has {count} slots, the team {robots} robots"
        raise expected(text, key=place)
    slots = robots if count is None else count
    for index, joint in enumerate(formation.connections or ()):
        if max(joint.a, joint.b) >= slots:
            key = f"{place}.connections[{index}]" if place else f"connections[{index}]"
            raise expected(f"expected slots 0 to {slots - 1}", key=key)
    if formation.closest_slots(slots) < width:
        raise expected(f"slots closer than a robot's width ({width:g} m)", key=place)
