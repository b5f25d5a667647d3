"""A run in memory, cycle by cycle: what figures, metrics and the replay are made from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus
from cavalcade.world import shape_from_mapping

if TYPE_CHECKING:
    from cavalcade.recording.physics_track import PhysicsTrack
    from cavalcade.world import OccupancyMap, Shape


@dataclass(frozen=True)
class Frame:
    """One control cycle of N robots; map frame, SI units. The arrays must not be changed.

    Attributes:
        time: s since the run began.
        poses: `(N, 3)` true poses.
        estimated: `(N, 3)` poses as the policy was given them; may hold nan.
        commands: `(N, 3)` body-frame velocities commanded.
        status: What the policy says of itself.
        planning: Wall time spent in the policy, s.
        notes: What just happened, a line each.
        maps: The map anew, each time it changed in this cycle; of the first frame the map at the
            start, too.
    """

    time: float
    poses: Array
    estimated: Array
    commands: Array
    status: PlannerStatus
    planning: float = 0.0
    notes: tuple[str, ...] = ()
    maps: tuple[OccupancyMap, ...] = ()


FrameSink = Callable[[Frame], None]
"""Whoever wants to see a run while it goes on: called once per cycle."""


@dataclass(frozen=True)
class Recording:
    """One run, cycle by cycle (T cycles, N robots); map frame, SI units.

    Attributes:
        time: `(T,)` s.
        poses: `(T, N, 3)` true poses.
        estimated: `(T, N, 3)` poses as the planner was given them; may hold nan.
        commands: `(T, N, 3)` body-frame velocities commanded at that time.
        status: The planner's status per cycle, T of them.
        obstacles: What the world gained or lost on the way, in order of time.
        notes: (time, text) pairs: events and watchdog messages.
        physics: Bodies, joints, forces and contacts; None for robots without.
    """

    time: Array
    poses: Array
    estimated: Array
    commands: Array
    status: tuple[PlannerStatus, ...]
    obstacles: tuple[ObstacleTrack, ...]
    notes: tuple[tuple[float, str], ...]
    physics: PhysicsTrack | None = None

    @property
    def roles(self) -> NDArray[np.int64]:
        """`(T, N)` slot index of each robot, -1 where it has none."""
        return np.array([status.roles for status in self.status])


@dataclass(frozen=True)
class ObstacleTrack:
    """An obstacle that was added, removed or moved by an event.

    Attributes:
        shape: The scenario file's own words for the shape (a mapping such as
            `{"circle": {"center": [x, y], "radius": r}}`), at its place when it appeared.
        start, end: Seconds between which it was there; end is inf if it stayed.
        time: `(K,)` and
        offset: `(K, 2)`: displacement from its first place over time (piecewise linear).
    """

    shape: dict
    start: float
    end: float
    time: Array
    offset: Array

    @property
    def solid(self) -> Shape:
        """Its exact shape at its first place, map frame."""
        return shape_from_mapping(self.shape)

    def offset_at(self, time: float | Array) -> Array:
        """Displacement `(..., 2)` in m from its first place at the given times."""
        if len(self.time) == 0:
            return np.zeros((*np.shape(time), 2))
        columns = [np.interp(time, self.time, self.offset[:, axis]) for axis in (0, 1)]
        return np.stack(columns, axis=-1)
