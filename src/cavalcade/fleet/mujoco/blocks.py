"""Obstacles as upright boxes and cylinders."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cavalcade.fleet.mujoco._rectangles import cover
from cavalcade.world import Box, Circle, OccupancyMap, Shape, rasterise

HEIGHT = 0.5
"""Of obstacles over the ground, m: higher than a robot."""

WALL = 0.2
"""Thickness of the walls around a map, m."""


@dataclass(frozen=True)
class Block:
    """An upright box or cylinder.

    Attributes:
        kind: Which.
        pose: x, y, yaw of its centre in the map frame, m and rad.
        half: Half lengths along its own x and y, m; of a cylinder both are its radius.
        bottom, top: Heights, m.
    """

    kind: Literal["box", "cylinder"]
    pose: tuple[float, float, float]
    half: tuple[float, float]
    bottom: float = 0.0
    top: float = HEIGHT


def blocks_of_map(map: OccupancyMap) -> tuple[Block, ...]:
    """Boxes whose union touches free ground where occupied cells and the map's border do.

    Ground beyond the map counts as occupied: walls stand around it where it is free inside.
    """
    cells = math.ceil(WALL / map.resolution)
    grid = np.pad(map.occupied, cells, constant_values=True)
    return tuple(_box(map, *(int(v) - cells for v in edges)) for edges in cover(grid))


def blocks_of_shape(shape: Shape, resolution: float = 0.05) -> tuple[Block, ...]:
    """The shape itself if it is a box or a circle; a polygon as boxes of cells that it touches.

    Args:
        shape: In the map frame.
        resolution: Side of these cells, m.
    """
    if isinstance(shape, Circle):
        return (Block("cylinder", (*shape.center, 0.0), (shape.radius, shape.radius)),)
    if isinstance(shape, Box):
        half = (shape.size[0] / 2.0, shape.size[1] / 2.0)
        return (Block("box", (*shape.center, shape.yaw), half),)
    x_min, y_min, x_max, y_max = shape.bounds
    # Cells on the map's own lines, with free ones around the shape.
    col, row = math.floor(x_min / resolution) - 1, math.floor(y_min / resolution) - 1
    rows = math.ceil(y_max / resolution) + 1 - row
    cols = math.ceil(x_max / resolution) + 1 - col
    origin = (col * resolution, row * resolution, 0.0)
    grid = rasterise([shape], rows, cols, resolution, origin)
    local = OccupancyMap(np.where(grid, np.int8(100), np.int8(0)), resolution, origin)
    return tuple(_box(local, *(int(v) for v in edges)) for edges in cover(grid))


def _box(map: OccupancyMap, low: int, high: int, left: int, right: int) -> Block:
    """Rows `low` to `high` and columns `left` to `right` (half-open) of a map."""
    cell = map.resolution
    ((x, y),) = map.to_map([[(left + right) / 2.0 * cell, (low + high) / 2.0 * cell]])
    half = ((right - left) / 2.0 * cell, (high - low) / 2.0 * cell)
    return Block("box", (float(x), float(y), map.origin[2]), half)
