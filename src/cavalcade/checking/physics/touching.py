"""What robots touch by geometry: the ground, obstacles, the map, its border, each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.physics.floor import Floor
from cavalcade.checking.physics.kinematics import Posture
from cavalcade.checking.physics.solids import (
    Balls,
    balls_of,
    distance_to,
    middle_of,
    radius_of,
)
from cavalcade.checking.solids import Scene, Solid
from cavalcade.geometry import Array, inverse_transform_points
from cavalcade.robots.description import QuadrupedDescription

Rows = NDArray[np.int64]

NEAR = 0.8
"""All of a robot is within this distance of its trunk's origin, m."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """How deep a part of a robot is in something.

    Attributes:
        robot, part, leg: Whose.
        other: `ground`, `obstacle` or `robot k`.
        obstacle: For obstacles which, as in `Violation`.
        depth: `(T,)` m; negative where it is clear, -inf where it was not looked at.
    """

    robot: int
    part: str
    leg: int
    other: str
    obstacle: str
    depth: Array


def ground_overlaps(
    robot: int, posture: Posture, description: QuadrupedDescription, floor: Floor
) -> Iterator[Overlap]:
    """Of all parts but feet with the ground."""
    for shape in description.solids:
        if shape.part == "foot":
            continue
        balls = balls_of(shape, posture)
        low, _ = floor.range_at(balls.places[..., :2], balls.radius)
        depth = (low - balls.places[..., 2] + balls.radius).max(axis=1)
        yield Overlap(robot, shape.part, shape.leg, "ground", "", depth)


def obstacle_overlaps(
    robot: int, posture: Posture, description: QuadrupedDescription, scene: Scene
) -> Iterator[Overlap]:
    """Of all parts with obstacles, which stand on the ground and are higher than robots."""
    time, place = posture.time, posture.place[:, 0, :2]
    balls = [balls_of(shape, posture) for shape in description.solids]
    for solid in scene.solids:
        offset = solid.offset_at(time)
        near = _near(solid.bounds, place - offset) & (time >= solid.start) & (time < solid.end)
        rows = np.flatnonzero(near)
        if len(rows):
            yield from _in_outline(robot, balls, rows, solid, offset[rows], len(time))
    low, high = scene.blocks.min(axis=1), scene.blocks.max(axis=1)
    for corners, bounds in zip(scene.blocks, np.hstack((low, high)), strict=True):
        rows = np.flatnonzero(_near(bounds, place))
        if len(rows):
            still = np.zeros((1, 2))
            block = Solid("map", corners, 0.0, 0.0, np.inf, np.zeros(1), still)
            yield from _in_outline(robot, balls, rows, block, still, len(time))
    for one in balls:
        local = inverse_transform_points(scene.origin, one.places[..., :2].reshape(-1, 2))
        beyond = np.maximum(-local, local - np.array(scene.size)).max(axis=1)
        depth = (beyond.reshape(one.places.shape[:2]) + one.radius).max(axis=1)
        yield Overlap(robot, one.shape.part, one.shape.leg, "obstacle", "border", depth)


def robot_overlaps(
    postures: dict[int, Posture], descriptions: dict[int, QuadrupedDescription]
) -> Iterator[Overlap]:
    """Of all parts with those of other robots; samples are those of one clock."""
    for one, two in permutations(postures, 2):
        apart = postures[one].place[:, 0] - postures[two].place[:, 0]
        rows = np.flatnonzero(np.linalg.norm(apart, axis=1) < 2.0 * NEAR)
        if not len(rows):
            continue
        for shape in descriptions[one].solids:
            balls = balls_of(shape, postures[one])
            middle = middle_of(shape, postures[one])
            depth = np.full(len(apart), -np.inf)
            for solid in descriptions[two].solids:
                gap = np.linalg.norm((middle - middle_of(solid, postures[two]))[rows], axis=1)
                close = rows[gap < radius_of(shape) + radius_of(solid)]
                found = distance_to(solid, postures[two], balls.places[close], close)
                deep = balls.radius - found.min(axis=1)
                depth[close] = np.maximum(depth[close], deep)
            yield Overlap(one, shape.part, shape.leg, f"robot {two}", "", depth)


def _near(bounds: Array, place: Array) -> NDArray[np.bool_]:
    away = np.maximum(np.maximum(bounds[:2] - place, place - bounds[2:]), 0.0)
    return np.hypot(*away.T) < NEAR


def _in_outline(
    robot: int, balls: list[Balls], rows: Rows, solid: Solid, offset: Array, count: int
) -> Iterator[Overlap]:
    for one in balls:
        places = one.places[rows][..., :2] - offset[:, None]
        found = _outline_distance(places, solid.points) - solid.radius
        depth = np.full(count, -np.inf)
        depth[rows] = one.radius - found.min(axis=1)
        yield Overlap(robot, one.shape.part, one.shape.leg, "obstacle", solid.key, depth)


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
