"""The ground and what is solid on it, as pages need it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from cavalcade.drawing.outlines import shape_ring
from cavalcade.drawing.replay.page3d.meshes import (
    Prism,
    counter_clockwise,
    rectangles,
    triangulate,
)
from cavalcade.drawing.replay.page3d.packing import packed, whole
from cavalcade.drawing.scene import Arena
from cavalcade.geometry import Array
from cavalcade.locomotion.footholds import LEAST_TRAVERSABILITY
from cavalcade.world import OccupancyMap, Shape, Terrain

WALL = 0.5
"""How high solid obstacles are drawn, m: as high as they are in physics; planners never look."""

_MOST_NODES = 22_000


def ground_data(
    arena: Arena,
    base: OccupancyMap,
    shapes: Sequence[Shape],
    terrain: Terrain | None,
    most_nodes: int = _MOST_NODES,
) -> dict[str, Any]:
    """Border, terrain, solids and walls.

    Args:
        arena: Has the border.
        base: The map without the shapes.
        shapes: The obstacles that stand there all the time.
        terrain: The heights; None for level ground.
        most_nodes: Of the terrain's grid in the page.
    """
    return {
        "border": whole(arena.border, 1000),
        "terrain": None if terrain is None else _terrain(terrain, most_nodes),
        "solids": [prism_data(prism) for prism in prisms(shapes, terrain)],
        "walls": _walls(base, terrain),
    }


def prisms(shapes: Iterable[Shape], terrain: Terrain | None) -> Iterable[Prism]:
    """The shapes as upright prisms that stand on the ground."""
    for shape in shapes:
        yield prism_of(shape_ring(shape, corners=28), terrain)


def prism_of(outline: Array, terrain: Terrain | None) -> Prism:
    """The prism over an outline `(K, 2)`."""
    ring = counter_clockwise(outline)
    low, high = 0.0, WALL
    if terrain is not None:
        around = terrain.heights_at(np.concatenate([ring, ring.mean(axis=0)[None, :]]))
        low, high = float(around.min()) - 0.05, float(around.max()) + WALL
    return Prism(ring, triangulate(ring), low, high)


def prism_data(prism: Prism) -> dict[str, Any]:
    """A prism in mm."""
    return {
        "ring": whole(prism.ring, 1000),
        "fill": prism.triangles.ravel().tolist(),
        "low": round(prism.low, 3),
        "high": round(prism.high, 3),
    }


def _terrain(terrain: Terrain, most_nodes: int) -> dict[str, Any]:
    """Every so many-th node of the grid, heights in 1/65000 of their range."""
    stride = max(1, int(np.ceil(np.sqrt(terrain.rows * terrain.cols / most_nodes))))
    rows, cols = (np.unique(np.append(np.arange(0, n, stride), n - 1)) for n in
                  (terrain.rows, terrain.cols))  # fmt: skip
    height = terrain.height[np.ix_(rows, cols)]
    blocked = terrain.traversability[np.ix_(rows, cols)] < LEAST_TRAVERSABILITY
    low, span = float(height.min()), max(float(np.ptp(height)), 1e-6)
    levels = np.rint((height - low) / span * 65_000).astype("<u2")
    return {
        "x": whole((cols + 0.5) * terrain.resolution, 1000),
        "y": whole((rows + 0.5) * terrain.resolution, 1000),
        "origin": [round(part, 6) for part in terrain.origin],
        "low": low,
        "span": span,
        "heights": packed(levels),
        "blocked": packed(np.packbits(blocked.ravel())),
    }


def _walls(area: OccupancyMap, terrain: Terrain | None) -> dict[str, Any] | None:
    """Occupied cells of the map as rectangles in the grid's own frame."""
    if not area.occupied.any():
        return None
    found, factor = rectangles(area.occupied)
    top = 0.0 if terrain is None else float(terrain.height.max())
    return {
        "cell": area.resolution * factor,
        "origin": [round(part, 6) for part in area.origin],
        "low": 0.0 if terrain is None else float(terrain.height.min()),
        "high": round(top + WALL, 3),
        "boxes": found.ravel().tolist(),
    }
