"""One call for all kinds of generated worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from cavalcade.world.generators.corridor import corridor
from cavalcade.world.generators.feasibility import is_connected
from cavalcade.world.generators.model import (
    GeneratedWorld,
    Generator,
    check_options,
    count,
    number,
)
from cavalcade.world.generators.scattered import clutter, forest
from cavalcade.world.generators.walls import maze, rooms
from cavalcade.world.occupancy import checked_resolution, grid_shape

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
        kind=kind,
        seed=seed,
        size=extent,
        resolution=resolution,
        shapes=draw.shapes,
        feasible=feasible,
        start=draw.start,
        goal=draw.goal,
        attempts=attempt + 1,
    )
