"""A world to plan in, robots that obey, and geometry that is slow and obvious."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from cavalcade.formation import Formation, FormationPlanner, FormationSettings
from cavalcade.formation._clearance import Footprint
from cavalcade.formation.cycle import Cycle
from cavalcade.formation.goals import GoalPlan
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.safety_filter import filtered
from cavalcade.formation.team import Team
from cavalcade.geometry import rotation
from cavalcade.robots.motion import advance, limits_of
from cavalcade.world import OccupancyMap

Hook = Callable[[int, "FormationPlanner"], None]


@dataclass(frozen=True)
class Drive:
    """What a team did, cycle by cycle (T cycles)."""

    time: np.ndarray
    poses: np.ndarray
    commands: np.ndarray
    status: list

    @property
    def states(self) -> list[str]:
        return [status.state for status in self.status]


def drive(
    planner: FormationPlanner,
    poses: np.ndarray,
    seconds: float,
    hook: Hook | None = None,
    until_arrived: bool = True,
) -> Drive:
    """Move ideal robots from rest by the planner's commands; `hook(cycle, planner)` goes first."""
    limits = limits_of(planner.model)
    substeps = 5
    period = 1.0 / planner.rate
    states = np.column_stack([np.array(poses, dtype=float), np.zeros((len(poses), 3))])
    log: list[tuple] = []
    for cycle in range(round(seconds / period)):
        if hook is not None:
            hook(cycle, planner)
        commands = planner.step(states[:, :3].copy(), cycle * period)
        log.append((cycle * period, states[:, :3].copy(), commands, planner.status))
        if until_arrived and planner.status.arrived and np.abs(states[:, 3:]).max() < 0.02:
            break
        for k, command in enumerate(commands):
            state = tuple(states[k])
            for _ in range(substeps):
                state = advance(state, tuple(command), period / substeps, limits)
            states[k] = state
    times, where, said, status = zip(*log, strict=True)
    return Drive(np.array(times), np.array(where), np.array(said), list(status))


def placed(formation: Formation, pose: tuple[float, float, float]) -> np.ndarray:
    """Poses `(N, 3)` of robots that stand in their slots and look ahead."""
    return np.column_stack([formation.placed(pose), np.full(formation.size, pose[2])])


@cache
def _points(length: float, width: float, step: float) -> np.ndarray:
    """See `rectangle_points`, at the origin."""
    x = np.linspace(-length / 2, length / 2, max(2, int(np.ceil(length / step)) + 1))
    y = np.linspace(-width / 2, width / 2, max(2, int(np.ceil(width / step)) + 1))
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def rectangle_points(pose: np.ndarray, length: float, width: float, step: float) -> np.ndarray:
    """Points that cover a rectangle: its corners, its edges and its inside, `step` apart."""
    return _points(length, width, step) @ rotation(pose[2]).T + pose[:2]


def distance_to_rectangle(
    points: np.ndarray, pose: np.ndarray, length: float, width: float
) -> np.ndarray:
    """Distances from points `(N, 2)`, 0 inside."""
    body = (points - pose[:2]) @ rotation(pose[2])
    out = np.maximum(np.abs(body) - (length / 2, width / 2), 0.0)
    return np.hypot(out[:, 0], out[:, 1])


def sampled_gap(
    a: np.ndarray, b: np.ndarray, size_a: tuple, size_b: tuple, step: float = 0.05
) -> float:
    """Gap of two rectangles; exact where they are apart, for a corner is always nearest."""
    if math.dist(a[:2], b[:2]) > (math.hypot(*size_a) + math.hypot(*size_b)) / 2:
        step = math.inf  # too far away to overlap: corners are enough
    return float(
        min(
            distance_to_rectangle(rectangle_points(a, *size_a, step), b, *size_b).min(),
            distance_to_rectangle(rectangle_points(b, *size_b, step), a, *size_a).min(),
        )
    )


def occupied_gap(pose: np.ndarray, size: tuple, occupied: np.ndarray, cell: float) -> float:
    """Distance from a rectangle to the nearest occupied cell or to the border; 0 on contact.

    Where two convex shapes are apart, a corner of one of them is nearest; and a cell is too
    small to cut through a body without one of its corners lying in it.
    """
    corners = rectangle_points(pose, *size, math.inf)
    height, width = np.array(occupied.shape) * cell
    best = float(np.minimum(corners, (width, height) - corners).min())
    # Cells beyond `near` of the body are looked at only where nothing else is as near.
    for near in (0.3, math.inf):
        low = _occupied_within(corners, near, occupied, cell)
        if len(low):
            best = min(best, _gap_to_cells(corners, low, pose, size, cell))
        if best <= near:
            break
    return best


def _occupied_within(
    corners: np.ndarray, near: float, occupied: np.ndarray, cell: float
) -> np.ndarray:
    """Lower corners `(N, 2)` of all occupied cells within `near` of a body, and of some others."""
    top = occupied.shape[::-1]
    c0, r0 = np.clip(np.floor((corners.min(axis=0) - near) / cell), 0, top).astype(int)
    c1, r1 = np.clip(np.ceil((corners.max(axis=0) + near) / cell), 0, top).astype(int)
    return (np.argwhere(occupied[r0:r1, c0:c1])[:, ::-1] + (c0, r0)) * cell


def _gap_to_cells(
    corners: np.ndarray, low: np.ndarray, pose: np.ndarray, size: tuple, cell: float
) -> float:
    """See `occupied_gap`, of cells with these lower corners."""
    out = np.maximum(low[None] - corners[:, None], corners[:, None] - low[None] - cell)
    out = np.maximum(out, 0.0)
    squares = (low[:, None] + cell * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])).reshape(-1, 2)
    return float(
        min(
            np.hypot(out[..., 0], out[..., 1]).min(),
            distance_to_rectangle(squares, pose, *size).min(),
        )
    )


def cycle_of(
    map: OccupancyMap,
    formation: Formation,
    poses: np.ndarray,
    goal: tuple[float, float, float],
    time: float = 0.0,
    team: Team | None = None,
) -> Cycle:
    """The working state of a cycle in which Go1s stand at `poses`, before anything is found out."""
    poses = np.array(poses, dtype=float)
    team = Team(len(poses), formation) if team is None else team
    maps = PlanningMaps(map.occupied, map.resolution, FormationSettings())
    points = np.ascontiguousarray(poses[:, :2])
    plan = GoalPlan(
        maps, np.array(goal), team.formation.slots, points[team.active], Footprint.of(0.65, 0.28)
    )
    return Cycle(plan, team, poses, points, team.active, time)


@dataclass(frozen=True)
class Tools:
    """The above, for tests: `tools.drive(...)`."""

    cycle_of = staticmethod(cycle_of)
    drive = staticmethod(drive)
    placed = staticmethod(placed)
    sampled_gap = staticmethod(sampled_gap)
    occupied_gap = staticmethod(occupied_gap)
    rectangle_points = staticmethod(rectangle_points)
    distance_to_rectangle = staticmethod(distance_to_rectangle)

    @staticmethod
    def mirrored(map: OccupancyMap) -> OccupancyMap:
        """The map reflected at its horizontal middle line: y becomes its height less y."""
        return OccupancyMap(map.grid[::-1], map.resolution, map.origin)


@pytest.fixture(scope="session")
def tools() -> Tools:
    return Tools()


@pytest.fixture
def seen_velocities(monkeypatch) -> list[np.ndarray]:
    """What planners take the velocities `(N, 3)` for, cycle by cycle, as their filter sees it."""
    seen: list[np.ndarray] = []

    def watched(inputs, parameters):
        seen.append(inputs.team.velocities)
        return filtered(inputs, parameters)

    monkeypatch.setattr("cavalcade.formation.planner.filtered", watched)
    return seen
