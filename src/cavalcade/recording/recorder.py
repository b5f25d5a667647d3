"""Collects a run cycle by cycle, in memory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cavalcade.geometry import Array
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.recording.status import PlannerStatus
from cavalcade.world import OccupancyMap

PATH_PERIOD = 0.25
"""The followed paths are kept this often, s; in between, the last ones stand."""

PATH_POINTS = 40
"""Most points that are kept of a path."""


class Recorder:
    """Takes what each cycle saw and did; gives a `Recording`."""

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
        """(time, map) pairs as they were given to `map`."""
        return tuple(self._maps)

    def cycle(
        self,
        time: float,
        poses: Array,
        estimated: Array,
        commands: Array,
        status: PlannerStatus,
    ) -> None:
        """Keep one cycle; the arrays `(N, 3)` must not be changed afterwards."""
        before = self._status[-1] if self._status else None
        turning_point = (
            before is None
            or status.state != before.state
            or status.leader != before.leader
            or status.waypoint != before.waypoint
        )
        if turning_point or time - self._paths_time >= PATH_PERIOD - 1e-9:
            self._paths = tuple(thinned(path) for path in status.paths)
            self._paths_time = time
        self._time.append(round(time, 9))
        self._poses.append(poses)
        self._estimated.append(estimated)
        self._commands.append(commands)
        self._status.append(replace(status, paths=self._paths))

    def note(self, time: float, text: str) -> None:
        """Keep a line about something that happened."""
        self._notes.append((round(time, 9), text))

    def map(self, time: float, grid: OccupancyMap) -> None:
        """Keep the map as it is from `time` on."""
        self._maps.append((round(time, 9), grid))

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
