"""What every picture of a run or a plan needs, taken once from scenario, world and result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from cavalcade.drawing.outlines import cell_rings, shape_ring
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.metrics.clearance import fixed_shapes
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel
from cavalcade.world import OccupancyMap, Shape, Terrain
from cavalcade.world.occupancy import UNKNOWN

if TYPE_CHECKING:
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.recording.frames import ObstacleTrack, Recording
    from cavalcade.scenario import Scenario, World

_T = TypeVar("_T")

DEFAULT_RADIUS = 0.30
"""The paper's inflation radius in m, where the scenario does not set another one."""


@dataclass(frozen=True)
class Arena:
    """The ground of a run; map frame, m.

    Attributes:
        border: `(4, 2)` corners of the map.
        walls: Rings of the map file's occupied cells.
        unknown: Rings of the cells nothing is known of.
        shapes: Outlines of the exact shapes that are there all the time.
        terrain: The heights; None for level ground.
    """

    border: Array
    walls: tuple[Array, ...]
    unknown: tuple[Array, ...]
    shapes: tuple[Array, ...]
    terrain: Terrain | None

    @property
    def bounds(self) -> Array:
        """`(4,)`: lowest x, lowest y, highest x, highest y."""
        return np.concatenate([self.border.min(axis=0), self.border.max(axis=0)])

    def view(self, places: Iterable[Array], margin: float) -> Array:
        """`(4,)` the part around all points `(K, 2)`; the whole map unless that is little."""
        bounds = self.bounds
        points = np.concatenate(list(places))
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


@dataclass(frozen=True)
class _Team:
    """What runs and plans have in common.

    Attributes:
        name: The scenario's.
        arena: The ground.
        models: N robot models.
    """

    name: str
    arena: Arena
    models: tuple[RobotModel, ...]

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.models)


@dataclass(frozen=True)
class Scene(_Team):
    """A run ready to be drawn: T cycles, N robots, map frame, SI units.

    Attributes:
        fixed: The exact shapes that are there all the time.
        tracks: Obstacles that came, went or moved.
        radius: The inflation radius `r_max`.
        time: `(T,)`.
        poses: `(T, N, 3)` true poses.
        status: T planner states.
        notes: (time, text) of what happened.
    """

    fixed: tuple[Shape, ...]
    tracks: tuple[ObstacleTrack, ...]
    radius: float
    time: Array
    poses: Array
    status: tuple[PlannerStatus, ...]
    notes: tuple[tuple[float, str], ...]

    def view(self, margin: float = 1.2) -> Array:
        """`(4,)` the part worth showing: the whole map unless the team used little of it."""
        places = [self.poses[..., :2].reshape(-1, 2)]
        places += [s.goals for s in self.status[:: max(1, len(self.status) // 50)]]
        goals = [s.goal[None, :2] for s in self.status if s.goal is not None]
        return self.arena.view([*places, *goals], margin)


@dataclass(frozen=True)
class PlanScene(_Team):
    """A plan ready to be drawn; map frame, SI units, N robots.

    Attributes:
        result: `solved` or why not.
        solved: Whether it is a plan that can be carried out.
        starts, goals: `(N, 3)` poses.
        paths: N trajectories, None where none is known.
        footholds: N arrays `(M, 6)`.
    """

    result: str
    solved: bool
    starts: Array
    goals: Array
    paths: tuple[Trajectory | None, ...]
    footholds: tuple[Array, ...]

    @property
    def known(self) -> list[tuple[int, Trajectory]]:
        """Robots that have a trajectory, with it."""
        return [(robot, path) for robot, path in enumerate(self.paths) if path is not None]

    @property
    def makespan(self) -> float:
        """Until all are parked, s."""
        return max((path.duration for _, path in self.known), default=0.0)

    def view(self) -> Array:
        """`(4,)` the part worth showing: the whole map unless the team uses little of it."""
        driven = [path.position[:, :2] for _, path in self.known]
        return self.arena.view([self.starts[:, :2], self.goals[:, :2], *driven], 1.0)


def runs(values: Iterable[_T]) -> list[tuple[_T, int, int]]:
    """(value, first, last + 1) of each stretch of equal values."""
    found, first = [], 0
    for value, same in groupby(values):
        last = first + sum(1 for _ in same)
        found.append((value, first, last))
        first = last
    return found


def map_border(grid: OccupancyMap) -> Array:
    """Corners `(4, 2)` of a map, map frame."""
    width, height = grid.size
    return grid.to_map([(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)])


def arena_of(world: World, shapes: Sequence[Shape]) -> Arena:
    """The arena of a world with those of its shapes that are to be drawn as lasting."""
    grid = world.base
    unknown = np.asarray(grid.grid) == UNKNOWN
    return Arena(
        border=map_border(grid),
        walls=tuple(cell_rings(grid.occupied & ~unknown, grid.resolution, grid.origin)),
        unknown=tuple(cell_rings(unknown, grid.resolution, grid.origin)),
        shapes=tuple(shape_ring(shape) for shape in shapes),
        terrain=world.terrain,
    )


def scene_of(scenario: Scenario, world: World, recording: Recording) -> Scene:
    """Gather the scene of a recording of one cycle or more."""
    # A shape of the world that an event moves or removes is drawn by its track alone.
    fixed = fixed_shapes(world, recording)
    radius = scenario.planner.r_max
    return Scene(
        name=str(scenario.name),
        arena=arena_of(world, fixed),
        fixed=tuple(fixed),
        tracks=recording.obstacles,
        models=scenario.models,
        radius=DEFAULT_RADIUS if radius is None else float(radius),
        time=np.asarray(recording.time, dtype=float),
        poses=np.asarray(recording.poses, dtype=float),
        status=recording.status,
        notes=recording.notes,
    )


def plan_scene(scenario: Scenario, world: World, made: PlanResult) -> PlanScene:
    """Gather the scene of a plan."""
    detail = made.summary.get("detail")
    return PlanScene(
        name=str(scenario.name),
        arena=arena_of(world, world.shapes),
        models=scenario.models,
        result=f"{made.reason}: {detail}" if detail else made.reason,
        solved=made.solved,
        starts=np.array(scenario.starts, dtype=float).reshape(-1, 3),
        goals=np.array(scenario.goals, dtype=float).reshape(-1, 3),
        paths=made.trajectories,
        footholds=made.footholds,
    )
