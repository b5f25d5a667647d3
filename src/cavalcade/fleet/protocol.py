"""The seam between planning and robots: what a fleet of any kind offers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording.physics_track import PhysicsTrack


@dataclass(frozen=True)
class Fault:
    """Something because of which the team must not go on.

    Attributes:
        robot: The robot that it is about; None for the whole team, such as of a clock.
        kind: One word for it, of those of `cavalcade.execution.supervisor` or what a fleet knows
            of its robots itself, such as `frame`.
        detail: More about it for people, without the robot's name; may be empty.
    """

    robot: int | None
    kind: str
    detail: str = ""

    def __str__(self) -> str:
        where = "" if self.robot is None else f": robot {self.robot}"
        return f"{self.kind}{where}" + (f" ({self.detail})" if self.detail else "")


@dataclass(frozen=True)
class Observation:
    """What is known of the team at one moment.

    Attributes:
        time: Now, s.
        poses: `(N, 3)` the newest pose report of each robot: x, y in m, yaw in rad, map frame.
            May hold nan for a robot that has reported nonsense; that is what a supervisor is for.
        stamps: `(N,)` when each of these poses was measured, s.
        faults: What the fleet itself knows to be wrong now, such as a report in a wrong frame.
    """

    time: float
    poses: Array
    stamps: Array
    faults: tuple[Fault, ...] = ()


@runtime_checkable
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


@runtime_checkable
class LiveFleet(Fleet, Protocol):
    """Robots that move in a time of their own, whether or not anybody plans.

    `advance` waits until the next cycle is due. Any thread may call `observe` and `send`. True
    poses and velocities are the best that is known.
    """

    def start(self, timeout: float) -> None:
        """Connect, and wait until every robot has been heard.

        Raises:
            FleetError: Somebody was not heard within `timeout` s; it says who and where.
        """

    def close(self) -> None:
        """Command all robots to stop and leave; a second call does nothing."""


@runtime_checkable
class DampingFleet(LiveFleet, Protocol):
    """Robots whose e-stop damps their motors, so that they sink to the ground."""

    def damp(self, robot: int | None = None) -> None:
        """Damp a robot or all, until `start` has them stand up again; from any thread."""


@dataclass(frozen=True)
class Fall:
    """A robot that fell.

    Attributes:
        time: s.
        robot: Which.
        cause: One of `tilt`, `height` and `trunk` (which touched the ground).
    """

    time: float
    robot: int
    cause: str


@runtime_checkable
class FallingFleet(Fleet, Protocol):
    """A fleet whose robots can fall."""

    @property
    def falls(self) -> tuple[Fall, ...]:
        """The first fall of each robot that fell, in order of time."""


@runtime_checkable
class SampledFleet(FallingFleet, Protocol):
    """A fleet in physics, which keeps bodies, joints, forces and contacts over time."""

    def track(self, start: float = 0.0) -> PhysicsTrack:
        """What was kept so far, in time since the clock showed `start` s."""


@dataclass(frozen=True)
class LeapRequest:
    """A leap as it was planned; map frame, of the body's centre.

    Attributes:
        take_off: `(4,)` pose x, y, z in m, yaw in rad at which the legs begin to push.
        landed: `(4,)` pose at which the landing ends.
        edges: m along the straight line from `take_off` to `landed`: where the ground of the
            take-off ends and where that of the landing begins, the same for a step; None where
            the ground is unknown or does not break.
    """

    take_off: Array
    landed: Array
    edges: tuple[float, float] | None


@runtime_checkable
class LeapingFleet(Fleet, Protocol):
    """A fleet whose robots carry out a leap by themselves, once they are told to.

    A plain `Fleet` follows leaps as it follows everything else: by velocity commands.
    """

    @property
    def approach(self) -> float:
        """How long before a take-off, in planned time, it wants to be handed the robot, s."""

    def leap(self, robot: int, request: LeapRequest) -> None:
        """Take the robot over until it has landed and stands or walks; it may take its time.

        Commands that are sent to it meanwhile are of no effect.
        """

    @property
    def leaping(self) -> NDArray[np.bool_]:
        """`(N,)` whether the robot was handed over and has not been given back."""

    @property
    def leap_failed(self) -> NDArray[np.bool_]:
        """`(N,)` whether the robot's last leap failed; a robot that fails is given back."""
