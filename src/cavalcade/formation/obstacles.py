"""Obstacles that are known to move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.geometry import Array, inverse_transform_points, rotation
from cavalcade.world import Box, Shape


@dataclass(frozen=True)
class MovingObstacle:
    """A shape where it is now, and its velocity.

    Attributes:
        shape: In the map's frame.
        velocity: m/s, map frame.
    """

    shape: Shape
    velocity: tuple[float, float]


def mover_arrays(
    obstacles: Sequence[MovingObstacle], origin: Sequence[float]
) -> tuple[Array, Array]:
    """Enclosing rectangles and velocities in the grid's frame.

    Args:
        obstacles: M of them.
        origin: The map's origin (x, y, yaw).

    Returns:
        `(M, 5)` pose, half length, half width (m, rad) and `(M, 2)` m/s.
    """
    boxes, speeds = np.zeros((len(obstacles), 5)), np.zeros((len(obstacles), 2))
    turn = rotation(-origin[2])
    for k, obstacle in enumerate(obstacles):
        shape = obstacle.shape
        if isinstance(shape, Box):
            centre, size, yaw = shape.center, shape.size, shape.yaw
        else:
            x0, y0, x1, y1 = shape.bounds
            centre, size, yaw = ((x0 + x1) / 2, (y0 + y1) / 2), (x1 - x0, y1 - y0), 0.0
        boxes[k, :2] = inverse_transform_points(origin, np.array([centre]))[0]
        boxes[k, 2:] = yaw - origin[2], size[0] / 2, size[1] / 2
        speeds[k] = turn @ np.asarray(obstacle.velocity)
    return boxes, speeds
