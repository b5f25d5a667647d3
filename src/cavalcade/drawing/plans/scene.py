"""What every picture of a plan needs, taken once from scenario, world and result."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.scene import Arena, arena_of
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, WALK, Trajectory
from cavalcade.robots import RobotModel
from cavalcade.world import Terrain

if TYPE_CHECKING:
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.scenario import Scenario, World

WALKING, FLYING, WAITING, TURNING = "#d7191c", "#1f5fe0", "#c9cdd2", "#f0a3a0"
"""The colours of walking and of flight are those of the paper's Fig. 6."""

STILL = 0.01
"""A body slower than this stands, m/s and rad/s."""


@dataclass(frozen=True)
class PlanScene:
    """A plan ready to be drawn; map frame, SI units, N robots.

    Attributes:
        name: The scenario's.
        result: `solved` or why not.
        solved: Whether it is a plan that can be carried out.
        arena: What is solid.
        terrain: The ground's heights, None where it is flat.
        models: N robot models.
        starts, goals: `(N, 3)` poses.
        paths: N trajectories, None where none is known.
        footholds: N arrays `(M, 6)`.
    """

    name: str
    result: str
    solved: bool
    arena: Arena
    terrain: Terrain | None
    models: tuple[RobotModel, ...]
    starts: Array
    goals: Array
    paths: tuple[Trajectory | None, ...]
    footholds: tuple[Array, ...]

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.models)

    @property
    def known(self) -> list[tuple[int, Trajectory]]:
        """Robots that have a trajectory, with it."""
        return [(robot, path) for robot, path in enumerate(self.paths) if path is not None]

    @property
    def makespan(self) -> float:
        """Until all are parked, s."""
        return max((path.duration for _, path in self.known), default=0.0)

    def view(self, margin: float = 1.0) -> Array:
        """`(4,)` the part worth showing: the whole map unless the team uses little of it."""
        bounds = self.arena.bounds
        places = [self.starts[:, :2], self.goals[:, :2]]
        places += [path.position[:, :2] for _, path in self.known]
        points = np.concatenate(places)
        low = np.maximum(points.min(axis=0) - margin, bounds[:2])
        high = np.minimum(points.max(axis=0) + margin, bounds[2:])
        span = high - low
        # No strip: the short side is at least 0.4 of the long one where the map allows it.
        lack = np.maximum(0.4 * float(span.max()) - span, 0.0)
        low = np.maximum(low - lack / 2.0, bounds[:2])
        high = np.minimum(high + lack / 2.0, bounds[2:])
        whole = bounds[2:] - bounds[:2]
        if np.prod(np.maximum(high - low, 1e-6)) > 0.5 * np.prod(whole):
            return bounds
        return np.concatenate([low, high])


def plan_scene(scenario: Scenario, world: World, made: PlanResult) -> PlanScene:
    """Gather the scene of a plan."""
    detail = made.summary.get("detail")
    return PlanScene(
        name=str(scenario.name),
        result=f"{made.reason}: {detail}" if detail else made.reason,
        solved=made.solved,
        arena=arena_of(world, world.shapes),
        terrain=world.terrain,
        models=scenario.models,
        starts=np.array(scenario.starts, dtype=float).reshape(-1, 3),
        goals=np.array(scenario.goals, dtype=float).reshape(-1, 3),
        paths=made.trajectories,
        footholds=made.footholds,
    )


def activities(path: Trajectory) -> NDArray[np.int8]:
    """`(T - 1,)` of each interval: 0 stands, 1 walks or drives, 2 flies, 3 turns on the spot."""
    steps = np.diff(path.time)
    moved = np.linalg.norm(np.diff(path.position, axis=0), axis=1)
    turned = np.abs(np.diff(path.yaw))
    phase = path.phase[:-1]
    there = (phase == WALK) & (moved < STILL * steps + 1e-6)
    still = there & (turned < STILL * steps + 1e-6)
    kinds = np.where(still, 0, np.where(there, 3, 1))
    return np.where(phase == FLIGHT, 2, kinds).astype(np.int8)


def runs(values: NDArray) -> list[tuple[int, int, int]]:
    """(value, first, last + 1) of each stretch of equal values."""
    if not len(values):
        return []
    edges = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1, [len(values)]])
    return [(int(values[a]), int(a), int(b)) for a, b in pairwise(edges)]


def leaps(path: Trajectory) -> list[tuple[int, int]]:
    """First and last sample of each leap, from the start of its take-off to its landing's end."""
    leaping = np.isin(path.phase[:-1], (TAKE_OFF, FLIGHT, LANDING))
    return [(first, last) for value, first, last in runs(leaping) if value]


def along(path: Trajectory) -> Array:
    """`(T,)` m travelled by each sample, horizontally."""
    steps = np.hypot(*np.diff(path.position[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])
