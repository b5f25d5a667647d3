"""Masses with their centres and moments of inertia: adding them up and mirroring them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cavalcade.geometry import Array

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Inertial:
    """A rigid body's mass, seen in a frame fixed to it.

    Attributes:
        mass: kg.
        center: Centre of mass, m.
        inertia: xx, yy, zz, xy, xz, yz in kg m² about the centre of mass, along the frame's axes.
    """

    mass: float
    center: Vector
    inertia: tuple[float, float, float, float, float, float]

    @property
    def matrix(self) -> Array:
        """Inertia `(3, 3)` about the centre of mass, kg m²."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    def moved(self, offset: Vector) -> Inertial:
        """The same body seen in a parallel frame in which this frame's origin is at `offset`."""
        x, y, z = (float(a + b) for a, b in zip(self.center, offset, strict=True))
        return Inertial(self.mass, (x, y, z), self.inertia)

    def turned(self, rotation: Array) -> Inertial:
        """The same body seen in a frame with the same origin, which `rotation` `(3, 3)` leads to.

        A point p of this frame is at rotation p in that one.
        """
        x, y, z = (float(value) for value in rotation @ np.array(self.center))
        return Inertial(self.mass, (x, y, z), _moments(rotation @ self.matrix @ rotation.T))

    def mirrored(self, x: bool = False, y: bool = False) -> Inertial:
        """The mirror image with x or y (or both) the other way round."""
        sx, sy = (-1.0 if x else 1.0), (-1.0 if y else 1.0)
        xx, yy, zz, xy, xz, yz = self.inertia
        center = (sx * self.center[0], sy * self.center[1], self.center[2])
        return Inertial(self.mass, center, (xx, yy, zz, sx * sy * xy, sx * xz, sy * yz))


def combined(bodies: Iterable[Inertial]) -> Inertial:
    """One body made of several that are seen in the same frame."""
    parts = tuple(bodies)
    mass = sum(part.mass for part in parts)
    center = sum((part.mass * np.array(part.center) for part in parts), np.zeros(3)) / mass
    total = np.zeros((3, 3))
    for part in parts:
        arm = np.array(part.center) - center
        total += part.matrix + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    x, y, z = (float(value) for value in center)
    return Inertial(float(mass), (x, y, z), _moments(total))


def _moments(matrix: Array) -> tuple[float, float, float, float, float, float]:
    """xx, yy, zz, xy, xz, yz of a symmetric matrix `(3, 3)`."""
    rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
    xx, yy, zz, xy, xz, yz = (float(value) for value in matrix[rows, columns])
    return xx, yy, zz, xy, xz, yz
