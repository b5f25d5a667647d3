"""Tasks that tell robots what to do: velocities over time, or points to walk to."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from cavalcade.scenario.fields import (
    Choice,
    Index,
    Number,
    Point,
    Seconds,
    Speed,
    expected,
    in_time,
)

SPEED = 0.4
"""On the way to a point where nothing else is said, m/s."""

WAIT = 2.0
"""A task ends so long after its last command where nothing else is said, s."""

METHOD, VARIANT = "commands", "cavalcade"
"""What `planner` says of such a task."""


def _velocity(value: object) -> object:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise expected("expected [x, y, yaw rate]: m/s, m/s and rad/s, body frame")
    return value


_Component = Annotated[Number, Field(ge=-100, le=100)]
Velocity = Annotated[tuple[_Component, _Component, _Component], BeforeValidator(_velocity)]


class CommandSection(Choice):
    """What a robot, or all, are told at some time; it holds until they are told otherwise.

    Exactly one of `velocity`, `to` and `leap`. Before the first command robots stand. Of several at
    once the last counts.

    Attributes:
        at (s): When, in simulated time.
        robot: Which one, from 0; null is all.
        velocity (m/s, m/s, rad/s): [forwards, to the left, yaw rate] in the body frame.
        to (m): Walk straight to a point [x, y] of the map, looking there, and stand.
        leap (m): In physics: step up to what lies on the straight way to a point [x, y] of the map,
            leap over it and stand.
        speed (m/s): On the way `to` a point; 0.4 if not given.
    """

    kinds = ("velocity", "to", "leap")
    wanted = "expected `at` and exactly one of"

    at: Seconds
    robot: Index | None = None
    velocity: Velocity | None = None
    to: Point | None = None
    leap: Point | None = None
    speed: Speed | None = None

    @model_validator(mode="after")
    def _speed_to_a_point(self) -> Self:
        if self.to is None and self.speed is not None:
            raise expected("is for `to` alone", key="speed")
        return self

    @property
    def pace(self) -> float:
        """The speed on the way to a point, m/s."""
        return SPEED if self.speed is None else self.speed


Commands = Annotated[
    tuple[CommandSection, ...], Field(min_length=1, max_length=100_000), AfterValidator(in_time)
]
