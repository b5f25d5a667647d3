"""One call for all kinds of generated worlds, and whether a disc gets through them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.world.generators.model import (
    GeneratedWorld,
    Generator,
    check_options,
    count,
    number,
)
from cavalcade.world.generators.walls import maze, rooms
from cavalcade.world.generators.zones import clutter, corridor, forest
from cavalcade.world.occupancy import checked_resolution, grid_shape
from cavalcade.world.shapes import Shape

_MAX_NODES = 4_000_000

GENERATORS: Mapping[str, Generator] = MappingProxyType(
    {"clutter": clutter, "corridor": corridor, "forest": forest, "maze": maze, "rooms": rooms}
)
"""Kind to its generator."""


def generate(
    kind: str,
    size: Sequence[float],
    seed: int,
    resolution: float = 0.05,
    *,
    radius: float = 0.30,
    require_feasible: bool = True,
    attempts: int = 100,
    **options: Any,
) -> GeneratedWorld:
    """Draw a world; the same arguments give the same world.

    The first draw depends on the seed alone, so `require_feasible` changes only those worlds that
    are not feasible.

    Args:
        kind: `clutter`, `corridor`, `forest`, `maze` or `rooms`.
        size: Width and height, m.
        seed: Not negative.
        resolution: Side of the cells of its map, m.
        radius: Of the disc that must get from start to goal for the world to be feasible, m.
        require_feasible: Draw again, by seeds derived from `seed`, until the world is feasible.
        attempts: Draws after which an infeasible world is given back as such.
        options: Of the kind; see its function.

    Raises:
        InputError: An unknown kind or option, or a value out of range; its key says which.
    """
    check_options(kind, GENERATORS, options)
    resolution = checked_resolution(resolution)
    grid_shape(size, resolution)
    extent = (float(size[0]), float(size[1]))
    seed = count("seed", seed, 0, 2**63 - 1)
    radius = number("radius", radius, 0.0)
    for attempt in range(count("attempts", attempts, 1, 10_000)):
        sequence = np.random.SeedSequence(seed, spawn_key=(attempt,) if attempt else ())
        draw = GENERATORS[kind](extent, np.random.default_rng(sequence), **options)
        feasible = is_connected(draw.shapes, extent, draw.start, draw.goal, radius)
        if feasible or not require_feasible:
            break
    return GeneratedWorld(
        **vars(draw),
        kind=kind,
        seed=seed,
        size=extent,
        resolution=resolution,
        feasible=feasible,
        attempts=attempt + 1,
    )


def is_connected(
    shapes: Sequence[Shape],
    size: tuple[float, float],
    start: ArrayLike,
    goal: ArrayLike,
    radius: float = 0.30,
    step: float = 0.025,
) -> bool:
    """Whether a disc gets from start to goal without touching a shape or the world's border.

    Nodes `step` apart are joined where the way between them is clear for certain: distances
    change by at most one metre per metre, so a clearance of radius + step / 2 at both ends is
    enough. The answer True is therefore always right; False may be wrong where the free width is
    within 2.5 `step` of the disc's diameter.

    Args:
        shapes: Obstacles in the world frame, m.
        size: Width and height of the world, m; its lower-left corner is (0, 0).
        start, goal: x, y, m; further numbers (a yaw) are ignored.
        radius: Of the disc, m.
        step: Distance of the nodes, m; coarser in very large worlds.
    """
    from scipy.ndimage import label

    if not (math.isfinite(radius) and radius >= 0.0 and math.isfinite(step) and step > 0.0):
        raise InputError("expected a disc of finite radius and a positive step", key="radius")
    step = max(step, math.sqrt(size[0] * size[1] / _MAX_NODES))
    cols, rows = (max(2, math.ceil(side / step) + 1) for side in size)
    x, y = np.linspace(0.0, size[0], cols), np.linspace(0.0, size[1], rows)
    need = radius + step / 2.0
    clearance = _clearance(shapes, x, y, need + 2.0 * step)
    labels, _ = label(clearance >= need)
    ends = [
        _reached(labels, clearance, x, y, np.asarray(end, dtype=float)[:2], radius)
        for end in (start, goal)
    ]
    return bool(ends[0] & ends[1])


def _clearance(shapes: Sequence[Shape], x: Array, y: Array, reach: float) -> Array:
    """Distance `(rows, cols)` to the nearest shape or border; a shape counts within `reach`."""
    clearance: Array = np.minimum(
        np.minimum(x, x[-1] - x)[None, :], np.minimum(y, y[-1] - y)[:, None]
    )
    for shape in shapes:
        x_min, y_min, x_max, y_max = shape.bounds
        i0, i1 = np.searchsorted(x, (x_min - reach, x_max + reach))
        j0, j1 = np.searchsorted(y, (y_min - reach, y_max + reach))
        if i0 == i1 or j0 == j1:
            continue
        nodes = np.stack(np.meshgrid(x[i0:i1], y[j0:j1]), axis=-1).reshape(-1, 2)
        distance = shape.distance(nodes).reshape(j1 - j0, i1 - i0)
        np.minimum(clearance[j0:j1, i0:i1], distance, out=clearance[j0:j1, i0:i1])
    return clearance


def _reached(
    labels: np.ndarray, clearance: Array, x: Array, y: Array, point: Array, radius: float
) -> set[int]:
    """Labels of the areas that a disc at `point` is in for certain."""
    i = np.clip(np.searchsorted(x, point[0]) + np.array([-1, 0]), 0, len(x) - 1)
    j = np.clip(np.searchsorted(y, point[1]) + np.array([-1, 0]), 0, len(y) - 1)
    found = set()
    for col in i:
        for row in j:
            away = math.hypot(x[col] - point[0], y[row] - point[1])
            # The disc stays clear all the way to a node that is this clear.
            if labels[row, col] and clearance[row, col] >= radius + away:
                found.add(int(labels[row, col]))
    return found
