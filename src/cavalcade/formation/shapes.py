"""Formation shapes: slots and the springs between them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import minimum_spanning_tree

from cavalcade.errors import InputError
from cavalcade.formation.settings import SIMULATION_SPRINGS, SpringLaw, Springs
from cavalcade.geometry import Array, transform_points
from cavalcade.values import (
    described,
    instance_of,
    instances_of,
    number_array,
    number_in,
    whole_number,
)

SHAPES = ("square", "line", "column", "wedge", "triangle", "circle", "custom")
MAX_ROBOTS = 1000
"""Largest number of slots: each pair of them may have a spring."""
_SIDE = 1.15  # pairs up to this multiple of the least distance are sides
_DIAGONAL = 1.55  # and up to this one diagonals


@dataclass(frozen=True)
class Connection:
    """A spring-damper between two slots.

    Attributes:
        a, b: Slot indices.
        rest_length: The paper's l0, m.
        law: Its stiffnesses and dampings.
    """

    a: int
    b: int
    rest_length: float
    law: SpringLaw

    def __post_init__(self) -> None:
        for name in ("a", "b"):
            whole_number(getattr(self, name), f"connection.{name}")
        number_in(self.rest_length, "connection.rest_length", 0.0)
        instance_of(self.law, SpringLaw, "connection.law")


@dataclass(frozen=True, eq=False)
class Formation:
    """A shape: slots in the formation's frame (x forward), the leader's first.

    Attributes:
        name: One of `SHAPES`.
        slots: `(N, 2)` m, read-only.
        connections: The springs between slots.

    Raises:
        InputError: An unknown name, malformed slots, two slots on one spot, or a connection of
            unknown slots.
    """

    name: str
    slots: Array
    connections: tuple[Connection, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or self.name not in SHAPES:
            raise InputError(f"unknown shape {described(self.name)}", key="name", choices=SHAPES)
        slots = number_array(self.slots, "slots", (None, 2), "(N, 2) slots in m")
        whole_number(len(slots), "slots", 1, MAX_ROBOTS)
        if len(slots) > 1 and _least_distance(slots) < 1e-6:
            raise InputError("two slots stand on one spot", key="slots")
        slots.setflags(write=False)
        object.__setattr__(self, "slots", slots)
        for c in instances_of(self.connections, Connection, "connections"):
            if not (0 <= c.a < self.size and 0 <= c.b < self.size and c.a != c.b):
                raise InputError(
                    f"connection {c.a}-{c.b}: expected two different slots of 0..{self.size - 1}",
                    key="connections",
                )
        object.__setattr__(self, "connections", tuple(self.connections))

    @property
    def size(self) -> int:
        """Number of slots."""
        return len(self.slots)

    @property
    def spacing(self) -> float:
        """Least distance between two slots, m; 0 for a single slot."""
        return _least_distance(self.slots)

    @classmethod
    def square(cls, side: float = 1.0, springs: Springs = SIMULATION_SPRINGS) -> Formation:
        """Four robots, one corner ahead."""
        r = _length(side, "side") / math.sqrt(2.0)
        return cls._of("square", [(r, 0), (0, r), (-r, 0), (0, -r)], springs)

    @classmethod
    def triangle(cls, side: float = 1.15, springs: Springs = SIMULATION_SPRINGS) -> Formation:
        """Three robots, one corner ahead."""
        r = _length(side, "side") / math.sqrt(3.0)
        return cls._of("triangle", [(r, 0), (-r / 2, side / 2), (-r / 2, -side / 2)], springs)

    @classmethod
    def line(
        cls, robots: int, spacing: float = 1.0, springs: Springs = SIMULATION_SPRINGS
    ) -> Formation:
        """Side by side; the leader in the middle (left of it, if their number is even)."""
        n, spacing = _count(robots), _length(spacing, "spacing")
        offsets = (np.arange(n) - (n - 1) / 2) * spacing
        order = sorted(offsets, key=lambda y: (round(abs(y), 9), -y))
        return cls._of("line", [(0.0, y) for y in order], springs)

    @classmethod
    def column(
        cls, robots: int, spacing: float = 1.0, springs: Springs = SIMULATION_SPRINGS
    ) -> Formation:
        """One behind the other."""
        n, spacing = _count(robots), _length(spacing, "spacing")
        return cls._of("column", [(((n - 1) / 2 - k) * spacing, 0.0) for k in range(n)], springs)

    @classmethod
    def wedge(
        cls, robots: int, spacing: float = 1.0, springs: Springs = SIMULATION_SPRINGS
    ) -> Formation:
        """A V of two arms at 45 degrees, its tip ahead."""
        n, spacing = _count(robots), _length(spacing, "spacing")
        step = spacing / math.sqrt(2.0)
        slots = [(0.0, 0.0)]
        for k in range(1, n):
            row = (k + 1) // 2
            slots.append((-row * step, row * step * (1.0 if k % 2 else -1.0)))
        centred = np.array(slots) - [np.mean([x for x, _ in slots]), 0.0]
        return cls._of("wedge", centred, springs)

    @classmethod
    def circle(
        cls, robots: int, radius: float = 1.0, springs: Springs = SIMULATION_SPRINGS
    ) -> Formation:
        """Evenly spread on a circle, the leader ahead."""
        n, radius = _count(robots), _length(radius, "radius")
        angles = 2.0 * np.pi * np.arange(n) / n
        reach = radius if n > 1 else 0.0
        slots = np.column_stack([reach * np.cos(angles), reach * np.sin(angles)])
        return cls._of("circle", slots, springs)

    @classmethod
    def custom(
        cls,
        slots: ArrayLike,
        connections: Iterable[Connection] | None = None,
        springs: Springs = SIMULATION_SPRINGS,
    ) -> Formation:
        """Any slots `(N, 2)`, the leader's first.

        Args:
            slots: m, in the formation's frame.
            connections: The springs; None joins close neighbours.
            springs: Laws of these default connections.

        Raises:
            InputError: Malformed slots, two slots on one spot, or a connection of unknown slots.
        """
        made = cls._of("custom", slots, springs)
        return made if connections is None else made.connected(connections)

    def connected(self, connections: Iterable[Connection]) -> Formation:
        """The same shape with other springs."""
        given = instances_of(connections, Connection, "connections")
        return Formation(self.name, self.slots, given)

    def placed(self, pose: Sequence[float] | Array) -> Array:
        """Slots `(N, 2)` with the formation's centre at `pose` (x, y, yaw)."""
        pose = number_array(pose, "pose", (3,), "a pose (x, y, yaw)")
        return transform_points(pose, self.slots)

    def smaller(self, robots: int) -> Formation:
        """A sensible shape for fewer robots: of the same kind and spacing where there is one."""
        robots = _count(robots)
        gap = self.spacing if self.size > 1 else 1.0
        laws = [c.law for c in sorted(self.connections, key=lambda c: c.rest_length)]
        springs = Springs(laws[0], laws[-1]) if laws else SIMULATION_SPRINGS
        if robots == self.size:
            return self
        if robots == 1:
            return Formation._of(self.name, [(0.0, 0.0)], springs)
        if self.name == "square" and robots == 3:
            return Formation.triangle(gap, springs)
        if self.name == "circle":
            return Formation.circle(robots, gap / (2.0 * math.sin(math.pi / robots)), springs)
        if self.name in ("line", "wedge"):
            return getattr(Formation, self.name)(robots, gap, springs)
        if self.name == "custom" and 2 < robots < self.size:
            kept = self.slots[:robots]
            return Formation._of("custom", kept - kept.mean(axis=0), springs)
        return Formation.column(robots, gap, springs)

    @classmethod
    def _of(cls, name: str, slots: ArrayLike, springs: Springs) -> Formation:
        instance_of(springs, Springs, "springs")
        bare = cls(name, slots, ())  # type: ignore[arg-type]
        return cls(name, bare.slots, _default_connections(bare.slots, springs))


def _default_connections(slots: Array, springs: Springs) -> tuple[Connection, ...]:
    """Sides between nearest neighbours, diagonals between the next, and what keeps it in one."""
    n = len(slots)
    if n < 2:
        return ()
    length = np.linalg.norm(slots[:, None] - slots[None], axis=-1)
    least = _least_distance(slots)
    tree = minimum_spanning_tree(np.triu(length)).toarray() > 0.0
    found = []
    for a in range(n):
        for b in range(a + 1, n):
            side = length[a, b] <= _SIDE * least or tree[a, b] or tree[b, a]
            if side or length[a, b] <= _DIAGONAL * least:
                law = springs.sides if side else springs.diagonals
                found.append(Connection(a, b, float(length[a, b]), law))
    return tuple(found)


def _least_distance(slots: Array) -> float:
    if len(slots) < 2:
        return 0.0
    length = np.linalg.norm(slots[:, None] - slots[None], axis=-1)
    return float(length[np.triu_indices(len(slots), 1)].min())


def _length(value: float, key: str) -> float:
    number = number_in(value, key, 0.0, unit="m")
    if number == 0.0:
        raise InputError("expected a length above 0 m, got 0", key=key)
    return number


def _count(robots: int) -> int:
    return whole_number(robots, "robots", 1, MAX_ROBOTS)
