"""What every picture of a run needs, taken once from scenario, world and recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.drawing.outlines import cell_rings, shape_ring
from cavalcade.geometry import Array, transform_points
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel
from cavalcade.world import Shape, shape_from_mapping

if TYPE_CHECKING:
    from cavalcade.recording.frames import ObstacleTrack, Recording
    from cavalcade.scenario import Scenario, World

DEFAULT_RADIUS = 0.30
"""The paper's inflation radius in m, where the scenario does not set another one."""


@dataclass(frozen=True)
class Track:
    """An obstacle that came, went or moved.

    Attributes:
        shape: At its first place, map frame.
        ring: `(K, 2)` its outline there.
        start, end: Seconds between which it was there.
        time: `(M,)` s, and
        offset: `(M, 2)` m: how far it was from its first place.
    """

    shape: Shape
    ring: Array
    start: float
    end: float
    time: Array
    offset: Array

    def offset_at(self, time: float | Array) -> Array:
        """Displacement `(..., 2)` in m at the given times."""
        if len(self.time) == 0:
            return np.zeros((*np.shape(time), 2))
        columns = [np.interp(time, self.time, self.offset[:, axis]) for axis in (0, 1)]
        return np.stack(columns, axis=-1)


@dataclass(frozen=True)
class Arena:
    """The ground of a run; map frame, m.

    Attributes:
        border: `(4, 2)` corners of the map.
        walls: Rings of the map file's occupied cells.
        unknown: Rings of the cells nothing is known of.
        shapes: Outlines of the exact shapes that are there all the time.
    """

    border: Array
    walls: tuple[Array, ...]
    unknown: tuple[Array, ...]
    shapes: tuple[Array, ...]

    @property
    def bounds(self) -> Array:
        """`(4,)`: lowest x, lowest y, highest x, highest y."""
        return np.concatenate([self.border.min(axis=0), self.border.max(axis=0)])


@dataclass(frozen=True)
class Scene:
    """A run ready to be drawn: T cycles, N robots, map frame, SI units.

    Attributes:
        name: The scenario's.
        arena: The ground.
        fixed: The exact shapes that are there all the time.
        tracks: Obstacles that came, went or moved.
        models: N robot models.
        radius: The inflation radius `r_max`.
        time: `(T,)`.
        poses: `(T, N, 3)` true poses.
        status: T planner states.
        notes: (time, text) of what happened.
    """

    name: str
    arena: Arena
    fixed: tuple[Shape, ...]
    tracks: tuple[Track, ...]
    models: tuple[RobotModel, ...]
    radius: float
    time: Array
    poses: Array
    status: tuple[PlannerStatus, ...]
    notes: tuple[tuple[float, str], ...]

    @property
    def size(self) -> int:
        """Number of robots."""
        return int(self.poses.shape[1])

    def view(self, margin: float = 1.2) -> Array:
        """`(4,)` the part worth showing: the whole map unless the team used little of it."""
        bounds = self.arena.bounds
        places = [self.poses[..., :2].reshape(-1, 2)]
        places += [s.goals for s in self.status[:: max(1, len(self.status) // 50)]]
        goals = [s.goal[None, :2] for s in self.status if s.goal is not None]
        if goals:
            places.append(np.unique(np.concatenate(goals), axis=0))
        points = np.concatenate(places)
        points = points[np.isfinite(points).all(axis=1)]
        low = np.maximum(points.min(axis=0) - margin, bounds[:2])
        high = np.minimum(points.max(axis=0) + margin, bounds[2:])
        # No strip: the short side is at least half the long one where the map allows it.
        lack = np.maximum(0.5 * float((high - low).max()) - (high - low), 0.0)
        low = np.maximum(low - lack / 2.0, bounds[:2])
        high = np.minimum(low + np.maximum(high - low, 0.5 * float((high - low).max())), bounds[2:])
        span = np.maximum(high - low, 1e-6)
        if np.prod(span) > 0.45 * np.prod(bounds[2:] - bounds[:2]):
            return bounds
        return np.concatenate([low, high])


def arena_of(world: World, shapes: Sequence[Shape]) -> Arena:
    """The arena of a world with those of its shapes that are to be drawn as lasting."""
    grid = world.base
    width, height = grid.size
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    unknown = np.asarray(grid.grid) == -1
    return Arena(
        border=transform_points(grid.origin, corners),
        walls=tuple(cell_rings(grid.occupied & ~unknown, grid.resolution, grid.origin)),
        unknown=tuple(cell_rings(unknown, grid.resolution, grid.origin)),
        shapes=tuple(shape_ring(shape) for shape in shapes),
    )


def radius_of(scenario: Scenario) -> float:
    """The scenario's inflation radius `r_max` in m."""
    value = scenario.planner.r_max
    return DEFAULT_RADIUS if value is None else float(value)


def scene_of(scenario: Scenario, world: World, recording: Recording) -> Scene:
    """Gather the scene of a recording of one cycle or more."""
    tracks = tuple(_track(track) for track in recording.obstacles)
    # A shape of the world that an event moves or removes is drawn by its track alone.
    fixed = list(world.shapes)
    for track in tracks:
        if track.start <= 0.0 and track.shape in fixed:
            fixed.remove(track.shape)
    return Scene(
        name=str(scenario.name),
        arena=arena_of(world, fixed),
        fixed=tuple(fixed),
        tracks=tracks,
        models=scenario.models,
        radius=radius_of(scenario),
        time=np.asarray(recording.time, dtype=float),
        poses=np.asarray(recording.poses, dtype=float),
        status=recording.status,
        notes=recording.notes,
    )


def _track(track: ObstacleTrack) -> Track:
    shape = shape_from_mapping(track.shape)
    return Track(
        shape=shape,
        ring=shape_ring(shape),
        start=float(track.start),
        end=float(track.end),
        time=np.asarray(track.time, dtype=float),
        offset=np.asarray(track.offset, dtype=float).reshape(-1, 2),
    )
