"""Paths of one robot over even ground past others that move: space-time A*."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cavalcade.eikonal import arrival_times
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import STEP, WALK, Trajectory
from cavalcade.lattice._search import (
    FOUND,
    PAUSED,
    SPENT,
    CostToGo,
    SearchSettings,
    new_frontier,
    search,
)
from cavalcade.lattice.collision import Margins, Others, Scene, grid_of
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.ground import Ground, make_ground, read_only
from cavalcade.lattice.motion_limits import (
    MotionLimits,
    footprint,
    metre_cost,
    motion_limits,
    primitives_of,
)
from cavalcade.lattice.primitives import (
    DURATION,
    LENGTH,
    TURN,
    V0,
    V1,
    VMAX,
    sample_moves,
    trapezoid,
)
from cavalcade.lattice.shortening import shortened_moves
from cavalcade.lattice.surface import surface_along
from cavalcade.robots import RobotModel, robot_model
from cavalcade.world import Box, OccupancyMap

_CRAMPED_SPEED = 0.4
"""Of the likely cost-to-go, where a body can go but not turn."""

_SECOND_LOOK = 2000
"""Expansions for a shorter path than one that is much longer than it may have to be."""

_BIN_SIZE, _BIN_TIME = 0.1, 0.25
"""Of the search's bins, m and s."""

TRACK_STEP = 0.05
"""Time between the poses of a track, s."""

NOBODY = Others(np.zeros((0, 1, 3)), TRACK_STEP, np.zeros((0, 3)), np.zeros((0, 3)))

MARGINS = (
    Margins(0.006, 0.05, 0.04, 0.03, 0.06, 0),
    Margins(0.003, 0.025, 0.03, 0.015, 0.03, 1),
    Margins(0.001, 0.003, 0.02, 0.005, 0.004, 1),
    # Where starts or goals keep no more than the `CLEARANCE` that they have to: at corners, where
    # margins are measured along both sides, that is as far as this.
    Margins(0.0006, 0.0006, 0.02, 0.001, 0.0008, 1),
)
"""Wide margins first; where that finds nothing, smaller ones and smaller steps.

Two bodies that meet at 1.5 m/s come nearer by half of 1.5 m/s times the step in time between two
tests that both find the margin kept: that is never more than the margin. Likewise a corner 0.4 m
from the centre swings by half the step in angle between two tests of the ground."""

FOOTING = Margins(0.0, 0.003, 0.02, 0.001, 0.004, 1)
"""What is left to try on uneven ground: bodies may touch cells on which no foot may stand."""


@dataclass(frozen=True, eq=False)
class TimedPath:
    """Moves `(M, 6)` from a start x, y, yaw `(3,)`, see `cavalcade.lattice.primitives`."""

    start: Array
    moves: Array
    limits: MotionLimits
    model: RobotModel

    @property
    def duration(self) -> float:
        """From the start to the last move's end, s."""
        return float(self.moves[:, DURATION].sum())

    @property
    def length(self) -> float:
        """Summed over the moves, forwards and backwards, m."""
        return float(np.abs(self.moves[:, LENGTH]).sum())

    @property
    def cost(self) -> float:
        """What the search minimises: seconds and the cost of the metres."""
        return self.duration + metre_cost(self.limits.speed) * self.length

    def track(self) -> Array:
        """Poses `(K, 3)` every `TRACK_STEP` s, the last at or after the end."""
        count = math.ceil(self.duration / TRACK_STEP - 1e-9) + 1
        times = np.arange(count) * TRACK_STEP
        return np.ascontiguousarray(sample_moves(self.start, self.moves, self.limits, times)[:, :3])


class SpaceTimePlanner:
    """Plans paths over one ground; keeps what depends on the goal alone.

    Args:
        ground: Even, or to be walked on wherever it is not solid.
        weight: Of the heuristic: larger ones find paths sooner, smaller ones better paths.
    """

    def __init__(self, ground: Ground, *, weight: float = 1.5) -> None:
        self.ground = ground
        self.weight = weight
        self.grid = grid_of(ground)
        self._open = not ground.solid.any()
        self._to_go: dict[tuple[int, int, float, float | None], CostToGo] = {}

    def plan(
        self,
        model: RobotModel,
        start: Array,
        goal: Array,
        others: Others = NOBODY,
        most: int = 50_000,
        margins: Margins = MARGINS[0],
        deadline: Deadline | None = None,
    ) -> tuple[TimedPath | None, bool, int]:
        """The cheapest path that the search finds, from rest to rest, clear of the others for good.

        Start and goal are `(3,)` x, y, yaw. At the deadline the best path so far counts.

        Returns:
            The path or None; whether that is because `most` expansions or the time were spent;
            expansions.
        """
        deadline = deadline or Deadline()
        scene = self.scene(model, others, margins)
        primitives, finer = primitives_of(model, margins.finer), 0.5**margins.finer

        def searched(to_go: CostToGo, most: int) -> tuple[TimedPath | None, bool, int]:
            options = SearchSettings(_BIN_SIZE * finer, _BIN_TIME * finer, self.weight, most, most)
            frontier, expansions, status = new_frontier(start), 0, PAUSED
            for pause in deadline.slices(0, most):
                settings = options._replace(pause=pause)
                status, moves, expansions, frontier = search(
                    scene, goal, primitives, to_go, settings, frontier
                )
                if status != PAUSED:
                    break
            if status == PAUSED and expansions:  # late
                settings = options._replace(most=expansions)
                status, moves, _, _ = search(scene, goal, primitives, to_go, settings, frontier)
            if status != FOUND:
                return None, status in (SPENT, PAUSED), expansions
            if expansions > 1:
                moves = shortened_moves(scene, start, moves, deadline)
            return TimedPath(start, moves, scene.limits, model), False, expansions

        likely = self._likely_cost_to_go(start, goal, model)
        path, spent, expansions = searched(likely, most)
        admissible = self.cost_to_go(goal, model)
        # Whether it is much longer than it has to be; where nothing stands, it is not.
        least = 1.25 * _at(admissible, start) + 0.5 if admissible.lengths.size else math.inf
        if likely is admissible or (path is not None and path.length <= least):
            return path, spent, expansions
        # What the likely cost-to-go thinks little of may be the shorter path, or the only one.
        # (Where nothing stands the two are alike, and a search that found nothing runs again.)
        most = most if path is None else min(most, max(_SECOND_LOOK, expansions))
        other, spent, more = searched(admissible, most)
        if path is not None and (other is None or other.cost >= path.cost):
            other = path
        return other, spent and other is None, expansions + more

    def scene(self, model: RobotModel, others: Others, margins: Margins) -> Scene:
        """A robot among others, as kernels take it."""
        limits = motion_limits(model)
        return Scene(self.grid, others, limits, margins, metre_cost(limits.speed))

    def shortened(
        self, path: TimedPath, others: Others, margins: Margins, deadline: Deadline
    ) -> TimedPath:
        """The path with parts of it replaced by cheaper moves that keep clear of the others."""
        scene = self.scene(path.model, others, margins)
        return replace(path, moves=shortened_moves(scene, path.start, path.moves, deadline))

    def reachable(self, model: RobotModel, start: Array, goal: Array) -> bool:
        """Whether a disc as wide as the body gets from the start to the goal."""
        return math.isfinite(_at(self.cost_to_go(goal, model), start))

    def cost_to_go(self, goal: Array, model: RobotModel) -> CostToGo:
        """Lengths of the shortest paths to the goal on a coarser grid, m.

        For a disc of half the body's width: no path of it is missed, though some that are found
        lead through what is a little too narrow.
        """
        return self._lengths(goal, model.width / 2.0 - 0.75 * self.ground.cell, None)

    def _likely_cost_to_go(self, start: Array, goal: Array, model: RobotModel) -> CostToGo:
        """One that has paths be longer where the body cannot turn, to search elsewhere first.

        Where its narrowest paths don't reach the start, the admissible one.
        """
        half = model.width / 2.0
        turning = half if model.round else math.hypot(model.length, model.width) / 2.0
        to_go = self._lengths(goal, half, turning)
        return to_go if math.isfinite(_at(to_go, start)) else self.cost_to_go(goal, model)

    def _lengths(self, goal: Array, least: float, turning: float | None) -> CostToGo:
        """Over ground with a clearance of `least` m, cheap where it is more than `turning` m."""
        if self._open:
            return CostToGo(np.zeros((0, 0)), 1.0)
        cell = self.ground.cell
        factor = max(1, round(0.1 / cell))
        row, col = int(goal[1] / cell) // factor, int(goal[0] / cell) // factor
        key = (row, col, least, turning)
        if key not in self._to_go:
            speed = (self.ground.clearance > least).astype(float)
            if turning is not None:
                speed[self.ground.clearance <= turning] *= _CRAMPED_SPEED
            speed = _coarser(speed, factor)
            row, col = min(row, speed.shape[0] - 1), min(col, speed.shape[1] - 1)
            speed[row, col] = 1.0
            times = arrival_times(speed, [(row, col)], cell * factor)
            self._to_go[key] = CostToGo(np.ascontiguousarray(times), cell * factor)
        return self._to_go[key]


def trajectory_of(path: TimedPath, ground: Ground | None = None) -> Trajectory:
    """The path as samples; over uneven ground the body keeps its clearance of the smoothed one."""
    ends = np.concatenate([[0.0], np.cumsum(path.moves[:, DURATION])])
    grid = np.arange(0.0, ends[-1], STEP)
    times = np.unique(np.concatenate([grid, ends, _kinks(path, ends)]))
    times = times[np.concatenate([[True], np.diff(times) > 1e-6])]
    if ends[-1] - times[-1] > 0.0:
        times[-1] = ends[-1]
    motion = sample_moves(path.start, path.moves, path.limits, times)
    height, climb = np.zeros(len(times)), np.zeros(len(times))
    if path.model.legs is not None:
        height += path.model.legs.h_nom
        if ground is not None and not ground.flat:
            rise, along_x, along_y = surface_along(read_only(ground), motion[:, :2])
            height += rise
            climb += along_x * motion[:, 3] + along_y * motion[:, 4]
    position = np.column_stack([motion[:, :2], height])
    velocity = np.column_stack([motion[:, 3:5], climb])
    yaw = motion[:, 2].copy()
    if path.limits.free:
        yaw[:] = path.start[2]
    return Trajectory(times, position, velocity, yaw, np.full(len(times), WALK, dtype=np.int8))


def _kinks(path: TimedPath, ends: Array) -> Array:
    """Times within moves at which their acceleration jumps, s."""
    found = []
    for move, begin in zip(path.moves, ends[:-1], strict=True):
        length, turn = abs(move[LENGTH]), abs(move[TURN])
        ramp, v0, v1, most = path.limits.acceleration, move[V0], move[V1], move[VMAX]
        if length == 0.0:
            length, v0, v1 = turn, 0.0, 0.0
            ramp, most = path.limits.yaw_acceleration, path.limits.yaw_rate
        if length > 0.0 and move[DURATION] > 0.0:
            duration, peak = trapezoid(length, v0, v1, most, ramp)
            found += [begin + (peak - v0) / ramp, begin + duration - (peak - v1) / ramp]
    return np.array(found, dtype=np.float64)


def stacked(tracks: Sequence[Array]) -> Array:
    """Tracks of different lengths as one array `(N, K, 3)`, each standing at its last pose."""
    longest = max(map(len, tracks))
    table = np.empty((len(tracks), longest, 3))
    for row, track in zip(table, tracks, strict=True):
        row[: len(track)] = track
        row[len(track) :] = track[-1]
    return table


def others_of(tracks: list[Array], models: list[RobotModel], spans: list[Any]) -> Others:
    """Robots on tracks `(K_j, 3)` every `TRACK_STEP` s, each standing at its last pose for good.

    `spans` are which track, and from when to when in s.
    """
    if not tracks or not spans:
        return NOBODY
    table = stacked(tracks)
    shapes = np.array([footprint(model) for model in models], dtype=float)
    return Others(table, TRACK_STEP, shapes, np.array(spans, dtype=float).reshape(-1, 3))


def warm_up() -> None:
    """Compile or load every kernel of planar planning, on a problem of a moment."""
    # With an obstacle, so that the way is looked for on the grid.
    ground = make_ground(OccupancyMap.empty((4.0, 3.0)).with_shapes([Box((2.0, 0.2), (0.2, 0.2))]))
    model, planner = robot_model("spirit"), SpaceTimePlanner(ground)
    start, goal = np.array([0.6, 1.5, 0.0]), np.array([3.4, 1.5, np.pi])
    first, _, _ = planner.plan(model, start, goal)
    if first is None:
        return
    others = others_of([first.track()], [model], [(0, 0.0, np.inf)])
    second, _, _ = planner.plan(model, goal, start, others)
    trajectory_of(first if second is None else second, ground)


def _at(to_go: CostToGo, pose: Array) -> float:
    """The length to go from a pose's cell, m."""
    rows, cols = to_go.lengths.shape
    if not rows:
        return 0.0
    row, col = min(int(pose[1] / to_go.cell), rows - 1), min(int(pose[0] / to_go.cell), cols - 1)
    return float(to_go.lengths[row, col])


def _coarser(speed: Array, factor: int) -> Array:
    """A grid of blocks that are as quick as the quickest of their cells."""
    rows, cols = speed.shape
    padded = np.zeros((-(-rows // factor) * factor, -(-cols // factor) * factor))
    padded[:rows, :cols] = speed
    blocks = padded.reshape(padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    return np.asarray(blocks.max(axis=(1, 3)), dtype=np.float64)
