"""A recording in memory: what figures, metrics and the replay are made from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus

if TYPE_CHECKING:
    from cavalcade.recording.physics_track import PhysicsTrack


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
