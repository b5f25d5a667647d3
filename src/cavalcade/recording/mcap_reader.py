"""A recording back from its MCAP file."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.recording.mcap_writer import NOTES_TOPIC, OBSTACLES_TOPIC, STATUS_TOPIC
from cavalcade.recording.physics_mcap import FILE, read_physics
from cavalcade.recording.status import PlannerStatus
from cavalcade.recording.status_text import StatusDecoder

_TOPIC = re.compile(r"/robot_\d+/(pose|pose_estimated|cmd_vel|path)|/cavalcade/\w+")


def read_recording(path: str | Path) -> Recording:
    """Read what a run left.

    Args:
        path: The run's folder or the MCAP file itself.

    Raises:
        RecordingError: It is missing, damaged or not one of ours.
    """
    file = Path(path)
    if file.is_dir():
        file = file / FILE
    if not file.is_file():
        raise RecordingError("there is no such recording", file=file)
    parts = _Parts()
    try:
        for topic, time, message in _messages(file):
            parts.take(topic, time, message)
        return replace(parts.recording(), physics=read_physics(file))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise RecordingError(f"not a recording of a run: {error}", file=file) from None


class _Parts:
    def __init__(self) -> None:
        self._rows: dict[str, list[tuple[float, ...]]] = {}
        self._paths: dict[int, Array] = {}
        self._decoder = StatusDecoder()
        self._time: list[int] = []
        self._status: list[PlannerStatus] = []
        self._notes: list[tuple[float, str]] = []
        self._obstacles: tuple[ObstacleTrack, ...] = ()
        self._current: tuple[Array, ...] = ()

    def take(self, topic: str, time: int, message: Any) -> None:
        if topic == STATUS_TOPIC:
            if len(self._current) != len(self._paths) or any(
                one is not self._paths[k] for k, one in enumerate(self._current)
            ):
                self._current = tuple(self._paths[k] for k in sorted(self._paths))
            self._time.append(time)
            self._status.append(self._decoder.decode(message.data, self._current))
        elif topic == NOTES_TOPIC:
            note = json.loads(message.data)
            self._notes.append((float(note["time"]), str(note["text"])))
        elif topic == OBSTACLES_TOPIC:
            self._obstacles = tuple(_track(track) for track in json.loads(message.data))
        elif topic.endswith("/path"):
            points = [(p.pose.position.x, p.pose.position.y) for p in message.poses]
            robot = int(topic.split("/")[1].removeprefix("robot_"))
            self._paths[robot] = np.array(points, dtype=float).reshape(-1, 2)
        elif topic.endswith("/cmd_vel"):
            twist = message.twist
            self._rows.setdefault(topic, []).append(
                (twist.linear.x, twist.linear.y, twist.angular.z)
            )
        elif topic.endswith(("/pose", "/pose_estimated")):
            place, turn = message.pose.position, message.pose.orientation
            yaw = 2.0 * np.arctan2(turn.z, turn.w)
            self._rows.setdefault(topic, []).append((place.x, place.y, float(yaw)))

    def recording(self) -> Recording:
        robots = sum(topic.endswith("/pose") for topic in self._rows)
        return Recording(
            time=np.array(self._time, dtype=float) / 1e9,
            poses=self._columns("pose", robots),
            estimated=self._columns("pose_estimated", robots),
            commands=self._columns("cmd_vel", robots),
            status=tuple(self._status),
            obstacles=self._obstacles,
            notes=tuple(self._notes),
        )

    def _columns(self, name: str, robots: int) -> Array:
        columns = [np.array(self._rows[f"/robot_{robot}/{name}"]) for robot in range(robots)]
        for column in columns:
            if len(column) != len(self._time):
                raise ValueError(f"{len(self._time)} cycles, but {len(column)} of {name}")
        if not columns:
            return np.zeros((len(self._time), 0, 3))
        return np.stack(columns, axis=1)


def _track(said: dict[str, Any]) -> ObstacleTrack:
    return ObstacleTrack(
        shape=said["shape"],
        start=float(said["start"]),
        end=np.inf if said["end"] is None else float(said["end"]),
        time=np.array(said["time"], dtype=float),
        offset=np.array(said["offset"], dtype=float).reshape(-1, 2),
    )


def _messages(file: Path) -> Iterator[tuple[str, int, Any]]:
    """(topic, time in ns, message) in the order of writing, but for the bulky topics."""
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    try:
        with Reader(file) as reader:
            wanted = [c for c in reader.connections if _TOPIC.fullmatch(c.topic)]
            decode: Callable[[Any, str], Any] = store.deserialize_cdr
            if wanted:
                for connection, time, data in reader.messages(wanted):
                    yield connection.topic, time, decode(data, connection.msgtype)
    except Exception as error:  # rosbags meets damaged files with errors of many kinds
        raise RecordingError(f"cannot be read: {error}", file=file) from None
