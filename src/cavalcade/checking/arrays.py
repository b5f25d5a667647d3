"""The verdict on motion that is at hand as arrays, without files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from cavalcade.checking.check import judge_planar
from cavalcade.checking.mapfile import Ground, read_ros_map
from cavalcade.checking.report import Report, make_report
from cavalcade.checking.solids import Scene, Solid, outline
from cavalcade.checking.tracks import Track
from cavalcade.errors import InputError, RecordingError
from cavalcade.robots import RobotModel
from cavalcade.scenario import Obstacle
from cavalcade.values import instances_of, number_array, path_of


def check_motion(
    time: ArrayLike,
    poses: ArrayLike,
    models: Sequence[RobotModel],
    *,
    size: tuple[float, float] | None = None,
    map: str | Path | None = None,
    obstacles: Sequence[Mapping[str, Any]] = (),
) -> Report:
    """Judge the planar motion of a team: contact between samples, speed and acceleration limits.

    Poses change evenly between samples. Footprints are swept, oriented rectangles; ground beyond
    the map is an obstacle.

    Args:
        time: `(T,)` s, increasing.
        poses: `(T, N, 3)` x, y in m, yaw in rad, map frame.
        models: N robot models: their footprints and limits.
        size: Width and height of free ground whose lower left corner is at (0, 0), m; or else
        map: The YAML file of a ROS map.
        obstacles: Shapes that always stand there, as scenario files say them:
            `{"circle": {"center": [4, 3], "radius": 0.2}}`, `box` or `polygon`.

    Raises:
        InputError: Arrays that don't fit, not finite values, a wrong obstacle, neither size nor
            map, or both.
        RecordingError: The map file cannot be read.
    """
    models = instances_of(models, RobotModel, "models")
    obstacles = instances_of(obstacles, Mapping, "obstacles", "a list of mappings")
    tracks = _tracks(time, poses, len(models))
    ground = _ground(size, map)
    scene = Scene(tuple(_solid(k, words) for k, words in enumerate(obstacles)), ground)
    return make_report(*judge_planar(scene, tracks, models))


def _tracks(times: ArrayLike, places: ArrayLike, robots: int) -> tuple[Track, ...]:
    time = number_array(times, "time", (None,), "(T,) finite seconds, two or more")
    if len(time) < 2 or not (np.diff(time) > 0.0).all():
        raise InputError("expected (T,) finite seconds that increase, two or more", key="time")
    shape = (len(time), robots, 3)
    poses = number_array(places, "poses", shape, f"finite poses of shape {shape}")
    yaw = np.unwrap(poses[..., 2], axis=0)
    return tuple(
        Track(time, np.column_stack((poses[:, robot, :2], yaw[:, robot])))
        for robot in range(robots)
    )


def _ground(size: tuple[float, float] | None, map: str | Path | None) -> Ground:
    if (size is None) == (map is None):
        raise InputError("expected either size or map", key="size")
    if map is not None:
        return read_ros_map(path_of(map, "map", RecordingError), False)
    width, height = number_array(size, "size", (2,), "width and height in m").tolist()
    if not (width > 0.0 and height > 0.0):
        raise InputError("expected width and height in m", key="size")
    return Ground((width, height), (0.0, 0.0, 0.0))


def _solid(index: int, words: Mapping[str, Any]) -> Solid:
    key = f"obstacles[{index}]"
    try:
        return Solid(key, *outline(Obstacle.model_validate(dict(words))))
    except (ValidationError, ValueError) as error:
        raise InputError("expected a box, a circle or a polygon", key=key) from error
