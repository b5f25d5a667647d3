"""What touched what: read from the physics itself, and from nothing that leg control uses."""

from __future__ import annotations

import numpy as np

from cavalcade.fleet.mujoco._step import OTHERS, add_contacts
from cavalcade.fleet.mujoco.simulator import TeamSimulator
from cavalcade.geometry import Array
from cavalcade.recording.physics_track import ContactEvent
from cavalcade.robots.description import PARTS

QUIET = 0.1
"""A contact that was gone for longer begins anew, s."""

_ROOM = 256
"""Contacts that may begin in one step."""


class ContactRecorder:
    """Sums the forces on feet and lists all other contacts.

    `record` is to be called after every step of the simulator.

    Args:
        simulator: Whose contacts.
    """

    def __init__(self, simulator: TeamSimulator) -> None:
        team, size = simulator.team, simulator.size
        self._simulator = simulator
        self._data = simulator.data
        self._kinds = np.stack([team.geom_robot, team.geom_part, team.geom_leg], axis=1)
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
