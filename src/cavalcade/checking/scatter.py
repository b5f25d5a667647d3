"""Measured poses scatter about the true ones: by how much, and what is sure all the same.

Of simulated robots true poses are known. Those of live robots come from motion capture or
odometry; a check that took each for true would find contacts and speeds that never were. So
their scatter is estimated from the poses alone, a straight line over half a second at each moment
takes most of it away, and a violation is what four standard deviations of the rest don't explain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from cavalcade.checking.arrival import Criterion
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel

WINDOW = 0.5
"""Of the lines, s: shorter than it takes to brake."""

SURE = 4.0
"""Standard deviations; beyond them lies one of 16,000 samples."""

LEAST = 1e-3
"""Poses that scatter less than this are taken as they are, m and rad."""


@dataclass(frozen=True)
class Measured:
    """A robot's motion as far as its measured poses tell.

    Attributes:
        track: At the same times.
        place: Standard deviation of the measured positions, m along each axis; 0 where poses
            are exact.
        turn: The same of headings, rad.
        samples: How many samples each pose of the track is taken of.
    """

    track: Track
    place: float = 0.0
    turn: float = 0.0
    samples: int = 1

    @property
    def sure(self) -> float:
        """How far positions of the track may be wrong, m; twice that at its ends."""
        return SURE * self.place / math.sqrt(self.samples)

    @property
    def sure_turn(self) -> float:
        """The same of headings, rad."""
        return SURE * self.turn / math.sqrt(self.samples)

    @property
    def sure_speed(self) -> float:
        """How far the slope of a line over `WINDOW` may be wrong, m/s."""
        return self.sure * math.sqrt(12.0) / WINDOW

    @property
    def start_error(self) -> tuple[float, float]:
        """How far the track may begin from a start that was measured once, m and rad."""
        beside = math.sqrt(1.0 + 4.0 / self.samples)
        return SURE * self.place * beside, SURE * self.turn * beside


def measured(track: Track, whole: Track | None = None) -> Measured:
    """What a track of measured poses tells, whose time stamps increase.

    It may be a stretch of a `whole` one, which tells how its poses scatter.
    """
    whole = track if whole is None else whole
    steps = np.diff(whole.time)
    count = 1 + round(WINDOW / float(np.median(steps))) if len(steps) else 1
    if count < 3 or len(whole.time) <= count:
        return Measured(track)
    place = _scatter(whole.pose[:, :2])
    turn = _scatter(whole.pose[:, 2:])
    if place < LEAST and turn < LEAST:
        return Measured(track)
    count = min(count, len(track.time))
    if count < 3:
        return Measured(track, place, turn)
    return Measured(Track(track.time, _on_lines(track, count)), place, turn, count)


def within(models: Sequence[RobotModel], team: Sequence[Measured]) -> tuple[RobotModel, ...]:
    """The models with footprints that the robots' own surely cover."""
    result = []
    for model, one in zip(models, team, strict=True):
        around = one.sure + one.sure_turn * math.hypot(model.length, model.width) / 2.0
        length, width = (max(side - 2.0 * around, 1e-3) for side in (model.length, model.width))
        result.append(model.with_limits(length=length, width=width) if around > 0.0 else model)
    return tuple(result)


def widened(criterion: Criterion, team: Sequence[Measured]) -> Criterion:
    """The criterion of arrival, for poses at the ends of these tracks."""
    return replace(
        criterion,
        distance=criterion.distance + 2.0 * max(one.sure for one in team),
        turn=criterion.turn + 2.0 * max(one.sure_turn for one in team),
        speed=criterion.speed + max(one.sure_speed for one in team),
    )


def _scatter(values: Array) -> float:
    """Standard deviation of each of `(T, K)` values about what changes slowly.

    Second differences leave nothing of even motion and six times the variance of what is
    independent from sample to sample; their median leaves out moments of acceleration.
    """
    second = np.abs(np.diff(values, n=2, axis=0))
    each = np.median(second, axis=0) / 0.6745 / math.sqrt(6.0)
    return float(np.sqrt((each**2).mean()))


def _on_lines(track: Track, count: int) -> Array:
    """Poses `(T, 3)` on straight lines through `count` samples about each."""
    total = len(track.time)
    first = np.clip(np.arange(total) - count // 2, 0, total - count)
    time = sliding_window_view(track.time, count)[first] - track.time[:, None]
    pose = sliding_window_view(track.pose, count, axis=0)[first]
    middle = time.mean(axis=1)
    away = (time - middle[:, None])[:, None]
    slope = (away * pose).sum(axis=2) / (away**2).sum(axis=2)
    line: Array = pose.mean(axis=2) - slope * middle[:, None]
    return line
