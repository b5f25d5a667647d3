"""Clutter, forest and corridor: what stands between a start zone and a goal zone."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.world.generators.model import Draw, Size, check_band, count, number, zone_poses
from cavalcade.world.shapes import Box, Circle, Polygon, Shape

CIRCLE_RADIUS = (0.10, 0.35)
BOX_LENGTH = (0.20, 1.40)
BOX_WIDTH = (0.20, 0.60)
TRUNK_RADIUS = (0.10, 0.30)

MAX_TREES = 2_000

_DARTS = 200
"""Darts thrown for one trunk before the forest counts as full."""

STEEPEST = math.radians(75.0)
"""Largest angle of a slanting leg to the x axis."""

_MIDDLES = 500
"""Middle lines drawn before the world counts as too small."""

_WALL = 0.3
"""Least thickness of what stands above and below the corridor, m."""


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
        darts = rng.uniform(low, high, size=(_DARTS, 2))
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


def corridor(
    size: Size,
    rng: np.random.Generator,
    *,
    width: float = 1.0,
    bends: int = 2,
    angle: float = 45.0,
    zone: float = 2.8,
) -> Draw:
    """A corridor from left to right; its legs are level and slanting in turn.

    Args:
        width: Free width of the corridor, m, the same in every leg.
        bends: Number of bends, at least 2.
        angle: Least angle of a bend, degrees, up to 75.
        zone: Width in m of the open areas before and after the corridor.

    Raises:
        InputError: The corridor doesn't fit the world.
    """
    width = number("width", width, 0.5)
    bends = count("bends", bends, 2, 50)
    least = math.radians(number("angle", angle, 1.0, math.degrees(STEEPEST)))
    zone = number("zone", zone, 0.5)
    check_band(size, zone, width)
    for _ in range(_MIDDLES):
        middle = _draw_middle(size, rng, width, bends, least, zone)
        if middle is not None:
            break
    else:
        raise InputError(
            f"is too small for a corridor of {width:g} m with {bends} bends of {angle:g} degrees",
            key="size",
        )
    upper, lower = _offset(middle, width / 2.0), _offset(middle, -width / 2.0)
    left, right = zone, size[0] - zone
    above = [*upper.tolist(), [right, size[1]], [left, size[1]]]
    below = [*lower[::-1].tolist(), [left, 0.0], [right, 0.0]]
    shapes = tuple(Polygon(tuple((x, y) for x, y in wall)) for wall in (above, below))
    # Opposite the mouths, but with room for a team beside the border.
    margin = min(zone, size[1]) / 2.0
    entry, exit_ = np.clip(middle[[0, -1], 1], margin, size[1] - margin).tolist()
    return Draw(shapes, (zone / 2.0, entry, 0.0), (size[0] - zone / 2.0, exit_, 0.0))


def _draw_middle(
    size: Size, rng: np.random.Generator, width: float, bends: int, least: float, zone: float
) -> Array | None:
    """A middle line `(bends + 2, 2)` from zone to zone, m; None if it doesn't fit."""
    share = rng.uniform(0.6, 1.0, size=bends + 1)
    lengths = (size[0] - 2.0 * zone) * share / share.sum()
    slopes = np.zeros(bends + 1)
    for leg in range(1, bends + 1, 2):
        slopes[leg] = rng.uniform(least, STEEPEST) * rng.choice([-1.0, 1.0])
    # The inner wall of a bend is shorter than the middle line by this much on either side.
    cut = width / 2.0 * np.tan(np.abs(np.diff(slopes)) / 2.0)
    along = lengths / np.cos(slopes)
    if np.any(along < np.append(cut, 0.0) + np.insert(cut, 0, 0.0) + 0.1):
        return None
    x = zone + np.insert(np.cumsum(lengths), 0, 0.0)
    y = np.insert(np.cumsum(lengths * np.tan(slopes)), 0, 0.0)
    # A slanting leg that ends at the zone is cut upright, so it is taller than it is wide.
    reach = width / 2.0 / math.cos(float(np.abs(slopes).max())) + _WALL
    room = size[1] - (y.max() - y.min()) - 2.0 * reach
    if room < 0.0:
        return None
    y += reach - y.min() + rng.uniform(0.0, room)
    return np.column_stack([x, y])


def _offset(middle: Array, distance: float) -> Array:
    """The line parallel to `middle` `(K, 2)`, `distance` m to its left, mitred at the bends.

    At both ends it is cut upright, at the ends' x.
    """
    step = np.diff(middle, axis=0)
    slope = np.arctan2(step[:, 1], step[:, 0])
    result = middle.copy()
    result[0, 1] += distance / math.cos(slope[0])
    result[-1, 1] += distance / math.cos(slope[-1])
    before, after = slope[:-1], slope[1:]
    bisector = (before + after) / 2.0
    reach = distance / np.cos((after - before) / 2.0)
    result[1:-1] += np.column_stack([-np.sin(bisector), np.cos(bisector)]) * reach[:, None]
    return result
