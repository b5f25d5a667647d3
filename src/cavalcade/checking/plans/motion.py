"""One robot's planned motion, as `plan.npz` holds it, in order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.report import Kind, Violation, excesses
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array

WALK, TAKE_OFF, FLIGHT, LANDING = 0, 1, 2, 3
NAMES = ("walk", "take-off", "flight", "landing")

SPEED_ROUNDING = 1e-4
"""Of velocities, and of changes of position per interval's time, m/s or rad/s."""

POSITION_ROUNDING = 2e-5
"""Of changes of position, m."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Samples that are complete, finite and in order of time; afterwards the robot stands.

    Attributes:
        robot: Which.
        time: `(T,)` s, from 0.
        position, velocity: `(T, 3)` m and m/s, map frame.
        yaw: `(T,)` rad, without jumps.
        phase: `(T,)` of the motion from this sample to the next.
        footholds: `(M, 6)` t_down, t_up, leg, x, y, z; s and m.
    """

    robot: int
    time: Array
    position: Array
    velocity: Array
    yaw: Array
    phase: NDArray[np.int64]
    footholds: Array

    @property
    def steps(self) -> Array:
        """`(T - 1,)` time between samples, s."""
        return np.diff(self.time)

    @property
    def speed(self) -> Array:
        """`(T,)` seen from above, m/s."""
        return np.hypot(self.velocity[:, 0], self.velocity[:, 1])

    @property
    def mean_velocity(self) -> Array:
        """`(T - 1, 2)` over each interval, from positions, m/s."""
        return np.diff(self.position[:, :2], axis=0) / self.steps[:, None]

    @property
    def acceleration(self) -> Array:
        """`(T - 1, 3)` mean over each interval, m/s²."""
        return np.diff(self.velocity, axis=0) / self.steps[:, None]

    @property
    def yaw_rate(self) -> Array:
        """`(T - 1,)` mean over each interval, rad/s."""
        return np.diff(self.yaw) / self.steps

    @property
    def track(self) -> Track:
        """The motion seen from above."""
        return Track(self.time, np.column_stack((self.position[:, :2], self.yaw)))

    def phase_at(self, time: float) -> int:
        """The phase at a time in s; walking, which includes standing, outside the plan."""
        if not self.time[0] <= time < self.time[-1]:
            return WALK
        return int(self.phase[np.searchsorted(self.time, time, side="right") - 1])

    def excesses(
        self,
        kind: Kind,
        value: Array,
        limit: Array | float,
        words: str,
        slack: Array | float = 0.0,
    ) -> list[Violation]:
        """As `stretches.excesses`, of values at samples `(T,)` or over intervals `(T - 1,)`."""
        time = self.time[: len(value)]
        return excesses(kind, self.robot, time, value, limit, words, slack)

    def shortfalls(
        self, kind: Kind, value: Array, least: float, words: str, slack: float
    ) -> list[Violation]:
        """Likewise where `value < least - slack`."""
        time, short = self.time[: len(value)], least - value - slack
        return excesses(kind, self.robot, time, value, least, words, excess=short)
