"""Obstacles that are known to move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.errors import InputError
from cavalcade.formation._clearance import ObstacleBoxes
from cavalcade.geometry import inverse_transform_points, rotation
from cavalcade.values import described, number_array
from cavalcade.world import Box, Shape


@dataclass(frozen=True)
class DynamicObstacle:
    """A shape where it is now, and its velocity.

    Attributes:
        shape: In the map's frame.
        velocity: m/s, map frame.

    Raises:
        InputError: Something else than a shape, or than two finite numbers.
    """

    shape: Shape
    velocity: tuple[float, float]

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Shape):
            raise InputError(
                f"expected a Box, Circle or Polygon, got {described(self.shape)}", key="shape"
            )
        vx, vy = number_array(self.velocity, "velocity", (2,), "(2,) m/s").tolist()
        object.__setattr__(self, "velocity", (vx, vy))


def obstacle_boxes(obstacles: Sequence[DynamicObstacle], origin: Sequence[float]) -> ObstacleBoxes:
    """Rectangles around obstacles, in the frame of the grid whose origin is (x, y, yaw)."""
    count = len(obstacles)
    poses, half, velocities = np.zeros((count, 3)), np.zeros((count, 2)), np.zeros((count, 2))
    turn = rotation(-origin[2])
    for k, obstacle in enumerate(obstacles):
        shape = obstacle.shape
        if isinstance(shape, Box):
            centre, size, yaw = shape.center, shape.size, shape.yaw
        else:
            x0, y0, x1, y1 = shape.bounds
            centre, size, yaw = ((x0 + x1) / 2, (y0 + y1) / 2), (x1 - x0, y1 - y0), 0.0
        poses[k, :2] = inverse_transform_points(origin, np.array([centre]))[0]
        poses[k, 2] = yaw - origin[2]
        half[k] = size[0] / 2, size[1] / 2
        velocities[k] = turn @ np.asarray(obstacle.velocity)
    return ObstacleBoxes(poses, half, velocities)
