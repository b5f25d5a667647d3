"""Whether the robots can stand where the scenario starts them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.errors import ScenarioError
from cavalcade.geometry import Array, polygons, transform_points
from cavalcade.robots import RobotModel
from cavalcade.scenario.model import Scenario
from cavalcade.world import Box, Circle, OccupancyMap, Shape, rasterise

if TYPE_CHECKING:
    from cavalcade.world import Terrain

Body = Box | Circle

_SHRINK = 1e-9
"""Footprints are judged smaller by this many metres, so that touching is no overlap."""


def check_starts(
    scenario: Scenario,
    base: OccupancyMap,
    shapes: Sequence[Shape],
    terrain: Terrain | None = None,
) -> None:
    """Refuse starts outside the map, in an obstacle, in each other or with a foot in a hole.

    Judged by the oriented footprints: against the shapes exactly, against the cells of `base`
    (the map without the shapes) as squares.

    Raises:
        ScenarioError: Naming the robot and what it would stand in.
    """
    bodies: list[Body] = []
    for key, robot, model in scenario.team:
        x, y, yaw = robot.start
        body = _body(model, robot.start)
        problem = _problem(body, base, shapes, bodies)
        if problem is None and terrain is not None and model.legs is not None:
            feet = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]], dtype=float)
            feet *= (model.legs.hip_x, model.legs.hip_y)
            if terrain.in_hole(transform_points((x, y, yaw), feet)).any():
                problem = "stands in a hole of the terrain"
        if problem is not None:
            raise ScenarioError(
                f"the robot at ({x:g}, {y:g}) {problem}; expected free ground",
                file=scenario.file,
                key=f"{key}.start",
            )
        bodies.append(body)


def _body(model: RobotModel, pose: tuple[float, float, float]) -> Body:
    x, y, yaw = pose
    if model.round:
        return Circle((x, y), (model.length - _SHRINK) / 2.0)
    return Box((x, y), (model.length - _SHRINK, model.width - _SHRINK), yaw)


def _problem(
    body: Body, base: OccupancyMap, shapes: Sequence[Shape], bodies: Sequence[Body]
) -> str | None:
    if not base.contains(_extremes(body, base)).all():
        return "reaches beyond the map"
    for other, standing in enumerate(bodies):
        if _overlap(body, standing):
            return f"overlaps robot {other}"
    for k, shape in enumerate(shapes):
        if _overlap(body, shape):
            return f"stands in world.obstacles[{k}]"
    if base.occupied.any():
        cells = rasterise([body], base.rows, base.cols, base.resolution, base.origin)
        if (cells & base.occupied).any():
            return "stands in an obstacle of the map"
    return None


def _extremes(body: Body, base: OccupancyMap) -> Array:
    """Points `(4, 2)` of the body that lie farthest out along the map's own axes."""
    if isinstance(body, Box):
        return body.corners
    ways = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    return transform_points((*body.center, base.origin[2]), body.radius * ways)


def _overlap(body: Body, shape: Shape) -> bool:
    low_x, low_y, high_x, high_y = body.bounds
    x_min, y_min, x_max, y_max = shape.bounds
    if x_min > high_x or x_max < low_x or y_min > high_y or y_max < low_y:
        return False
    if isinstance(shape, Circle):
        return bool(body.distance([shape.center])[0] < shape.radius)
    if isinstance(body, Circle):
        return bool(shape.distance([body.center])[0] < body.radius)
    corners = shape.corners if isinstance(shape, Box) else shape.vertices
    return polygons.meet(body.corners, corners)
