"""A run in memory, cycle by cycle: frames, what collects them, and the whole recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus

if TYPE_CHECKING:
    from cavalcade.recording.physics_track import PhysicsTrack
    from cavalcade.world import OccupancyMap

PATH_PERIOD = 0.25
"""The followed paths are kept this often, s; in between, the last ones stand."""

PATH_POINTS = 40
"""Most points that are kept of a path."""


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


class Recorder:
    """A sink of frames that gives a `Recording`."""

    def __init__(self) -> None:
        self._time: list[float] = []
        self._poses: list[Array] = []
        self._estimated: list[Array] = []
        self._commands: list[Array] = []
        self._status: list[PlannerStatus] = []
        self._notes: list[tuple[float, str]] = []
        self._maps: list[tuple[float, OccupancyMap]] = []
        self._paths: tuple[Array, ...] = ()
        self._paths_time = -np.inf

    @property
    def maps(self) -> tuple[tuple[float, OccupancyMap], ...]:
        """(time, map) pairs: the map as it was from then on."""
        return tuple(self._maps)

    def __call__(self, frame: Frame) -> None:
        """Keep one cycle."""
        status, time = frame.status, round(frame.time, 9)
        before = self._status[-1] if self._status else None
        turning_point = (
            before is None
            or status.state != before.state
            or status.leader != before.leader
            or status.waypoint != before.waypoint
        )
        if turning_point or frame.time - self._paths_time >= PATH_PERIOD - 1e-9:
            self._paths = tuple(thinned(path) for path in status.paths)
            self._paths_time = frame.time
        self._time.append(time)
        self._poses.append(frame.poses)
        self._estimated.append(frame.estimated)
        self._commands.append(frame.commands)
        self._status.append(replace(status, paths=self._paths))
        self._notes += [(time, text) for text in frame.notes]
        self._maps += [(time, grid) for grid in frame.maps]

    def recording(self, obstacles: tuple[ObstacleTrack, ...] = ()) -> Recording:
        """Everything so far."""
        size = self._poses[0].shape[0] if self._poses else 0
        shape = (len(self._time), size, 3)
        return Recording(
            time=np.array(self._time),
            poses=np.array(self._poses).reshape(shape),
            estimated=np.array(self._estimated).reshape(shape),
            commands=np.array(self._commands).reshape(shape),
            status=tuple(self._status),
            obstacles=obstacles,
            notes=tuple(self._notes),
        )


def thinned(path: Array, count: int = PATH_POINTS) -> Array:
    """At most `count` points of a path `(K, 2)`, its first and last among them."""
    if len(path) <= count:
        return np.array(path, dtype=float).reshape(-1, 2)
    chosen = np.linspace(0, len(path) - 1, count).round().astype(int)
    return np.asarray(path, dtype=float)[chosen]
