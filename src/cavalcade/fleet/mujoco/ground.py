"""The ground that robots walk on in physics, and the upright boxes and cylinders on it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.fleet.mujoco._rectangles import cover
from cavalcade.geometry import Array, rectangle_corners
from cavalcade.scenario.timeline import ObstacleSpan
from cavalcade.scenario.worlds import World
from cavalcade.world import (
    Box,
    Circle,
    OccupancyMap,
    Shape,
    Terrain,
    rasterise,
    shape_from_mapping,
)

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


@dataclass(frozen=True)
class PhysicsGround:
    """The ground and what stands on it; level without end, and empty, by default.

    Attributes:
        terrain: Its heights; None for level ground without end at height 0.
        fixed: Obstacles that stay where they are.
        movable: Obstacles that come, go or move, each of one or more blocks at its first place.
    """

    terrain: Terrain | None = None
    fixed: tuple[Block, ...] = ()
    movable: tuple[tuple[Block, ...], ...] = ()

    @classmethod
    def of_map(cls, map: OccupancyMap) -> PhysicsGround:
        """Level ground with boxes for the map's occupied cells and walls around it."""
        return cls(fixed=blocks_of_map(map))

    @classmethod
    def of_terrain(cls, terrain: Terrain) -> PhysicsGround:
        """Heights, with walls around them."""
        free = OccupancyMap(
            np.zeros(terrain.height.shape, bool), terrain.resolution, terrain.origin
        )
        return cls(terrain).with_fixed(blocks_of_map(free))

    @classmethod
    def of_world(cls, world: World) -> PhysicsGround:
        """The ground of a scenario.

        Occupied cells of its source become boxes; boxes and circles among its obstacles are
        exact. Obstacles that events bring, move or remove are `movable`, in the order of
        `movable_spans`.
        """
        cell = world.map.resolution
        groups = [
            (span, blocks_of_shape(shape_from_mapping(span.obstacle.to_dict()), cell))
            for span in world.spans
        ]
        blocks = [block for span, group in groups if span.fixed for block in group]
        ground = cls(world.terrain).with_fixed((*blocks_of_map(world.base), *blocks))
        moving = tuple(ground.raised(group) for span, group in groups if not span.fixed)
        return replace(ground, movable=moving)

    def with_fixed(self, blocks: tuple[Block, ...]) -> PhysicsGround:
        """This ground with more obstacles that stay, standing on it."""
        return replace(self, fixed=(*self.fixed, *self.raised(blocks)))

    def raised(self, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
        """Blocks from the lowest ground up to `HEIGHT` over the highest below each of them."""
        if self.terrain is None:
            return blocks
        bottom = float(self.terrain.height.min())
        return tuple(
            replace(block, bottom=bottom, top=self._highest(block) + HEIGHT) for block in blocks
        )

    def heights_at(self, points: ArrayLike) -> Array:
        """Heights `(N,)` in m of the ground at points `(N, 2)` of the map frame."""
        if self.terrain is None:
            return np.zeros(len(np.asarray(points)))
        return self.terrain.heights_at(points)

    def _highest(self, block: Block) -> float:
        """Of the ground below a block, sampled in steps of a cell."""
        a, b, _, d = rectangle_corners(block.pose, 2.0 * block.half[0], 2.0 * block.half[1])
        cell = 0.05 if self.terrain is None else self.terrain.resolution
        along = np.linspace(0.0, 1.0, 2 + int(np.hypot(*(b - a)) / cell))
        across = np.linspace(0.0, 1.0, 2 + int(np.hypot(*(d - a)) / cell))
        u, v = (part.reshape(-1, 1) for part in np.meshgrid(along, across))
        return float(self.heights_at(a + u * (b - a) + v * (d - a)).max())


def movable_spans(world: World) -> tuple[ObstacleSpan, ...]:
    """The spans of `world.spans` whose obstacles come, go or move, in order."""
    return tuple(span for span in world.spans if not span.fixed)


def blocks_of_map(map: OccupancyMap) -> tuple[Block, ...]:
    """Boxes whose union touches free ground where occupied cells and the map's border do.

    Ground beyond the map counts as occupied: walls stand around it where it is free inside.
    """
    cells = math.ceil(WALL / map.resolution)
    grid = np.pad(map.occupied, cells, constant_values=True)
    return tuple(_box(map, *(int(v) - cells for v in edges)) for edges in cover(grid))


def blocks_of_shape(shape: Shape, resolution: float = 0.05) -> tuple[Block, ...]:
    """The shape itself, a box or a circle; a polygon as boxes of the cells that it touches."""
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
