"""What happens on the way: the `events` of a scenario file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cavalcade.scenario.fields import (
    Choice,
    Index,
    Number,
    Point,
    Pose,
    Positive,
    Seconds,
    Section,
    Speed,
)
from cavalcade.scenario.ground import Obstacle
from cavalcade.scenario.task import FormationSection


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


class Event(Choice):
    """One thing that happens `at` seconds of simulated time.

    `add` and `remove` an obstacle, `move` one, replace the `goals` or the `formation`, `lose` the
    robot of that index (from 0) or let it `rejoin`, `push` a robot in physics.
    """

    kinds = ("add", "remove", "move", "goals", "formation", "lose", "rejoin", "push")
    wanted = "expected `at` and exactly one thing that happens"

    at: Seconds
    add: Obstacle | None = None
    remove: Obstacle | None = None
    move: Move | None = None
    goals: Annotated[tuple[Pose, ...], Field(min_length=1, max_length=1000)] | None = None
    formation: FormationSection | None = None
    lose: Index | None = None
    rejoin: Index | None = None
    push: Push | None = None
