"""What is recorded of one robot in physics, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cavalcade.checking.physics.rotations import matrices
from cavalcade.geometry import Array


@dataclass(frozen=True)
class Touch:
    """A recorded contact that is not a foot on the ground.

    Attributes:
        time: s.
        part: `trunk`, `hip`, `thigh`, `calf` or `foot`.
        other: `ground`, `obstacle` or `robot k`.
    """

    time: float
    part: str
    other: str


@dataclass(frozen=True)
class RobotRecord:
    """One robot's samples; legs front left, front right, rear left, rear right.

    Attributes:
        robot: Which.
        time: `(T,)` s, increasing.
        base: `(T, 7)` the trunk's frame in the map frame: x, y, z in m and quaternion w, x, y, z.
        joints: `(T, 12)` rad, per leg hip, thigh, calf.
        rates: `(T, 12)` rad/s.
        torques: `(T, 12)` N m, those of largest magnitude since the sample before.
        forces: `(T, 4, 3)` N, mean contact force on each foot since the sample before, map frame.
        touches: In order of time.
    """

    robot: int
    time: Array
    base: Array
    joints: Array
    rates: Array
    torques: Array
    forces: Array
    touches: tuple[Touch, ...] = ()

    @property
    def turn(self) -> Array:
        """Rotations `(T, 3, 3)` of the trunk, body to map."""
        return matrices(self.base[:, 3:])

    @property
    def steps(self) -> Array:
        """Durations `(T - 1,)` of the intervals between samples, s."""
        return self.time[1:] - self.time[:-1]


def records_from(
    time: Array,
    base: Array,
    joints: Array,
    rates: Array,
    torques: Array,
    forces: Array,
    touches: Sequence[Sequence[Touch]],
) -> tuple[RobotRecord, ...]:
    """The records of a team from arrays of all robots, as they would be read from a file.

    Args:
        time: `(T,)` s.
        base, joints, rates, torques, forces: `(T, N, ...)` as of `RobotRecord`.
        touches: Of each robot.
    """
    return tuple(
        RobotRecord(
            k,
            time,
            base[:, k],
            joints[:, k],
            rates[:, k],
            torques[:, k],
            forces[:, k],
            tuple(sorted(own, key=lambda touch: touch.time)),
        )
        for k, own in enumerate(touches)
    )
