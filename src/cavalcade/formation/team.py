"""Who takes part, in which shape."""

from __future__ import annotations

import copy
from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError
from cavalcade.formation._shaping import SPRING
from cavalcade.formation.shapes import Formation
from cavalcade.values import instance_of, whole_number


class Team:
    """The robots, those that are lost, and the shape of those that are not.

    Attributes:
        present: `(N,)` robots that take part.
        formation: The shape they form now.
    """

    def __init__(self, size: int, formation: Formation) -> None:
        self.size = size
        self.present = np.ones(size, dtype=bool)
        self._full = formation
        self._use(formation)

    def copy(self) -> Team:
        """One that stays as this one is now."""
        other = copy.copy(self)
        other.present = self.present.copy()
        return other

    @property
    def active(self) -> NDArray[np.int64]:
        """Indices of the robots that take part."""
        return np.nonzero(self.present)[0]

    def set_formation(self, formation: Formation) -> None:
        """Change the shape; it has a slot for every robot, or for every one that takes part."""
        count = len(self.active)
        instance_of(formation, Formation, "formation")
        if formation.size not in (self.size, count):
            raise InputError(
                f"the shape {formation.name} has {formation.size} slots for {count} robots",
                key="formation",
            )
        self._full = formation
        self._reshape()

    def lose(self, robot: int) -> None:
        """Take a robot out; the others get a smaller shape."""
        self._set_present(robot, False)

    def rejoin(self, robot: int) -> None:
        """Take it back."""
        self._set_present(robot, True)

    def joined(self, roles: NDArray[np.int64]) -> NDArray[np.int64]:
        """Pairs of robots `(C, 2)` that the shape's connections join under these roles."""
        pairs = self.pairs(roles)
        return pairs[(pairs >= 0).all(axis=1)]

    def pairs(self, roles: NDArray[np.int64]) -> NDArray[np.int64]:
        """The same for all connections, -1 where a slot is empty."""
        robot_of = np.full(self.formation.size + 1, -1, dtype=np.int64)
        robot_of[roles] = np.arange(len(roles))
        robot_of[-1] = -1
        return robot_of[self.ends]

    def _set_present(self, robot: int, present: bool) -> None:
        if not 0 <= whole_number(robot, "robot") < self.size:
            raise InputError(f"there is no robot {robot} in 0..{self.size - 1}", key="robot")
        self.present[robot] = present
        self._reshape()

    def _reshape(self) -> None:
        count = len(self.active)
        if count > 0:
            full = self._full
            self._use(full if full.size == count else full.smaller(count))

    def _use(self, formation: Formation) -> None:
        self.formation = formation
        joints = formation.connections
        self.ends = np.array([(c.a, c.b) for c in joints], dtype=np.int64).reshape(-1, 2)
        laws = [(c.rest_length, *astuple(c.law)) for c in joints]
        self.springs = np.array(laws, dtype=SPRING)
