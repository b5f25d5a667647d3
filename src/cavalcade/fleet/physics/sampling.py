"""Keeps what happened to a team in physics: samples in memory, 50 a second."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cavalcade.fleet.physics._sampling import keep_peaks
from cavalcade.fleet.physics.simulator import TeamSimulator
from cavalcade.geometry import Array

SAMPLE_PERIOD = 0.02
"""Between two samples, s."""


@dataclass(frozen=True)
class Touch:
    """A contact that is not a foot on the ground, in one interval between samples.

    Attributes:
        time: When it was seen first in that interval, s.
        robot: Whose.
        part: `trunk`, `hip`, `thigh`, `calf` or `foot`.
        other: `ground`, `obstacle` or `robot k`.
    """

    time: float
    robot: int
    part: str
    other: str


@dataclass(frozen=True)
class Samples:
    """N robots at T moments; map frame.

    Attributes:
        time: `(T,)` s.
        qpos: `(T, N, 19)` trunk's position in m and quaternion w, x, y, z, joint angles in rad.
        joint_rates: `(T, N, 12)` rad/s.
        torques: `(T, N, 12)` N m, of largest magnitude since the sample before.
        foot_forces: `(T, N, 4, 3)` N, mean of the contact forces since the sample before.
        touches: In order of time.
    """

    time: Array
    qpos: Array
    joint_rates: Array
    torques: Array
    foot_forces: Array
    touches: tuple[Touch, ...]


class Sampler:
    """Looks at a simulator after each of its steps.

    Args:
        simulator: At its start, which is the first sample.
        time: The clock then, s.
    """

    def __init__(self, simulator: TeamSimulator, time: float) -> None:
        self._simulator = simulator
        self._start = time
        self._every = max(1, round(SAMPLE_PERIOD / simulator.settings.step))
        size = simulator.size
        self._peaks = np.zeros((size, 12))
        self._forces = np.zeros((size, 4, 3))
        self._steps = 0
        self._time: list[float] = []
        self._qpos: list[Array] = []
        self._rates: list[Array] = []
        self._torques: list[Array] = []
        self._foot_forces: list[Array] = []
        self._touches: list[Touch] = []
        self._keep()

    def step(self) -> bool:
        """After a step of the simulator; True if it made a sample."""
        keep_peaks(self._simulator.torques, self._peaks)
        self._forces[..., 2] += self._simulator.foot_forces
        self._steps += 1
        if self._steps % self._every:
            return False
        self._keep()
        return True

    @property
    def time(self) -> float:
        """Of the last sample, s."""
        return self._time[-1]

    @property
    def qpos(self) -> Array:
        """`(N, 19)` of the last sample."""
        return self._qpos[-1]

    @property
    def touches(self) -> list[Touch]:
        """All so far, in order of time."""
        return self._touches

    def samples(self) -> Samples:
        """Everything so far."""
        return Samples(
            time=np.array(self._time),
            qpos=np.array(self._qpos),
            joint_rates=np.array(self._rates),
            torques=np.array(self._torques),
            foot_forces=np.array(self._foot_forces),
            touches=tuple(self._touches),
        )

    def _keep(self) -> None:
        self._time.append(round(self._start + self._simulator.time, 9))
        self._qpos.append(self._simulator.qpos)
        self._rates.append(self._simulator.qvel[:, 6:])
        self._torques.append(self._peaks.copy())
        self._foot_forces.append(self._forces / self._every)
        self._peaks[:] = 0.0
        self._forces[:] = 0.0
