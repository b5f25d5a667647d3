"""Collects the frames of a run in memory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cavalcade.geometry import Array
from cavalcade.recording.frames import Frame, ObstacleTrack, Recording
from cavalcade.recording.status import PlannerStatus
from cavalcade.world import OccupancyMap

PATH_PERIOD = 0.25
"""The followed paths are kept this often, s; in between, the last ones stand."""

PATH_POINTS = 40
"""Most points that are kept of a path."""


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
