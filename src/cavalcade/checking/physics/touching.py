"""What robots touch by geometry: the ground, obstacles, the map, its border, each other.

Every solid part of a robot is filled with balls that do not reach beyond it, so that contact is
never seen where there is none: a capsule with balls along its axis, a box with points on its
surface. How deep a ball lies in the ground, an obstacle or another robot's solid is then a matter
of one distance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.ground import Floor
from cavalcade.checking.physics.kinematics import Posture
from cavalcade.checking.physics.rotations import matrices
from cavalcade.checking.solids import Scene, Solid
from cavalcade.geometry import Array, inverse_transform_points
from cavalcade.robots.description import BodyShape, QuadrupedDescription

Rows = NDArray[np.int64]

NEAR = 0.8
"""All of a robot is within this distance of its trunk's origin, m."""

SPACING = 0.04
"""Between points on a box, m."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """How deep a part of a robot is in something.

    Attributes:
        part: Which, of the robot.
        other: `ground`, `obstacle` or `robot k`.
        obstacle: For obstacles which, as in `Violation`.
        depth: `(T,)` m; negative where it is clear, -inf where it was not looked at.
    """

    part: str
    other: str
    obstacle: str
    depth: Array


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


def ground_overlaps(
    posture: Posture, description: QuadrupedDescription, floor: Floor
) -> Iterator[Overlap]:
    """Of all parts but feet with the ground."""
    for shape in description.solids:
        if shape.part == "foot":
            continue
        balls = _balls_of(shape, posture)
        low, _ = floor.range_at(balls.places[..., :2], balls.radius)
        depth = (low - balls.places[..., 2] + balls.radius).max(axis=1)
        yield Overlap(shape.part, "ground", "", depth)


def obstacle_overlaps(
    posture: Posture, description: QuadrupedDescription, scene: Scene
) -> Iterator[Overlap]:
    """Of all parts with obstacles, which stand on the ground and are higher than robots."""
    time, place = posture.time, posture.place[:, 0, :2]
    balls = [_balls_of(shape, posture) for shape in description.solids]
    for solid in scene.solids:
        offset = solid.offset_at(time)
        near = _near(solid.bounds, place - offset) & (time >= solid.start) & (time < solid.end)
        rows = np.flatnonzero(near)
        if len(rows):
            yield from _in_outline(balls, rows, solid, offset[rows], len(time))
    low, high = scene.blocks.min(axis=1), scene.blocks.max(axis=1)
    for corners, bounds in zip(scene.blocks, np.hstack((low, high)), strict=True):
        rows = np.flatnonzero(_near(bounds, place))
        if len(rows):
            block = Solid("map", corners)
            yield from _in_outline(balls, rows, block, block.offset, len(time))
    for one in balls:
        local = inverse_transform_points(scene.ground.origin, one.places[..., :2].reshape(-1, 2))
        beyond = np.maximum(-local, local - np.array(scene.ground.size)).max(axis=1)
        depth = (beyond.reshape(one.places.shape[:2]) + one.radius).max(axis=1)
        yield Overlap(one.shape.part, "obstacle", "border", depth)


def robot_overlaps(
    one: int, postures: dict[int, Posture], descriptions: dict[int, QuadrupedDescription]
) -> Iterator[Overlap]:
    """Of all parts of a robot with those of others; samples are those of one clock."""
    for two in postures:
        if two == one:
            continue
        apart = postures[one].place[:, 0] - postures[two].place[:, 0]
        rows = np.flatnonzero(np.linalg.norm(apart, axis=1) < 2.0 * NEAR)
        if not len(rows):
            continue
        for shape in descriptions[one].solids:
            balls = _balls_of(shape, postures[one])
            middle = _middle_of(shape, postures[one])
            depth = np.full(len(apart), -np.inf)
            for solid in descriptions[two].solids:
                gap = np.linalg.norm((middle - _middle_of(solid, postures[two]))[rows], axis=1)
                close = rows[gap < _radius_of(shape) + _radius_of(solid)]
                found = _distance_to(solid, postures[two], balls.places[close], close)
                deep = balls.radius - found.min(axis=1)
                depth[close] = np.maximum(depth[close], deep)
            yield Overlap(shape.part, f"robot {two}", "", depth)


def _near(bounds: Array, place: Array) -> NDArray[np.bool_]:
    away = np.maximum(np.maximum(bounds[:2] - place, place - bounds[2:]), 0.0)
    return np.hypot(*away.T) < NEAR


def _in_outline(
    balls: list[Balls], rows: Rows, solid: Solid, offset: Array, count: int
) -> Iterator[Overlap]:
    for one in balls:
        places = one.places[rows][..., :2] - offset[:, None]
        found = _outline_distance(places, solid.points) - solid.radius
        depth = np.full(count, -np.inf)
        depth[rows] = one.radius - found.min(axis=1)
        yield Overlap(one.shape.part, "obstacle", solid.key, depth)


def _outline_distance(places: Array, points: Array) -> Array:
    """Signed distances `(...)` of places `(..., 2)` from a polygon or a point `(P, 2)`."""
    if len(points) == 1:
        return np.linalg.norm(places - points[0], axis=-1)
    least = np.full(places.shape[:-1], np.inf)
    inside = np.zeros(places.shape[:-1], dtype=bool)
    for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
        edge, to = b - a, places - a
        along = np.clip((to @ edge) / max(float(edge @ edge), 1e-300), 0.0, 1.0)
        rest = to - along[..., None] * edge
        least = np.minimum(least, np.hypot(rest[..., 0], rest[..., 1]))
        turn = edge[0] * to[..., 1] - edge[1] * to[..., 0]
        spans = (a[1] > places[..., 1]) != (b[1] > places[..., 1])
        inside ^= spans & ((turn > 0.0) == (b[1] > a[1]))
    return np.where(inside, -least, least)


def _balls_of(shape: BodyShape, posture: Posture) -> Balls:
    """A solid filled with balls."""
    local, radius = _filled(shape)
    within = local @ matrices(np.array(shape.rotation)).T + np.array(shape.position)
    turn, place = posture.turn[:, shape.link], posture.place[:, shape.link]
    return Balls(shape, place[:, None] + np.einsum("txy,by->tbx", turn, within), radius)


def _middle_of(shape: BodyShape, posture: Posture) -> Array:
    """Where a solid's centre is, `(T, 3)` m."""
    link = shape.link
    return posture.place[:, link] + posture.turn[:, link] @ np.array(shape.position)


def _radius_of(shape: BodyShape) -> float:
    """Of the ball around a solid, m."""
    a, b, c = shape.size
    if shape.kind == "sphere":
        return a
    if shape.kind == "capsule":
        return a + b
    return float(np.hypot(a, b)) if shape.kind == "cylinder" else float(np.hypot(np.hypot(a, b), c))


def _distance_to(shape: BodyShape, posture: Posture, places: Array, rows: Rows) -> Array:
    """Signed distances `(K, B)` in m of points `(K, B, 3)` from a solid at samples `(K,)`."""
    turn = posture.turn[rows, shape.link] @ matrices(np.array(shape.rotation))
    local = (places - _middle_of(shape, posture)[rows][:, None]) @ turn
    return _signed_distance(shape.kind, local, np.array(shape.size))


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


def _signed_distance(kind: str, local: Array, size: Array) -> Array:
    """Distances `(...)` in m of points `(..., 3)` in a solid's own frame; negative inside."""
    x, y, z = np.moveaxis(local, -1, 0)
    if kind == "sphere":
        return np.linalg.norm(local, axis=-1) - size[0]
    if kind == "capsule":
        along = np.maximum(np.abs(z) - size[1], 0.0)
        return np.sqrt(x**2 + y**2 + along**2) - size[0]
    if kind == "cylinder":
        beyond = np.stack((np.hypot(x, y) - size[0], np.abs(z) - size[1]), axis=-1)
    else:
        beyond = np.abs(local) - size
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    return outside + np.minimum(beyond.max(axis=-1), 0.0)
