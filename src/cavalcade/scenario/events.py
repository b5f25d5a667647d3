"""What happens on the way: the `events` of a scenario file."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from cavalcade.scenario.fields import (
    Index,
    Number,
    Point,
    Pose,
    Positive,
    Seconds,
    Section,
    Speed,
    expected,
)
from cavalcade.scenario.obstacles import Obstacle
from cavalcade.scenario.task import FormationSection

EventKind = Literal["add", "remove", "move", "goals", "formation", "lose", "rejoin", "push"]
KINDS: tuple[EventKind, ...] = (
    *("add", "remove", "move", "goals", "formation", "lose", "rejoin", "push"),
)


class Move(Obstacle):
    """An obstacle that goes straight until its centre is at `to` (m), at `speed` m/s.

    If an obstacle of exactly this shape stands there, it is this one that moves; otherwise it
    appears and moves.
    """

    to: Point
    speed: Speed

    @property
    def obstacle(self) -> Obstacle:
        """The shape alone."""
        return Obstacle.model_construct(box=self.box, circle=self.circle, polygon=self.polygon)


Impulse = Annotated[Number, Field(ge=-1e4, le=1e4)]


class Push(Section):
    """A push on the trunk of a robot in physics: `impulse` x, y in N s, map frame, over `duration`.

    It begins with the planner's cycle.
    """

    robot: Index
    impulse: tuple[Impulse, Impulse]
    duration: Annotated[Positive, Field(le=10)] = 0.1


class Event(Section):
    """One thing that happens `at` seconds of simulated time.

    `add` and `remove` an obstacle, `move` one, replace the `goals` or the `formation`, `lose` the
    robot of that index (from 0) or let it `rejoin`, `push` a robot in physics.
    """

    at: Seconds
    add: Obstacle | None = None
    remove: Obstacle | None = None
    move: Move | None = None
    goals: Annotated[tuple[Pose, ...], Field(min_length=1, max_length=1000)] | None = None
    formation: FormationSection | None = None
    lose: Index | None = None
    rejoin: Index | None = None
    push: Push | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if sum(getattr(self, kind) is not None for kind in KINDS) != 1:
            raise expected("expected `at` and exactly one thing that happens", choices=KINDS)
        return self

    @property
    def kind(self) -> EventKind:
        """Which of the things happens."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @property
    def value(self) -> Any:
        """What its key says: an `Obstacle`, a `Move`, poses, a formation, an index, a `Push`."""
        return getattr(self, self.kind)
