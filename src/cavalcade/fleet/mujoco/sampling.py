"""Keeps what happened to a team in physics: bodies, joints, forces and contacts, 50 times a second.

It is read from the physics itself, and from nothing that leg control uses.
"""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter

import numpy as np

from cavalcade.fleet.mujoco._step import OTHERS, add_contacts, keep_peaks
from cavalcade.fleet.mujoco.simulator import TeamSimulator
from cavalcade.geometry import Array
from cavalcade.recording.physics_track import ContactEvent, FallEvent, PhysicsTrack
from cavalcade.robots.description import PARTS

SAMPLE_PERIOD = 0.02
"""Time between two samples, s."""

QUIET = 0.1
"""A contact that was gone for longer begins anew, s."""

_ROOM = 256
"""Contacts that may begin in one step."""


class ContactRecorder:
    """Sums the forces on feet and lists all other contacts.

    `record` is to be called after every step of the simulator.
    """

    def __init__(self, simulator: TeamSimulator) -> None:
        size = simulator.size
        self._simulator = simulator
        self.follow()
        self._quiet = round(QUIET / simulator.settings.step)
        self._impulses = np.zeros((size, 4, 3))
        self._seen = np.full((size, len(PARTS), OTHERS + size), -1)
        self._begun = np.zeros((_ROOM, 3), dtype=np.int64)
        self._names = ("ground", "obstacle", *(f"robot {k}" for k in range(size)))
        self._steps, self._taken = 0, 0
        self._contacts: list[ContactEvent] = []
        # Arrays of at most one contact count as contiguous, others do not: compiled for both now.
        contact = self._data.contact
        self._add(contact.geom[:0], contact.frame[:0], contact.efc_address[:0])

    def follow(self) -> None:
        """The simulator's world has been compiled anew."""
        team = self._simulator.team
        self._data = self._simulator.data
        self._kinds = np.stack([team.geom_robot, team.geom_part, team.geom_leg], axis=1)

    @property
    def contacts(self) -> tuple[ContactEvent, ...]:
        """All that began so far, in order of time."""
        return tuple(self._contacts)

    def record(self) -> None:
        """Add the contacts of the simulator's last step."""
        contact = self._data.contact
        begun = self._add(contact.geom, contact.frame, contact.efc_address)
        self._steps += 1
        if begun:
            time = self._simulator.time
            for robot, part, other in self._begun[:begun].tolist():
                self._contacts.append(ContactEvent(time, robot, PARTS[part], self._names[other]))

    def touching(self, steps: int) -> list[ContactEvent]:
        """What was in contact during the last `steps` recorded steps, at the last time of each."""
        since = max(self._steps - steps, 0)
        step = self._simulator.settings.step
        begin = self._simulator.time - self._steps * step
        now = self._seen >= since
        places, lasts = np.argwhere(now).tolist(), self._seen[now].tolist()
        return [
            ContactEvent(begin + (last + 1) * step, robot, PARTS[part], self._names[other])
            for (robot, part, other), last in zip(places, lasts, strict=True)
        ]

    def take_forces(self) -> Array:
        """`(N, 4, 3)` N: mean force on each foot since the last call, map frame; starts anew.

        It is zero where no step was recorded since.
        """
        mean = self._impulses / max(self._steps - self._taken, 1)
        self._impulses[:] = 0.0
        self._taken = self._steps
        return mean

    def _add(self, geoms: Array, frames: Array, rows: Array) -> int:
        contacts = (geoms, frames, rows, self._data.efc_force)
        return add_contacts(
            contacts, self._kinds, self._steps, self._quiet, self._impulses, self._seen, self._begun
        )


class Sampler:
    """Looks at a simulator after each of its steps.

    The first sample is that of its start, when the clock shows `time` s.

    Attributes:
        contacts: In order of time, each when it begins and, while it lasts, between any two
            samples.
    """

    def __init__(self, simulator: TeamSimulator, time: float) -> None:
        self._simulator = simulator
        self._start = time
        self._every = max(1, round(SAMPLE_PERIOD / simulator.settings.step))
        self._recorder = ContactRecorder(simulator)
        self._known = 0
        self._peaks = np.zeros((simulator.size, 12))
        self._steps = 0
        # Time, positions, joint rates, torques and forces on feet of each sample.
        self._kept: list[tuple[float, Array, Array, Array, Array]] = []
        self.contacts: list[ContactEvent] = []
        self._keep()

    def follow(self) -> None:
        """The simulator's world has been compiled anew."""
        self._recorder.follow()

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
        return self._kept[-1][0]

    @property
    def qpos(self) -> Array:
        """Positions and joint angles `(N, 19)` of the last sample."""
        return self._kept[-1][1]

    def track(self, start: float, falls: tuple[FallEvent, ...]) -> PhysicsTrack:
        """Everything so far, in time since the clock showed `start` s."""
        time, qpos, rates, torques, forces = map(np.array, zip(*self._kept, strict=True))
        return PhysicsTrack(
            time=(time - start).round(9),
            base=qpos[..., :7],
            joints=qpos[..., 7:],
            joint_rates=rates,
            torques=torques,
            foot_forces=forces,
            contacts=tuple(
                replace(contact, time=round(contact.time - start, 9)) for contact in self.contacts
            ),
            falls=falls,
        )

    def forget(self) -> None:
        """Let go of all samples but the last, and of all contacts."""
        del self._kept[:-1]
        self.contacts.clear()

    def _keep(self) -> None:
        simulator, forces = self._simulator, self._recorder.take_forces()
        time = round(self._start + simulator.time, 9)
        rates = simulator.qvel[:, 6:]
        self._kept.append((time, simulator.qpos, rates, self._peaks.copy(), forces))
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
        self.contacts += (
            replace(contact, time=round(self._start + contact.time, 9)) for contact in found
        )
