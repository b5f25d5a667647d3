"""The ground that robots walk on in physics, and the obstacles on it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.fleet.mujoco.blocks import HEIGHT, Block, blocks_of_map, blocks_of_shape
from cavalcade.geometry import Array, rectangle_corners
from cavalcade.scenario.timeline import ObstacleSpan
from cavalcade.scenario.worlds import World
from cavalcade.world import OccupancyMap, Terrain, shape_from_mapping


@dataclass(frozen=True)
class PhysicsGround:
    """The ground and what stands on it.

    Attributes:
        terrain: Its heights; None for level ground without end at height 0.
        fixed: Obstacles that stay where they are.
        movable: Obstacles that come, go or move, each of one or more blocks at its first place.
    """

    terrain: Terrain | None = None
    fixed: tuple[Block, ...] = ()
    movable: tuple[tuple[Block, ...], ...] = ()

    @classmethod
    def flat(cls) -> PhysicsGround:
        """Level ground without end at height 0, and nothing on it."""
        return cls()

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
