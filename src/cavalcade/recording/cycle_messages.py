"""What a recording says of control cycles, as ROS 2 messages: of a whole run or of a piece."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording import _messages
from cavalcade.recording.cdr import nanoseconds
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.recording.status import StatusEncoder
from cavalcade.robots import RobotModel, body_of, urdf_of
from cavalcade.world import OccupancyMap

MARKER_PERIOD = 0.1
"""Markers are written this often, s."""

Message = tuple[int, int, str, bytes | memoryview]
"""Time in ns, order among messages of the same time, topic, bytes."""


def opening(
    models: Sequence[RobotModel],
    start: float,
    obstacles: Iterable[ObstacleTrack] = (),
    standing: bool = True,
) -> Iterator[Message]:
    """What is said once, at the time `start` in s: robots, their fixed frames, obstacles.

    With `standing` legs do not move: their frames are fixed, too.
    """
    time = int(nanoseconds(start))
    yield text_message(start, 1, _messages.OBSTACLES_TOPIC, [_plain(track) for track in obstacles])
    fixed: list[_messages.Transform] = []
    for robot, model in enumerate(models):
        name = f"robot_{robot}"
        description = _messages.string_message(urdf_of(model, name))
        yield time, 1, f"/{name}/robot_description", description
        body = body_of(model)
        if body is not None:
            fixed += _messages.foot_frames(robot, np.array([[leg.foot for leg in body.legs]]))
            if standing:
                fixed += _messages.standing_frames(robot, body)
    if fixed:
        (data,) = _messages.transform_messages(np.array([time]), fixed)
        yield time, 1, "/tf_static", data


class CycleMessages:
    """Makes messages of cycles, piece after piece of a run in order of time.

    Args:
        models: One per robot.
        frames: Whether poses tell where the robots' frames are; otherwise physics does.
    """

    def __init__(self, models: Sequence[RobotModel], frames: bool = True) -> None:
        self._models = tuple(models)
        self._frames = frames
        self.forget()

    def forget(self) -> None:
        """Leave nothing out of the next piece: what was said before may be lost."""
        self._encode = StatusEncoder()
        self._paths: tuple[Array, ...] = ()
        self._marked = -np.inf

    def __call__(
        self, recording: Recording, maps: Iterable[tuple[float, OccupancyMap]] = ()
    ) -> list[Message]:
        """The messages of a piece, in no order; `maps` as of `write_recording`."""
        times = nanoseconds(recording.time)
        stamps = times.tolist()
        found: list[Message] = []
        for time, grid in maps:
            stamp = int(nanoseconds(time))
            found.append((stamp, 0, "/map", _messages.grid_message(stamp, grid)))
        for time, text in recording.notes:
            said = {"time": time, "text": text}
            found.append(text_message(time, 2, _messages.NOTES_TOPIC, said))
        if not stamps:
            return found
        # The paths come before the status that they belong to.
        found += self._path_messages(recording, stamps)
        texts = [_messages.string_message(self._encode(one)) for one in recording.status]
        found += series(times, 4, _messages.STATUS_TOPIC, texts)
        if self._frames:
            frames = _messages.planar_frames(recording.poses)
            found += series(times, 5, "/tf", _messages.transform_messages(times, frames))
        for robot in range(recording.poses.shape[1]):
            name, poses = f"/robot_{robot}", recording.poses[:, robot]
            seen, commands = recording.estimated[:, robot], recording.commands[:, robot]
            for order, topic, data in (
                (6, "pose", _messages.pose_messages(times, poses)),
                (7, "pose_estimated", _messages.pose_messages(times, seen)),
                (8, "cmd_vel", _messages.twist_messages(times, commands, robot)),
            ):
                found += series(times, order, f"{name}/{topic}", data)
        found += self._markers(recording, times)
        return found

    def _path_messages(self, recording: Recording, stamps: list[int]) -> Iterator[Message]:
        for time, status in zip(stamps, recording.status, strict=True):
            if status.paths is not self._paths:
                for robot, path in enumerate(status.paths):
                    yield time, 3, f"/robot_{robot}/path", _messages.path_message(time, path)
            self._paths = status.paths

    def _markers(self, recording: Recording, times: NDArray[np.int64]) -> Iterator[Message]:
        """Markers at their own, lower rate, packed together per number of springs."""
        groups: dict[int, list[int]] = {}
        for k, time in enumerate(recording.time):
            if time - self._marked >= MARKER_PERIOD - 1e-9:
                groups.setdefault(len(recording.status[k].connections), []).append(k)
                self._marked = time
        for chosen in groups.values():
            status = [recording.status[k] for k in chosen]
            poses = recording.poses[chosen]
            pairs = np.array([s.connections for s in status], dtype=int).reshape(len(chosen), -1, 2)
            row = np.arange(len(chosen))[:, None, None]
            packed = _messages.marker_messages(
                times[chosen],
                poses,
                self._models,
                roles=np.array([s.roles for s in status]),
                leaders=np.array([s.leader for s in status]),
                goals=np.array([s.goals for s in status]),
                springs=poses[row, pairs, :2],
            )
            for k, data in zip(chosen, packed, strict=True):
                yield int(times[k]), 9, "/markers", data


def series(
    times: NDArray[np.int64], order: int, topic: str, data: Sequence[bytes | memoryview]
) -> Iterator[Message]:
    """A message for each of these times in ns."""
    return ((time, order, topic, one) for time, one in zip(times.tolist(), data, strict=True))


def text_message(time: float, order: int, topic: str, content: Any) -> Message:
    """What happened at a time in s, as JSON."""
    said = json.dumps(content, ensure_ascii=False)
    return int(nanoseconds(time)), order, topic, _messages.string_message(said)


def _plain(track: ObstacleTrack) -> dict[str, Any]:
    return {
        "shape": track.shape,
        "start": track.start,
        "end": None if np.isinf(track.end) else track.end,
        "time": np.asarray(track.time).tolist(),
        "offset": np.asarray(track.offset).tolist(),
    }
