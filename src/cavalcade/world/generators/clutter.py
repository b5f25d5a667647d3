"""Clutter: circles and turned boxes strewn between a start zone and a goal zone."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.world.generators.model import Draw, Size, check_band, count, number, zone_poses
from cavalcade.world.shapes import Box, Circle, Shape

RADIUS = (0.10, 0.35)
LENGTH = (0.20, 1.40)
WIDTH = (0.20, 0.60)


def clutter(
    size: Size, rng: np.random.Generator, *, obstacles: int = 25, zone: float = 2.8
) -> Draw:
    """Half circles, half boxes at any angle; centres uniform between the zones, at any height.

    They may overlap each other, the border and, by their own extent, the zones.

    Args:
        size: Width and height of the world, m.
        rng: Source of all randomness.
        obstacles: Number of obstacles; of an odd number one more is a circle.
        zone: Width in m of the start zone (left) and of the goal zone (right).
    """
    obstacles = count("obstacles", obstacles, 0, 10_000)
    zone = number("zone", zone, 0.0)
    check_band(size, zone, 0.0)
    shapes: list[Shape] = []
    for index in range(obstacles):
        center = (float(rng.uniform(zone, size[0] - zone)), float(rng.uniform(0.0, size[1])))
        if index % 2 == 0:
            shapes.append(Circle(center, float(rng.uniform(*RADIUS))))
        else:
            sides = (float(rng.uniform(*LENGTH)), float(rng.uniform(*WIDTH)))
            shapes.append(Box(center, sides, float(rng.uniform(0.0, math.pi))))
    return Draw(tuple(shapes), *zone_poses(size, zone))
