"""The seam between planning and robots: what a fleet of any kind offers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cavalcade.geometry import Array


@dataclass(frozen=True)
class Observation:
    """What is known of the team at one moment.

    Attributes:
        time: Now, s.
        poses: `(N, 3)` the newest pose report of each robot: x, y in m, yaw in rad, map frame.
            May hold nan for a robot that has reported nonsense; that is what a watchdog is for.
        stamps: `(N,)` when each of these poses was measured, s.
    """

    time: float
    poses: Array
    stamps: Array


class Fleet(Protocol):
    """Robots that take velocity commands: perfect ones, simulated ones, real ones."""

    @property
    def size(self) -> int:
        """Number of robots."""

    @property
    def time(self) -> float:
        """The fleet's clock, s."""

    def observe(self) -> Observation:
        """The team's state as a planner may know it."""

    def send(self, commands: Array) -> None:
        """Command body-frame velocities `(N, 3)`: m/s, m/s, rad/s. They hold until the next."""

    def advance(self, dt: float) -> None:
        """Let `dt` seconds pass."""

    def true_poses(self) -> Array:
        """`(N, 3)` true poses now, for recording and judging only."""

    def true_velocities(self) -> Array:
        """`(N, 3)` true velocities now, map frame: m/s, m/s, rad/s."""
