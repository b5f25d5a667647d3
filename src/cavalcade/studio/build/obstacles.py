"""Obstacles as they are drawn by clicks and moved by hand; plain data of a scenario file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from cavalcade.geometry import transform_points
from cavalcade.studio.build.draft import Checked

Data = dict[str, Any]
Pose = tuple[float, float, float]
Point = tuple[float, float]

SIZE = 0.6
"""Of an obstacle that is drawn by two clicks on one spot, m."""

_SAME = 0.1
"""Two clicks that are not farther apart are on one spot, m."""


def box_between(one: Point, other: Point) -> Data:
    """The box with these two opposite corners."""
    width, height = (_size(other[i] - one[i]) for i in (0, 1))
    if math.dist(one, other) < _SAME:
        width = height = SIZE
        other = one
    return {"box": {"center": _middle(one, other), "size": [width, height]}}


def circle_between(center: Point, rim: Point) -> Data:
    """The disc around one point that reaches to another one."""
    radius = math.dist(center, rim)
    radius = SIZE / 2.0 if radius < _SAME else radius
    return {"circle": {"center": [round(x, 2) for x in center], "radius": round(radius, 2)}}


def wall_between(one: Point, other: Point, width: float) -> Data:
    """The wall with these two ends."""
    dx, dy = other[0] - one[0], other[1] - one[1]
    if math.hypot(dx, dy) < _SAME:
        dx, dy, one, other = 1.0, 0.0, (one[0] - 0.5, one[1]), (one[0] + 0.5, one[1])
    box = {
        "center": _middle(one, other),
        "size": [_size(math.hypot(dx, dy)), width],
        "yaw": round(math.atan2(dy, dx), 3),
    }
    return {"box": box}


DRAWN: Mapping[str, Callable[[Point, Point, float], Data]] = {
    "Box": lambda one, other, _: box_between(one, other),
    "Circle": lambda one, other, _: circle_between(one, other),
    "Wall": wall_between,
}
"""What two clicks draw: with the two points and the width of walls."""


def pose_of(obstacle: Mapping[str, Any]) -> Pose:
    """Where an obstacle is and how it is turned."""
    for kind in ("box", "circle"):
        if obstacle.get(kind):
            x, y = obstacle[kind]["center"]
            return float(x), float(y), float(obstacle[kind].get("yaw") or 0.0)
    points = obstacle["polygon"]["points"]
    x, y = (sum(point[i] for point in points) / len(points) for i in (0, 1))
    return x, y, 0.0


def at_pose(obstacle: Mapping[str, Any], pose: Pose) -> Data:
    """The same obstacle somewhere else."""
    x, y, yaw = round(pose[0], 3), round(pose[1], 3), round(pose[2], 3)
    if obstacle.get("box"):
        return {"box": {**obstacle["box"], "center": [x, y], "yaw": yaw}}
    if obstacle.get("circle"):
        return {"circle": {**obstacle["circle"], "center": [x, y]}}
    here = pose_of(obstacle)
    points = [(px - here[0], py - here[1]) for px, py in obstacle["polygon"]["points"]]
    moved = transform_points((x, y, yaw), points).round(3).tolist()
    return {"polygon": {"points": moved}}


def obstacles_of(state: Checked) -> list[Data]:
    """All obstacles that stand there, as `World.shapes` has them."""
    return [one.to_dict() for one in state.shown.world.obstacles]


def obstacle_at(state: Checked, index: int) -> Data:
    """One of them."""
    return state.shown.world.obstacles[index].to_dict()


def with_obstacle(state: Checked, obstacle: Mapping[str, Any] | None, index: int) -> Data:
    """The data with another obstacle at an index, or one more behind the last; None: one less.

    Generated obstacles are listed one by one from their first change on.
    """
    world = dict(state.data["world"])
    listed: Sequence[Any] = world.get("obstacles") or ()
    if index >= len(listed) and (index < len(state.shown.world.obstacles)):
        world = state.shown.world.model_dump(mode="json", exclude_none=True)
        listed = obstacles_of(state)
    new = [] if obstacle is None else [dict(obstacle)]
    world["obstacles"] = [*listed[:index], *new, *listed[index + 1 :]]
    return {**state.data, "world": world}


def with_one_more(state: Checked, obstacle: Mapping[str, Any]) -> Data:
    """The data with one obstacle more, before all that are generated."""
    world = state.data["world"]
    listed = [*(world.get("obstacles") or ()), dict(obstacle)]
    return {**state.data, "world": {**world, "obstacles": listed}}


def _middle(one: Point, other: Point) -> list[float]:
    return [round((a + b) / 2.0, 3) for a, b in zip(one, other, strict=True)]


def _size(length: float) -> float:
    return max(round(abs(length), 2), 0.05)
