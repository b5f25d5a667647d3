"""A robot's solid parts: what of one lies how deep in something else.

Every solid is filled with balls that do not reach beyond it, so that contact is never seen where
there is none: a capsule with balls along its axis, a box with points on its surface. How deep a
ball lies in the ground, an obstacle or another robot's solid is then a matter of one distance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.physics.kinematics import Posture
from cavalcade.checking.physics.rotations import matrices
from cavalcade.geometry import Array
from cavalcade.robots.description import BodyShape

SPACING = 0.04
"""Between points on a box, m."""


@dataclass(frozen=True, eq=False)
class Balls:
    """The balls of one solid over all samples.

    Attributes:
        shape: The solid.
        places: `(T, B, 3)` centres in the map frame, m.
        radius: m; 0 for points.
    """

    shape: BodyShape
    places: Array
    radius: float


def balls_of(shape: BodyShape, posture: Posture) -> Balls:
    """A solid filled with balls."""
    local, radius = _filled(shape)
    within = local @ matrices(np.array(shape.rotation)).T + np.array(shape.position)
    turn, place = posture.turn[:, shape.link], posture.place[:, shape.link]
    return Balls(shape, place[:, None] + np.einsum("txy,by->tbx", turn, within), radius)


def middle_of(shape: BodyShape, posture: Posture) -> Array:
    """Where a solid's centre is, `(T, 3)` m."""
    link = shape.link
    return posture.place[:, link] + posture.turn[:, link] @ np.array(shape.position)


def radius_of(shape: BodyShape) -> float:
    """Of the ball around a solid, m."""
    a, b, c = shape.size
    if shape.kind == "sphere":
        return a
    if shape.kind == "capsule":
        return a + b
    return float(np.hypot(a, b)) if shape.kind == "cylinder" else float(np.hypot(np.hypot(a, b), c))


def distance_to(
    shape: BodyShape, posture: Posture, places: Array, rows: NDArray[np.int64]
) -> Array:
    """Signed distances `(K, B)` in m of points `(K, B, 3)` from a solid at samples `rows` `(K,)`.

    Negative inside.
    """
    turn = posture.turn[rows, shape.link] @ matrices(np.array(shape.rotation))
    local = (places - middle_of(shape, posture)[rows][:, None]) @ turn
    return _DISTANCES[shape.kind](local, np.array(shape.size))


def _filled(shape: BodyShape) -> tuple[Array, float]:
    a, b, _ = shape.size
    if shape.kind == "sphere":
        return np.zeros((1, 3)), a
    if shape.kind == "capsule":
        return _axis(b, a), a
    if shape.kind == "cylinder":
        around = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
        ring = np.column_stack((a * np.cos(around), a * np.sin(around)))
        heights = _axis(b, SPACING)[:, 2]
        points = [np.column_stack((ring, np.full(12, height))) for height in heights]
        return np.concatenate(points), 0.0
    half = np.array(shape.size)
    lines = [np.linspace(-h, h, max(2, round(2.0 * h / SPACING) + 1)) for h in half]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    surface = (np.abs(np.abs(grid) - half) < 1e-9).any(axis=1)
    return grid[surface], 0.0


def _axis(half: float, spacing: float) -> Array:
    """Points along z from -half to half."""
    z = np.linspace(-half, half, max(2, int(np.ceil(2.0 * half / spacing)) + 1))
    return np.column_stack((np.zeros_like(z), np.zeros_like(z), z))


def _to_sphere(local: Array, size: Array) -> Array:
    return np.linalg.norm(local, axis=-1) - size[0]


def _to_capsule(local: Array, size: Array) -> Array:
    along = np.maximum(np.abs(local[..., 2]) - size[1], 0.0)
    return np.sqrt(local[..., 0] ** 2 + local[..., 1] ** 2 + along**2) - size[0]


def _to_cylinder(local: Array, size: Array) -> Array:
    beyond = np.stack(
        (np.hypot(local[..., 0], local[..., 1]) - size[0], np.abs(local[..., 2]) - size[1]), axis=-1
    )
    return _from_excess(beyond)


def _to_box(local: Array, size: Array) -> Array:
    return _from_excess(np.abs(local) - size)


def _from_excess(beyond: Array) -> Array:
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    return outside + np.minimum(beyond.max(axis=-1), 0.0)


_DISTANCES: dict[str, Callable[[Array, Array], Array]] = {
    "sphere": _to_sphere,
    "capsule": _to_capsule,
    "cylinder": _to_cylinder,
    "box": _to_box,
}
