"""Ways of one robot over even ground past others that move: search in space and time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cavalcade.eikonal import arrival_times
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import STEP, WALK, Trajectory
from cavalcade.lattice._search import FOUND, SPENT, search
from cavalcade.lattice.ground import Ground, read_only
from cavalcade.lattice.motion_limits import mover_of, primitives_of
from cavalcade.lattice.primitives import (
    ACCELERATION,
    DURATION,
    LENGTH,
    RATE,
    TURN,
    TURN_ACCELERATION,
    V0,
    V1,
    VMAX,
    sample_moves,
    trapezoid,
)
from cavalcade.lattice.shortening import shorten
from cavalcade.lattice.surface import surface_along
from cavalcade.robots import RobotModel

_CRAMPED_SPEED = 0.4
"""Of guides, where a body can go but not turn."""

_SECOND_LOOK = 2000
"""Expansions for a shorter way than one that is much longer than it may have to be."""

TRACK_STEP = 0.05
"""Time between the poses of a track, s."""


class Others(NamedTuple):
    """What is to be avoided while it is there, as kernels take it; see `_moves_contact`.

    Attributes:
        tracks: `(J, K, 3)` poses every `step` s, standing at the last for good.
        step: s.
        shapes: `(J, 3)` half length, half width (m), whether round.
        spans: `(C, 3)` which track, from when to when, s.
    """

    tracks: Array
    step: float
    shapes: Array
    spans: Array


NOBODY = Others(np.zeros((0, 1, 3)), TRACK_STEP, np.zeros((0, 3)), np.zeros((0, 3)))


@dataclass(frozen=True)
class Care:
    """How far to keep off, and how closely to look.

    Attributes:
        ground, others: Margins, m.
        steps: Largest steps between tests: m, rad, s.
        finer: How often to halve the steps of the search.
    """

    ground: float = 0.006
    others: float = 0.05
    steps: tuple[float, float, float] = (0.04, 0.03, 0.06)
    finer: int = 0


CAREFUL = (
    Care(),
    Care(0.003, 0.025, (0.03, 0.015, 0.03), 1),
    Care(0.001, 0.003, (0.02, 0.005, 0.004), 1),
    Care(0.0, 0.003, (0.02, 0.001, 0.004), 1),  # where a start or a goal touches something
)
"""Wide margins first; where that finds nothing, smaller ones and smaller steps.

Two bodies that meet at 1.5 m/s come nearer by half of 1.5 m/s times the step in time between two
tests that both find the margin kept: that is never more than the margin. Likewise a corner 0.4 m
from the centre swings by half the step in angle between two tests of the ground."""


@dataclass(frozen=True, eq=False)
class Way:
    """Moves from a start pose, see `_moves`.

    Attributes:
        start: x, y, yaw `(3,)`.
        moves: `(M, 6)`.
        mover: `(11,)`.
        model: Of the robot.
    """

    start: Array
    moves: Array
    mover: Array
    model: RobotModel

    @property
    def duration(self) -> float:
        """S."""
        return float(self.moves[:, DURATION].sum())

    @property
    def length(self) -> float:
        """M."""
        return float(np.abs(self.moves[:, LENGTH]).sum())

    def track(self) -> Array:
        """Poses `(K, 3)` every `TRACK_STEP` s, the last at or after the end."""
        count = math.ceil(self.duration / TRACK_STEP - 1e-9) + 1
        times = np.arange(count) * TRACK_STEP
        return np.ascontiguousarray(sample_moves(self.start, self.moves, self.mover, times)[:, :3])


class TimedPlanner:
    """Plans ways over one ground; keeps what depends on the goal alone.

    Args:
        ground: Even, or to be walked on wherever it is not solid.
        price: Cost of a metre; that of a second is 1. None: two seconds at the robot's speed.
        greed: Factor of what is left to the goal: larger ones find ways sooner, smaller ones
            better ways.
    """

    def __init__(self, ground: Ground, price: float | None = None, greed: float = 1.5) -> None:
        self.ground = ground
        self.price = price
        self.greed = greed
        # Read-only in every case: kernels are compiled for the types they first see.
        ground = read_only(ground)
        self.grid = (ground.cell, ground.solid, ground.clearance)
        self._open = not ground.solid.any()
        self._guides: dict[tuple[int, int, float, float | None], tuple[Array, float]] = {}
        self._kinds: dict[tuple[RobotModel, int], tuple[Array, Array]] = {}

    def plan(
        self,
        model: RobotModel,
        start: Array,
        goal: Array,
        others: Others = NOBODY,
        most: int = 50_000,
        care: Care = CAREFUL[0],
    ) -> tuple[Way | None, bool, int]:
        """The cheapest way that the search finds, from rest to rest, clear of the others for good.

        Args:
            model: Of the robot.
            start, goal: `(3,)` x, y, yaw.
            others: To be avoided.
            most: Expansions.
            care: Margins and steps.

        Returns:
            The way or None; whether that is because `most` was spent; expansions.
        """
        guide = self._likely_guide(start, goal, model)
        way, spent, expansions = self._search(model, start, goal, others, most, care, guide)
        cautious = self.guide(goal, model)
        if guide[0] is cautious[0] or (way is not None and not self._long(way, cautious)):
            return way, spent, expansions
        # What the likely guide thinks little of may be the shorter way, or the only one.
        most = most if way is None else min(most, max(_SECOND_LOOK, expansions))
        other, spent, more = self._search(model, start, goal, others, most, care, cautious)
        if way is not None and (other is None or self.cost(other) >= self.cost(way)):
            other = way
        return other, spent and other is None, expansions + more

    def _long(self, way: Way, guide: tuple[Array, float]) -> bool:
        """Whether a way is much longer than the guide has it."""
        if not guide[0].shape[0]:
            return False
        return way.length > 1.25 * float(guide[0][_cell(guide, way.start)]) + 0.5

    def _search(
        self,
        model: RobotModel,
        start: Array,
        goal: Array,
        others: Others,
        most: int,
        care: Care,
        guide: tuple[Array, float],
    ) -> tuple[Way | None, bool, int]:
        mover, prims = self._kind(model, care.finer)
        price = self.price_for(mover)
        margins = np.array([care.ground, care.others])
        steps = np.array(care.steps)
        status, moves, expansions = search(
            self.grid,
            tuple(others),
            mover,
            start,
            goal,
            prims,
            *guide,
            margins,
            steps,
            np.array([0.1, 0.25]) * 0.5**care.finer,
            price,
            self.greed,
            most,
        )
        if status != FOUND:
            return None, status == SPENT, expansions
        if expansions > 1:
            moves = shorten(self.grid, tuple(others), mover, start, moves, margins, steps, price, 3)
        return Way(start, moves, mover, model), False, expansions

    def cost(self, way: Way) -> float:
        """What the search minimises: seconds and the price of the metres."""
        return way.duration + self.price_for(way.mover) * way.length

    def price_for(self, mover: Array) -> float:
        """What a metre costs, in s."""
        return 2.0 / float(mover[0]) if self.price is None else self.price

    def mover(self, model: RobotModel) -> Array:
        """The model as kernels take it."""
        return self._kind(model, 0)[0]

    def guide(self, goal: Array, model: RobotModel) -> tuple[Array, float]:
        """Lengths of the shortest ways to the goal on a coarser grid, m, and its cell.

        For a disc of half the body's width: no way of it is missed, though some that are found
        lead through what is a little too narrow. `(0, 0)` where nothing stands.
        """
        return self._guide(goal, model.width / 2.0 - 0.75 * self.ground.cell, None)

    def _likely_guide(self, start: Array, goal: Array, model: RobotModel) -> tuple[Array, float]:
        """A guide that has ways be longer where the body cannot turn, to search elsewhere first.

        Where its narrowest ways don't reach the start, the cautious one.
        """
        half = model.width / 2.0
        room = half if model.round else math.hypot(model.length, model.width) / 2.0
        guide, cell = self._guide(goal, half, room)
        if guide.shape[0] and not np.isfinite(guide[_cell((guide, cell), start)]):
            return self.guide(goal, model)
        return guide, cell

    def _guide(self, goal: Array, least: float, room: float | None) -> tuple[Array, float]:
        """Ways over ground with a clearance of at least `least` m, cheap where it is `room` m."""
        if self._open:
            return np.zeros((0, 0)), 1.0
        cell = self.ground.cell
        factor = max(1, round(0.1 / cell))
        row, col = int(goal[1] / cell) // factor, int(goal[0] / cell) // factor
        key = (row, col, least, room)
        if key not in self._guides:
            speed = (self.ground.clearance > least).astype(float)
            if room is not None:
                speed[self.ground.clearance <= room] *= _CRAMPED_SPEED
            speed = _coarser(speed, factor)
            row, col = min(row, speed.shape[0] - 1), min(col, speed.shape[1] - 1)
            speed[row, col] = 1.0
            times = arrival_times(speed, [(row, col)], cell * factor)
            self._guides[key] = (np.ascontiguousarray(times), cell * factor)
        return self._guides[key]

    def _kind(self, model: RobotModel, finer: int) -> tuple[Array, Array]:
        key = (model, finer)
        if key not in self._kinds:
            self._kinds[key] = (mover_of(model), primitives_of(model, finer))
        return self._kinds[key]


def trajectory_of(way: Way, ground: Ground | None = None) -> Trajectory:
    """The way as samples; over uneven ground the body keeps its clearance of the smoothed one."""
    ends = np.concatenate([[0.0], np.cumsum(way.moves[:, DURATION])])
    grid = np.arange(0.0, ends[-1], STEP)
    times = np.unique(np.concatenate([grid, ends, _kinks(way, ends)]))
    times = times[np.concatenate([[True], np.diff(times) > 1e-6])]
    if ends[-1] - times[-1] > 0.0:
        times[-1] = ends[-1]
    motion = sample_moves(way.start, way.moves, way.mover, times)
    height, climb = np.zeros(len(times)), np.zeros(len(times))
    if way.model.legs is not None:
        height += way.model.legs.h_nom
        if ground is not None and not ground.flat:
            rise, along_x, along_y = surface_along(read_only(ground), motion[:, :2])
            height += rise
            climb += along_x * motion[:, 3] + along_y * motion[:, 4]
    position = np.column_stack([motion[:, :2], height])
    velocity = np.column_stack([motion[:, 3:5], climb])
    yaw = motion[:, 2].copy()
    if way.mover[6] > 0.0:
        yaw[:] = way.start[2]
    return Trajectory(times, position, velocity, yaw, np.full(len(times), WALK, dtype=np.int8))


def _kinks(way: Way, ends: Array) -> Array:
    """Times within moves at which their acceleration jumps, s."""
    found = []
    for move, begin in zip(way.moves, ends[:-1], strict=True):
        length, turn = abs(move[LENGTH]), abs(move[TURN])
        ramp, v0, v1, most = way.mover[ACCELERATION], move[V0], move[V1], move[VMAX]
        if length == 0.0:
            length, v0, v1 = turn, 0.0, 0.0
            ramp, most = way.mover[TURN_ACCELERATION], way.mover[RATE]
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
    """Tracks of different lengths as one array, each standing at its last pose for good.

    Args:
        tracks: `(K_j, 3)` poses every `TRACK_STEP` s.
        models: Of the robots on them.
        spans: (track, from, to) in s.
    """
    if not tracks or not spans:
        return NOBODY
    table = stacked(tracks)
    shapes = np.array([[m.length / 2.0, m.width / 2.0, float(m.round)] for m in models])
    return Others(table, TRACK_STEP, shapes, np.array(spans, dtype=float).reshape(-1, 3))


def _cell(guide: tuple[Array, float], pose: Array) -> tuple[int, int]:
    (rows, cols), cell = guide[0].shape, guide[1]
    return min(int(pose[1] / cell), rows - 1), min(int(pose[0] / cell), cols - 1)


def _coarser(speed: Array, factor: int) -> Array:
    """A grid of blocks that are as quick as the quickest of their cells."""
    rows, cols = speed.shape
    padded = np.zeros((-(-rows // factor) * factor, -(-cols // factor) * factor))
    padded[:rows, :cols] = speed
    blocks = padded.reshape(padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    return np.asarray(blocks.max(axis=(1, 3)), dtype=np.float64)
