"""A run in memory, cycle by cycle: frames, what collects them, and the whole recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus
from cavalcade.world import shape_from_mapping

if TYPE_CHECKING:
    from cavalcade.recording.physics_track import PhysicsTrack
    from cavalcade.world import OccupancyMap, Shape

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
        notes: (time, text) pairs: events and faults.
        physics: Bodies, joints, forces and contacts; None for robots without.
        ended: False if it was read from a file whose writer was stopped before its end: then
            everything up to then is here, and nobody knows how it went on.
    """

    time: Array
    poses: Array
    estimated: Array
    commands: Array
    status: tuple[PlannerStatus, ...]
    obstacles: tuple[ObstacleTrack, ...]
    notes: tuple[tuple[float, str], ...]
    physics: PhysicsTrack | None = None
    ended: bool = True

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


class FrameThinner:
    """Makes frames into those that are kept: with fewer paths, of fewer points.

    Paths are kept at turning points and every `PATH_PERIOD`; in between, the last ones stand.
    """

    def __init__(self) -> None:
        self._before: PlannerStatus | None = None
        self._paths: tuple[Array, ...] = ()
        self._paths_time = -np.inf

    def __call__(self, frame: Frame) -> Frame:
        """The frame as it is kept."""
        status, before = frame.status, self._before
        turning_point = before is None or any(
            getattr(status, name) != getattr(before, name)
            for name in ("state", "leader", "waypoint")
        )
        if turning_point or frame.time - self._paths_time >= PATH_PERIOD - 1e-9:
            self._paths = tuple(thinned(path) for path in status.paths)
            self._paths_time = frame.time
        self._before = status = replace(status, paths=self._paths)
        return replace(frame, time=round(frame.time, 9), status=status)


class Recorder:
    """A sink of frames that gives a `Recording`."""

    def __init__(self) -> None:
        self._frames: list[Frame] = []
        self._thin = FrameThinner()

    @property
    def maps(self) -> tuple[tuple[float, OccupancyMap], ...]:
        """(time, map) pairs: the map as it was from then on."""
        return maps_of(self._frames)

    def __call__(self, frame: Frame) -> None:
        """Keep one cycle."""
        self._frames.append(self._thin(frame))

    def recording(self, obstacles: tuple[ObstacleTrack, ...] = ()) -> Recording:
        """Everything so far."""
        return recording_of(self._frames, obstacles)


def maps_of(frames: Sequence[Frame]) -> tuple[tuple[float, OccupancyMap], ...]:
    """(time, map) pairs: the map as it was from then on."""
    return tuple((frame.time, grid) for frame in frames for grid in frame.maps)


def recording_of(frames: Sequence[Frame], obstacles: tuple[ObstacleTrack, ...] = ()) -> Recording:
    """Cycle by cycle what these frames tell."""
    shape = (len(frames), len(frames[0].poses) if frames else 0, 3)
    return Recording(
        time=np.array([frame.time for frame in frames]),
        poses=np.array([frame.poses for frame in frames]).reshape(shape),
        estimated=np.array([frame.estimated for frame in frames]).reshape(shape),
        commands=np.array([frame.commands for frame in frames]).reshape(shape),
        status=tuple(frame.status for frame in frames),
        obstacles=obstacles,
        notes=tuple((frame.time, text) for frame in frames for text in frame.notes),
    )


def thinned(path: Array, count: int = PATH_POINTS) -> Array:
    """At most `count` points of a path `(K, 2)`, its first and last among them."""
    if len(path) <= count:
        return np.array(path, dtype=float).reshape(-1, 2)
    chosen = np.linspace(0, len(path) - 1, count).round().astype(int)
    return np.asarray(path, dtype=float)[chosen]
