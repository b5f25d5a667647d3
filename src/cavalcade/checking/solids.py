"""What a robot may run into: the scenario's obstacles over time, the map's blocks, the border."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from cavalcade.checking.heights import Heights
from cavalcade.checking.mapfile import Ground, read_movingai, read_ros_map
from cavalcade.geometry import Array, rectangle_corners, rotation
from cavalcade.scenario import Obstacle, Scenario, obstacle_spans


@dataclass(frozen=True)
class Solid:
    """An obstacle over time: a polygon, or a disc if it has a single point.

    Attributes:
        key: Where it stands in the scenario: `world.obstacles[3]`, `event at 12 s`.
        points: `(P, 2)` its corners, or its centre, at its first place in the map frame, m.
        radius: Of a disc, m; 0 for polygons.
        start, end: Seconds between which it is there.
        time, offset: `(K,)` s and `(K, 2)` m: its displacement from its first place, even
            between these times and constant outside them.
    """

    key: str
    points: Array
    radius: float = 0.0
    start: float = 0.0
    end: float = math.inf
    time: Array = field(default_factory=lambda: np.zeros(1))
    offset: Array = field(default_factory=lambda: np.zeros((1, 2)))

    @property
    def moves(self) -> bool:
        """Whether it is not always there or not always at one place."""
        return self.start > 0.0 or math.isfinite(self.end) or len(self.time) > 1

    @property
    def bounds(self) -> Array:
        """x0, y0, x1, y1 at its first place, m."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        return np.concatenate((low - self.radius, high + self.radius))

    def offset_at(self, time: Array) -> Array:
        """Displacement `(M, 2)` in m at times `(M,)`."""
        x, y = self.offset.T
        return np.stack((np.interp(time, self.time, x), np.interp(time, self.time, y)), axis=1)


@dataclass(frozen=True)
class Scene:
    """All a robot may run into.

    Attributes:
        solids: The obstacles of the scenario.
        ground: What they stand on, with its border and occupied rectangles.
    """

    solids: tuple[Solid, ...]
    ground: Ground

    @cached_property
    def blocks(self) -> Array:
        """`(K, 4, 2)` corners of the ground's occupied rectangles in the map frame, m."""
        x0, y0, x1, y1 = self.ground.blocks.T
        corners = np.stack((x0, y0, x1, y0, x1, y1, x0, y1), axis=1).reshape(-1, 4, 2)
        return corners @ rotation(self.ground.origin[2]).T + self.ground.origin[:2]


def build_scene(scenario: Scenario, heights: Heights | None = None) -> Scene:
    """The scene of a resolved scenario; ground with heights has no occupied cells.

    Raises:
        RecordingError: A map file cannot be read.
        ScenarioError: An event removes what is not there.
    """
    ground = _ground(scenario) if heights is None else Ground(heights.size, heights.origin)
    fixed = len(scenario.world.obstacles)
    solids = []
    for k, span in enumerate(obstacle_spans(scenario)):
        key = f"world.obstacles[{k}]" if k < fixed else f"event at {span.start:g} s"
        time, offset = np.array(span.time, dtype=float), np.array(span.offset, dtype=float)
        solids.append(Solid(key, *outline(span.obstacle), span.start, span.end, time, offset))
    return Scene(tuple(solids), ground)


def _ground(scenario: Scenario) -> Ground:
    world = scenario.world
    if world.map is not None:
        return read_ros_map(Path(world.map), world.unknown == "free")
    if world.movingai is not None:
        return read_movingai(Path(world.movingai.file), world.movingai.resolution)
    if world.empty is None:
        raise ValueError("the scenario is not resolved")
    return Ground(world.empty.size, (*(world.empty.origin or (0.0, 0.0)), 0.0))


def outline(obstacle: Obstacle) -> tuple[Array, float]:
    """Corners of an obstacle, or the centre and the radius of a circle; map frame, m."""
    if obstacle.circle is not None:
        return np.array([obstacle.circle.center]), obstacle.circle.radius
    if obstacle.box is not None:
        box = obstacle.box
        return rectangle_corners((*box.center, box.yaw), *box.size), 0.0
    if obstacle.polygon is not None:
        return np.array(obstacle.polygon.points), 0.0
    raise ValueError("an obstacle without a shape")
