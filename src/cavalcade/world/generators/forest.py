"""Forest: round trunks that keep a distance from each other."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.world.generators.model import Draw, Size, check_band, count, number, zone_poses
from cavalcade.world.shapes import Circle

RADIUS = (0.10, 0.30)

MAX_TREES = 2_000

_TRIES = 200
"""Darts thrown for one trunk before the forest counts as full."""


def forest(
    size: Size,
    rng: np.random.Generator,
    *,
    trees: int | None = None,
    spacing: float = 0.9,
    zone: float = 2.8,
) -> Draw:
    """Trunks between a start zone and a goal zone, by throwing darts (Poisson-disc sampling).

    Args:
        size: Width and height of the world, m.
        rng: Source of all randomness.
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
        radius = float(rng.uniform(*RADIUS))
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
