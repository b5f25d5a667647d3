"""Free ground for a team and its goal: where nothing is said, a sensible place is taken."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel
from cavalcade.scenario import World
from cavalcade.world import OccupancyMap
from cavalcade.world.gaps import Body, body_at, gap_between, nearest_obstacle

Pose = tuple[float, float, float]

_ROOM = 0.15
"""Kept free around robots where they are placed, m."""

_MARGIN = 0.5
"""Kept besides between a formation and obstacles where there is room, m."""

_MOST_PLACES = 20_000
"""How many places are tried for a robot at most."""


def ends(world: World, radius: float) -> tuple[Pose, Pose]:
    """Where to begin and where to go: far apart, with room around and a way between them.

    Args:
        radius: Of what is to stand there, m.

    Raises:
        InputError: There is no free ground at all.
    """
    free = ~world.map.occupied
    if not free.any():
        raise InputError("there is no free ground in this world", key="world")
    room = _room(world.map)
    ways, _ = ndimage.label(room >= min(0.4, room.max()))
    points = _roomy(world.map, room, ways, radius)
    middle = points.mean(axis=0)
    along = _longer(points)
    # Of places that are equally far the one nearest to the middle.
    cost = 0.2 * np.abs(points[:, 1 - along] - middle[1 - along])
    first = points[np.argmin(points[:, along] + cost)].round(1)
    last = points[np.argmax(points[:, along] - cost)].round(1)
    yaw = math.atan2(last[1] - first[1], last[0] - first[0]) if np.any(first != last) else 0.0
    return _pose(first, yaw), _pose(last, yaw)


def _roomy(ground: OccupancyMap, room: Array, ways: NDArray[np.int32], radius: float) -> Array:
    """Points `(K, 2)` of the largest connected ground: with as much room as is found far apart."""
    sizes = np.bincount(ways.ravel())
    sizes[0] = 0
    room = np.where(ways == int(sizes.argmax()), room, 0.0)
    whole = np.ptp(ground.centers(np.argwhere(room > 0.0)), axis=0).max()
    points = np.empty((0, 2))
    for least in (radius + _MARGIN, radius, 0.8, 0.6, 0.0):
        points = ground.centers(np.argwhere(room > least))
        if len(points) and np.ptp(points, axis=0).max() >= 0.5 * whole:
            break
    return points


def _longer(points: Array) -> int:
    """Whether they spread along x, 0, or rather along y, 1."""
    width, height = np.ptp(points, axis=0)
    return int(height > 1.5 * width)


def stand(
    world: World, wanted: Sequence[Pose], models: Sequence[RobotModel], gap: float = _ROOM
) -> list[Pose]:
    """Poses near the wanted ones at which robots have `gap` m of room, also between them.

    Raises:
        InputError: There is no such place for one of them.
    """
    bodies: list[Body] = []
    found: list[Pose] = []
    room = _room(world.map)
    for pose, model in zip(wanted, models, strict=True):
        least = min(model.length, model.width) / 2.0
        places = _near(world.map, pose, room, least, [place[:2] for place in found])
        place = next((p for p in places if _fits(world, p, model, bodies, gap)), None)
        if place is None:
            raise InputError(f"no free ground is left for robot {len(found)}", key="robots")
        bodies.append(body_at(model, place))
        found.append(place)
    return found


def _fits(world: World, pose: Pose, model: RobotModel, bodies: Sequence[Body], gap: float) -> bool:
    body = body_at(model, pose)
    if any(gap_between(body, other) < gap for other in bodies):
        return False
    return nearest_obstacle(body, world.base, world.shapes, gap)[0] >= gap


def _near(
    ground: OccupancyMap, pose: Pose, room: Array, least: float, taken: Sequence[Sequence[float]]
) -> list[Pose]:
    """The pose itself, then places around it, the nearest first; none that are hopeless.

    Args:
        room: To the nearest obstacle, m, per cell.
        least: That a body needs at any heading, m.
        taken: Where others stand.
    """
    (x0, y0), (x1, y1) = ground.to_map([(0.0, 0.0), ground.size])
    reach = max(abs(x1 - x0), abs(y1 - y0))
    step = max(0.2, 2.0 * reach / math.sqrt(_MOST_PLACES))
    count = int(reach / step)
    offsets = step * np.mgrid[-count : count + 1, -count : count + 1].reshape(2, -1).T
    points = offsets[np.argsort(np.hypot(*offsets.T), kind="stable")] + pose[:2]
    points = points[is_free(ground, points)]
    rows, cols = _cells(ground, points)
    points = points[room[rows, cols] > least]
    for other in taken:
        points = points[np.hypot(*(points - other).T) > 2.0 * least]
    return [_pose(pose, pose[2]), *(_pose(point, pose[2]) for point in points)]


def _room(ground: OccupancyMap) -> Array:
    """How far each cell's centre is from the nearest obstacle or border, about, m."""
    free = np.pad(~ground.occupied, 1)
    room: Array = ndimage.distance_transform_edt(free)[1:-1, 1:-1] * ground.resolution
    return room


def _cells(ground: OccupancyMap, points: ArrayLike) -> Any:
    """Rows and columns of points on the map; what is on its far border is in the last cell."""
    last = (ground.rows - 1, ground.cols - 1)
    return np.clip(ground.cell_of(points), 0, last).T


def is_free(ground: OccupancyMap, points: ArrayLike) -> NDArray[np.bool_]:
    """For points `(K, 2)`: whether they are on the map and on none of its obstacles."""
    rows, cols = _cells(ground, points)
    return np.asarray(ground.contains(points) & ~ground.occupied[rows, cols])


def _pose(point: Sequence[float] | Array, yaw: float) -> Pose:
    """To the centimetre and to 0.001 rad: what a person would write."""
    return round(float(point[0]), 2), round(float(point[1]), 2), round(float(yaw), 3)
