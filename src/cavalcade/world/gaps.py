"""How near a body that stands somewhere is to what is around it: exact, in m.

This is what starts and goals are judged by, wherever they come from: `CLEARANCE` is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import CLEARANCE, Array, polygons
from cavalcade.robots import RobotModel
from cavalcade.world.occupancy import OccupancyMap
from cavalcade.world.raster import rasterise
from cavalcade.world.shapes import Box, Circle, Shape

Body = Box | Circle

_ROUNDING = 1e-6
"""Of coordinates: so much may be missing of a clearance, m."""

REACH = 2.0 * CLEARANCE
"""How far it is looked around a body, m."""

BORDER, CELLS = -1, -2
"""What `nearest_obstacle` names in the place of a shape."""


def body_at(model: RobotModel, pose: Sequence[float]) -> Body:
    """What a robot covers of the ground at a pose x, y, yaw."""
    x, y, yaw = pose
    if model.round:
        return Circle((x, y), model.length / 2.0)
    return Box((x, y), (model.length, model.width), yaw)


def too_near(gap: float) -> bool:
    """Whether a gap is less than what starts and goals have to keep; m."""
    return gap < CLEARANCE - _ROUNDING


def gap_between(body: Body, shape: Shape) -> float:
    """Between the two, m; 0 where they meet."""
    if isinstance(shape, Circle):
        return max(float(body.distance([shape.center])[0]) - shape.radius, 0.0)
    if isinstance(body, Circle):
        return max(float(shape.distance([body.center])[0]) - body.radius, 0.0)
    corners = shape.corners if isinstance(shape, Box) else shape.vertices
    return polygons.gap(body.corners, corners)


def nearest_obstacle(
    body: Body, map: OccupancyMap, shapes: Sequence[Shape], reach: float = REACH
) -> tuple[float, int]:
    """The gap to what is nearest, m, 0 if it is met, and the number of that shape.

    Not a shape: `BORDER` of the map or one of its occupied `CELLS`, which count as squares. Gaps
    of more than `reach` m come out as that.
    """
    found = [(reach, BORDER), (_gap_to_border(body, map), BORDER)]
    low_x, low_y, high_x, high_y = body.bounds
    for number, shape in enumerate(shapes):
        x0, y0, x1, y1 = shape.bounds
        if max(x0 - high_x, low_x - x1, y0 - high_y, low_y - y1) < reach:
            found.append((gap_between(body, shape), number))
    if map.occupied.any():
        found += [(gap_between(body, square), CELLS) for square in squares_near(body, map, reach)]
    return min(found, key=lambda pair: pair[0])  # of equal ones the first: border, shapes, cells


def _gap_to_border(body: Body, map: OccupancyMap) -> float:
    if isinstance(body, Box):
        points, radius = map.to_local(body.corners), 0.0
    else:
        points, radius = map.to_local([body.center]), body.radius
    inside: Array = np.minimum(points, np.array(map.size) - points)
    return max(float(inside.min()) - radius, 0.0)


def squares_near(body: Body, map: OccupancyMap, reach: float = REACH) -> list[Box]:
    """Occupied cells within `reach` of the body."""
    if isinstance(body, Box):
        length, width = (side + 2.0 * reach for side in body.size)
        grown: Body = Box(body.center, (length, width), body.yaw)
    else:
        grown = Circle(body.center, body.radius + reach)
    near: NDArray[np.bool_] = map.occupied & rasterise(
        [grown], map.rows, map.cols, map.resolution, map.origin
    )
    side = map.resolution
    places = map.centers(np.argwhere(near))
    return [Box((float(x), float(y)), (side, side), map.origin[2]) for x, y in places]
