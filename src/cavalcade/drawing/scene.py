"""What every picture of a run or a plan needs, taken once from scenario, world and result."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.outlines import cell_rings, shape_ring
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.metrics.clearance import fixed_shapes
from cavalcade.robots import RobotModel
from cavalcade.world import Shape
from cavalcade.world.occupancy import UNKNOWN

if TYPE_CHECKING:
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario, World

_T = TypeVar("_T")

DEFAULT_RADIUS = 0.30
"""The paper's inflation radius in m, where the scenario does not set another one."""


@dataclass(frozen=True)
class Team:
    """A scenario's robots and their ground, ready to be drawn."""

    scenario: Scenario
    world: World

    @property
    def name(self) -> str:
        """The scenario's."""
        return str(self.scenario.name)

    @cached_property
    def models(self) -> tuple[RobotModel, ...]:
        """One per robot."""
        return self.scenario.models

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.models)

    @property
    def fixed(self) -> tuple[Shape, ...]:
        """The exact shapes that are to be drawn as lasting."""
        return self.world.shapes

    @cached_property
    def outlines(self) -> list[Array]:
        """Rings of the shapes, map frame, m."""
        return [shape_ring(shape) for shape in self.fixed]

    @property
    def border(self) -> Array:
        """`(4, 2)` corners of the map, map frame, m."""
        width, height = self.world.base.size
        return self.world.base.to_map([(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)])

    @property
    def cells(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """`(rows, cols)`: occupied cells of the map without the shapes, and unknown ones."""
        unknown = np.asarray(self.world.base.grid) == UNKNOWN
        return self.world.base.occupied & ~unknown, unknown

    @cached_property
    def rings(self) -> tuple[list[Array], list[Array]]:
        """Rings of both kinds of `cells`, map frame, m."""
        grid = self.world.base
        walls, unknown = (cell_rings(kind, grid.resolution, grid.origin) for kind in self.cells)
        return walls, unknown

    @property
    def bounds(self) -> Array:
        """`(4,)`: lowest x, lowest y, highest x, highest y of the map."""
        return np.concatenate([self.border.min(axis=0), self.border.max(axis=0)])

    def part(self, places: Iterable[Array], margin: float) -> Array:
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
class Scene(Team):
    """A run of one cycle or more, ready to be drawn; map frame, SI units."""

    recording: Recording

    @cached_property
    def fixed(self) -> tuple[Shape, ...]:
        """The exact shapes that are there all the time: what events move has a track alone."""
        return tuple(fixed_shapes(self.world, self.recording))

    @property
    def radius(self) -> float:
        """The inflation radius `r_max`, m."""
        radius = self.scenario.planner.r_max
        return DEFAULT_RADIUS if radius is None else float(radius)

    def view(self, margin: float = 1.2) -> Array:
        """`(4,)` the part worth showing: the whole map unless the team used little of it."""
        status = self.recording.status
        places = [self.recording.poses[..., :2].reshape(-1, 2)]
        places += [s.goals for s in status[:: max(1, len(status) // 50)]]
        goals = [s.goal[None, :2] for s in status if s.goal is not None]
        return self.part([*places, *goals], margin)


@dataclass(frozen=True)
class PlanScene(Team):
    """A plan ready to be drawn; map frame, SI units."""

    plan: PlanResult

    @property
    def result(self) -> str:
        """`solved` or why not."""
        detail = self.plan.summary.get("detail")
        return f"{self.plan.reason}: {detail}" if detail else self.plan.reason

    @property
    def known(self) -> list[tuple[int, Trajectory]]:
        """Robots that have a trajectory, with it."""
        return [(k, path) for k, path in enumerate(self.plan.trajectories) if path is not None]

    @property
    def makespan(self) -> float:
        """Until all are parked, s."""
        return max((path.duration for _, path in self.known), default=0.0)

    def view(self) -> Array:
        """`(4,)` the part worth showing: the whole map unless the team uses little of it."""
        ends = np.array([*self.scenario.starts, *self.scenario.goals], dtype=float)
        driven = [path.position[:, :2] for _, path in self.known]
        return self.part([ends[:, :2], *driven], 1.0)


def runs(values: Iterable[_T]) -> list[tuple[_T, int, int]]:
    """(value, first, last + 1) of each stretch of equal values."""
    found, first = [], 0
    for value, same in groupby(values):
        last = first + sum(1 for _ in same)
        found.append((value, first, last))
        first = last
    return found
