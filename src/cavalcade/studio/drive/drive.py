"""What the tab Drive drives: simulated robots or real ones, by the same words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Protocol

from cavalcade.robots import RobotModel
from cavalcade.scenario import ObstacleSpan, ResolvedScenario, World
from cavalcade.studio.drive.changes import Changes
from cavalcade.studio.snapshot import Snapshot

Pose = tuple[float, float, float]
"""x, y in m, yaw in rad, map frame."""

Phase = Literal["preparing", "running", "paused", "waiting", "stopped", "ended"]
"""`waiting`: it has come to its end, for now. `stopped`: real robots were, by a fault or by hand.
"""


class Drive(Protocol):
    """A team that is driven, from its start to its end; any thread may call it.

    What cannot be done raises an `InputError`.

    Attributes:
        live: Whether the robots are real ones, which move in a time of their own.
        changes: Told with all that `snapshot` may show anew.
    """

    live: bool
    changes: Changes

    def start(self) -> None:
        """Begin, in a thread of its own."""

    @property
    def phase(self) -> Phase:
        """What it does."""

    @property
    def words(self) -> str:
        """The same for people, with the reason and what to do."""

    @property
    def scenario(self) -> ResolvedScenario:
        """What is driven, with all that has happened."""

    @property
    def world(self) -> World:
        """Its ground, as of the start."""

    @property
    def models(self) -> tuple[RobotModel, ...]:
        """Each robot's."""

    @property
    def goals(self) -> tuple[Pose, ...]:
        """Poses of the formation's centre that are still to be driven to, the present one first.

        At the end the last one.
        """

    @property
    def lost(self) -> tuple[int, ...]:
        """Robots that are no part of the team."""

    @property
    def spans(self) -> tuple[ObstacleSpan, ...]:
        """Every obstacle over time."""

    def snapshot(self) -> Snapshot | None:
        """The newest moment; None before the first."""

    @property
    def refused(self) -> tuple[str, ...]:
        """Why changes that were asked for could not happen any more."""

    @property
    def planning(self) -> float:
        """How long the newest cycle took, s."""

    def pause(self) -> None:
        """Stand until `resume`."""

    def resume(self) -> None:
        """Go on."""

    def step(self) -> None:
        """Carry out one cycle."""

    def set_speed(self, speed: float) -> None:
        """Simulated seconds per second."""

    def stop(self) -> None:
        """End; what was done is kept."""

    def set_goals(self, goals: Sequence[Pose]) -> None:
        """Drive through these poses instead."""

    def set_formation(self, section: Mapping[str, Any]) -> None:
        """Change the shape, as `task.formation` of a file says it."""

    def add(self, obstacle: Mapping[str, Any]) -> None:
        """Put an obstacle down, as a file says it."""

    def remove(self, index: int) -> None:
        """Take an obstacle away, one of `spans`."""

    def move(self, index: int, to: tuple[float, float], speed: float) -> None:
        """Let an obstacle go there, m, at so many m/s; 0 puts it there at once."""

    def lose(self, robot: int) -> None:
        """Go on without a robot."""

    def rejoin(self, robot: int) -> None:
        """Take it back."""

    def push(self, robot: int, impulse: tuple[float, float]) -> None:
        """Push a robot in physics, N s, map frame."""

    def close(self) -> None:
        """End it and wait until it has."""

    @property
    def folder(self) -> Path | None:
        """Where the results are, once they are."""
