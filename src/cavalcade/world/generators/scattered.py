"""Clutter and forest: obstacles strewn between a start zone and a goal zone."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.world.generators.model import Draw, Size, check_band, count, number, zone_poses
from cavalcade.world.shapes import Box, Circle, Shape

CIRCLE_RADIUS = (0.10, 0.35)
BOX_LENGTH = (0.20, 1.40)
BOX_WIDTH = (0.20, 0.60)
TRUNK_RADIUS = (0.10, 0.30)

MAX_TREES = 2_000

_TRIES = 200
"""Darts thrown for one trunk before the forest counts as full."""


def clutter(
    size: Size, rng: np.random.Generator, *, obstacles: int = 25, zone: float = 2.8
) -> Draw:
    """Half circles, half boxes at any angle; centres uniform between the zones, at any height.

    They may overlap each other, the border and, by their own extent, the zones.

    Args:
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
            shapes.append(Circle(center, float(rng.uniform(*CIRCLE_RADIUS))))
        else:
            sides = (float(rng.uniform(*BOX_LENGTH)), float(rng.uniform(*BOX_WIDTH)))
            shapes.append(Box(center, sides, float(rng.uniform(0.0, math.pi))))
    return Draw(tuple(shapes), *zone_poses(size, zone))


def forest(
    size: Size,
    rng: np.random.Generator,
    *,
    trees: int | None = None,
    spacing: float = 0.9,
    zone: float = 2.8,
) -> Draw:
    """Round trunks that keep a distance, by throwing darts (Poisson-disc sampling).

    Args:
        trees: Number of trunks; fewer where no more fit. By default as many as fit.
        spacing: Least free gap between two trunks, m.
        zone: Width in m of the start zone (left) and of the goal zone (right).
    """
    wanted = MAX_TREES if trees is None else count("trees", trees, 0, MAX_TREES)
    spacing = number("spacing", spacing, 0.05)
    zone = number("zone", zone, 0.0)
    check_band(size, zone, 0.0)
    low, high = np.array([zone, 0.0]), np.array([size[0] - zone, size[1]])
    centers = np.empty((wanted, 2))
    radii = np.empty(wanted)
    planted = 0
    while planted < wanted:
        radius = float(rng.uniform(*TRUNK_RADIUS))
        darts = rng.uniform(low, high, size=(_TRIES, 2))
        away = darts[:, None, :] - centers[None, :planted, :]
        gaps = np.hypot(away[..., 0], away[..., 1]) - radii[:planted] - radius
        fits = gaps.min(axis=1, initial=math.inf) >= spacing
        if not fits.any():
            break
        centers[planted] = darts[int(np.argmax(fits))]
        radii[planted] = radius
        planted += 1
    trunks = zip(centers[:planted].tolist(), radii[:planted].tolist(), strict=True)
    return Draw(tuple(Circle((x, y), r) for (x, y), r in trunks), *zone_poses(size, zone))
