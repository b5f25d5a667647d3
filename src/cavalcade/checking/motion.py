"""The team on one clock: between two of its ticks everything moves evenly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.solids import Solid
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel


@dataclass(frozen=True)
class Body:
    """One robot's footprint over the intervals of the common clock.

    Attributes:
        index: Which robot.
        half: `(2,)` half of its length and of its width, m; zero for a disc.
        begin: `(T, 3)` pose at the start of each interval.
        change: `(T, 3)` change of the pose over it.
        skin: How far the footprint reaches beyond the rectangle of `half` on all sides, m: the
            radius of a disc, otherwise 0.
    """

    index: int
    half: Array
    begin: Array
    change: Array
    skin: float = 0.0

    @property
    def radius(self) -> float:
        """Of the circle around the footprint, m."""
        return float(np.hypot(*self.half)) + self.skin

    @property
    def turning(self) -> Array:
        """`(T,)` bound on how far a point of the footprint moves about the centre, m."""
        return float(np.hypot(*self.half)) * np.abs(self.change[:, 2])

    @property
    def bounds(self) -> Array:
        """`(T, 4)` boxes x0, y0, x1, y1 around all the footprint covers in an interval, m."""
        ends = np.stack((self.begin[:, :2], self.begin[:, :2] + self.change[:, :2]))
        return np.hstack((ends.min(axis=0) - self.radius, ends.max(axis=0) + self.radius))

    def at(self, interval: NDArray[np.int64], fraction: Array) -> Array:
        """Poses `(M, 3)` at fractions `(M,)` of intervals `(M,)`."""
        return self.begin[interval] + fraction[:, None] * self.change[interval]


def common_clock(tracks: tuple[Track, ...], solids: tuple[Solid, ...]) -> Array:
    """Ticks `(T + 1,)` in s, at least two.

    They are all samples, and all moments in between at which an obstacle appears, vanishes or
    changes its motion.
    """
    samples = np.unique(np.concatenate([track.time for track in tracks]))
    knots = [np.concatenate((solid.time, (solid.start, solid.end))) for solid in solids]
    extra = np.concatenate(knots) if knots else np.empty(0)
    extra = extra[(extra > samples[0]) & (extra < samples[-1])]
    ticks = np.unique(np.concatenate((samples, extra)))
    return ticks if len(ticks) > 1 else np.repeat(ticks, 2)


def bodies(
    tracks: tuple[Track, ...], models: tuple[RobotModel, ...], ticks: Array
) -> tuple[Body, ...]:
    """The robots' footprints over the intervals between ticks `(T + 1,)`."""
    result = []
    for k, (track, model) in enumerate(zip(tracks, models, strict=True)):
        half, skin = np.array([model.length, model.width]) / 2.0, 0.0
        if model.round:
            half, skin = np.zeros(2), model.length / 2.0
        pose = track.at(ticks)
        result.append(Body(k, half, pose[:-1], np.diff(pose, axis=0), skin))
    return tuple(result)
