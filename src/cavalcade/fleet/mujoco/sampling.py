"""Keeps what happened to a team in physics: samples in memory, 50 a second."""

from __future__ import annotations

from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from cavalcade.fleet.mujoco._step import keep_peaks
from cavalcade.fleet.mujoco.contacts import ContactRecorder
from cavalcade.fleet.mujoco.simulator import TeamSimulator
from cavalcade.geometry import Array
from cavalcade.recording.physics_track import ContactEvent

SAMPLE_PERIOD = 0.02
"""Time between two samples, s."""


@dataclass(frozen=True)
class Samples:
    """N robots at T moments; map frame.

    Attributes:
        time: `(T,)` s.
        qpos: `(T, N, 19)` trunk's position in m and quaternion w, x, y, z, joint angles in rad.
        joint_rates: `(T, N, 12)` rad/s.
        torques: `(T, N, 12)` N m, of largest magnitude since the sample before.
        foot_forces: `(T, N, 4, 3)` N, mean of the contact forces since the sample before.
        contacts: In order of time, each when it begins and, while it lasts, between any two
            samples.
    """

    time: Array
    qpos: Array
    joint_rates: Array
    torques: Array
    foot_forces: Array
    contacts: tuple[ContactEvent, ...]


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
        self._recorder = ContactRecorder(simulator)
        self._known = 0
        self._peaks = np.zeros((size, 12))
        self._steps = 0
        self._time: list[float] = []
        self._qpos: list[Array] = []
        self._rates: list[Array] = []
        self._torques: list[Array] = []
        self._foot_forces: list[Array] = []
        self._contacts: list[ContactEvent] = []
        self._keep()

    def step(self) -> bool:
        """After a step of the simulator; True if it made a sample."""
        keep_peaks(self._simulator.torques, self._peaks)
        self._recorder.record()
        self._steps += 1
        if self._steps % self._every:
            return False
        self._keep()
        return True

    @property
    def time(self) -> float:
        """Time of the last sample, s."""
        return self._time[-1]

    @property
    def qpos(self) -> Array:
        """Positions and joint angles `(N, 19)` of the last sample."""
        return self._qpos[-1]

    @property
    def contacts(self) -> list[ContactEvent]:
        """All so far, as of `Samples`; not to be changed."""
        return self._contacts

    def samples(self) -> Samples:
        """Everything so far."""
        return Samples(
            time=np.array(self._time),
            qpos=np.array(self._qpos),
            joint_rates=np.array(self._rates),
            torques=np.array(self._torques),
            foot_forces=np.array(self._foot_forces),
            contacts=tuple(self._contacts),
        )

    def _keep(self) -> None:
        self._time.append(round(self._start + self._simulator.time, 9))
        self._qpos.append(self._simulator.qpos)
        self._rates.append(self._simulator.qvel[:, 6:])
        self._torques.append(self._peaks.copy())
        self._foot_forces.append(self._recorder.take_forces())
        self._peaks[:] = 0.0
        # Contacts that began since the last sample, and those that went on.
        begun = self._recorder.contacts[self._known :]
        self._known += len(begun)
        names = {(contact.robot, contact.part, contact.other) for contact in begun}
        lasting = (
            contact
            for contact in self._recorder.touching(self._every)
            if (contact.robot, contact.part, contact.other) not in names
        )
        found = sorted((*begun, *lasting), key=attrgetter("time"))
        self._contacts += (
            replace(contact, time=round(self._start + contact.time, 9)) for contact in found
        )
