"""A recording back from its MCAP file."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.mcap_framing import readable
from cavalcade.recording import _messages
from cavalcade.recording.cdr import Layout, nanoseconds_of
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.recording.mcap_messages import Messages, read_messages
from cavalcade.recording.mcap_writer import FILE
from cavalcade.recording.physics_track import ContactEvent, FallEvent, PhysicsTrack
from cavalcade.recording.status import decoded
from cavalcade.robots import JOINT_NAMES, LEGS
from cavalcade.values import path_of

_BULKY = ("/map", "/tf", "/tf_static", "/markers")
"""What is only for other programs."""

_Found = dict[str, Messages]
"""By topic what its messages hold."""


def read_recording(path: str | Path, *, forces: bool = True) -> Recording:
    """Read what a run left, from its folder or the MCAP file itself.

    If the end of the file is missing, because its writer was stopped or the file was cut off, the
    cycles that are whole are read, with a warning, and `Recording.ended` is False.

    Args:
        path: Folder or file.
        forces: Read the forces on feet, too, which take most of the time for runs in physics;
            without them they are zero.

    Raises:
        RecordingError: It is missing, damaged or not one of ours.
    """
    file = path_of(path, kind=RecordingError)
    if file.is_dir():
        file = file / FILE
    if not file.is_file():
        raise RecordingError("there is no such recording", file=file)
    with readable(file) as (whole, ended):
        found = _messages_of(whole, file, forces)
    try:
        if not ended:
            _cut_to_whole_cycles(found)
        recording = replace(_recording(found, forces), ended=ended)
    except RecordingError as error:
        raise RecordingError(str(error), file=file) from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise RecordingError(f"not a recording of a run: {error}", file=file) from None
    if not ended:
        last = f"{recording.time[-1]:.2f} s" if len(recording.time) else "nothing"
        warnings.warn(
            f"{file}: the end of this recording is missing; read up to {last}", stacklevel=2
        )
    return recording


def _cut_to_whole_cycles(found: _Found) -> None:
    """Leave out the last messages of topics that have more of them than others."""
    cycles, samples = [_messages.STATUS_TOPIC], []
    for topic in found:
        if topic.endswith(("/pose", "/pose_estimated", "/cmd_vel")):
            cycles.append(topic)
        elif topic.endswith(("/body", "/joint_states")) or "/foot_force/" in topic:
            samples.append(topic)
    for group in (cycles, samples):
        count = min((len(found.get(topic, ())) for topic in group), default=0)
        for topic in group:
            found.setdefault(topic, Messages()).cut(count)


def _messages_of(whole: Path, file: Path, forces: bool) -> _Found:
    """The messages of `whole`, which has what is whole of `file`."""

    def wanted(topic: str) -> bool:
        return topic not in _BULKY and (forces or "/foot_force/" not in topic)

    try:
        found = read_messages(whole, wanted)
    except RecordingError as error:
        raise error.at(file=file) from None
    robots = sum(topic.endswith("/pose") for topic, _ in found)
    bodies = sum(topic.endswith("/body") for topic, _ in found)
    known = _messages.topics_of(robots, bodies, 0)
    return {topic: one for (topic, kind), one in found.items() if one and known.get(topic) == kind}


def _recording(found: _Found, with_forces: bool) -> Recording:
    time = _times(found.get(_messages.STATUS_TOPIC, Messages()))
    robots = sum(topic.endswith("/pose") for topic in found)
    shape = (len(time), robots, 3)
    poses, estimated, commands = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for robot in range(robots):
        name = f"/robot_{robot}"
        for topic, values in (("pose", poses), ("pose_estimated", estimated)):
            read = _columns(found, f"{name}/{topic}", _messages.POSE, time)["pose"]
            values[:, robot, :2] = read[:, :2]
            values[:, robot, 2] = 2.0 * np.arctan2(read[:, 5], read[:, 6])
        read = _columns(found, f"{name}/cmd_vel", _messages.twist_layout(robot), time)["twist"]
        commands[:, robot] = read[:, (0, 1, 5)]
    notes = _contents(found, _messages.NOTES_TOPIC)
    tracks = _contents(found, _messages.OBSTACLES_TOPIC)
    return Recording(
        time=time / 1e9,
        poses=poses,
        estimated=estimated,
        commands=commands,
        status=tuple(decoded(_said(found, robots))),
        obstacles=tuple(_obstacle(track) for track in tracks[-1]) if tracks else (),
        notes=tuple((float(note["time"]), str(note["text"])) for note in notes),
        physics=_physics(found, with_forces),
    )


def _said(found: _Found, robots: int) -> Iterator[tuple[str, tuple[Array, ...]]]:
    """The status of every cycle as text, with the paths as they were written last."""
    written = [
        (time, robot, data)
        for robot in range(robots)
        for time, data in _pairs(found, f"/robot_{robot}/path")
    ]
    written.sort(key=lambda one: one[0], reverse=True)
    paths: dict[int, Array] = {}
    current: tuple[Array, ...] = ()
    for time, data in _pairs(found, _messages.STATUS_TOPIC):
        while written and written[-1][0] <= time:
            _, robot, path = written.pop()
            paths[robot] = _messages.points_of(path)
            current = tuple(paths[k] for k in sorted(paths))
        yield _messages.string_of(data), current


def _physics(found: _Found, with_forces: bool) -> PhysicsTrack | None:
    """The track of a run in physics."""
    robots = sum(topic.endswith("/body") for topic in found)
    if not robots:
        return None
    time = _times(found["/robot_0/body"])
    base = np.zeros((len(time), robots, 7))
    shape = (len(time), robots, len(JOINT_NAMES))
    joints = {name: np.zeros(shape) for name in _messages.JOINT_COLUMNS.values()}
    forces = np.zeros((len(time), robots, len(LEGS), 3))
    for robot in range(robots):
        topic = f"/robot_{robot}"
        pose = _columns(found, f"{topic}/body", _messages.POSE, time)["pose"]
        base[:, robot] = pose[:, (0, 1, 2, 6, 3, 4, 5)]
        read = _columns(found, f"{topic}/joint_states", _messages.joints_layout(robot), time)
        for column, name in _messages.JOINT_COLUMNS.items():
            joints[name][:, robot] = read[column]
        for k, leg in enumerate(LEGS if with_forces else ()):
            layout = _messages.force_layout(robot, leg)
            read = _columns(found, f"{topic}/foot_force/{leg}", layout, time)
            forces[:, robot, k] = read["wrench"][:, :3]
    contacts, falls = (
        _contents(found, topic) for topic in (_messages.CONTACTS_TOPIC, _messages.FALLS_TOPIC)
    )
    return PhysicsTrack(
        time=time / 1e9,
        base=base,
        **joints,
        foot_forces=forces,
        contacts=tuple(
            ContactEvent(
                float(said["time"]), int(said["robot"]), str(said["part"]), str(said["other"])
            )
            for said in contacts
        ),
        falls=tuple(FallEvent(float(said["time"]), int(said["robot"])) for said in falls),
    )


def _obstacle(said: dict[str, Any]) -> ObstacleTrack:
    return ObstacleTrack(
        shape=said["shape"],
        start=float(said["start"]),
        end=np.inf if said["end"] is None else float(said["end"]),
        time=np.array(said["time"], dtype=float),
        offset=np.array(said["offset"], dtype=float).reshape(-1, 2),
    )


def _times(messages: Messages) -> NDArray[np.int64]:
    return np.array(messages.times, dtype=np.int64)


def _pairs(found: _Found, topic: str) -> Iterator[tuple[int, bytes]]:
    messages = found.get(topic, Messages())
    return zip(messages.times, messages.data, strict=True)


def _columns(
    found: _Found, topic: str, layout: Layout, time: NDArray[np.int64]
) -> dict[str, NDArray[Any]]:
    """The columns of a topic that has a message for each of these times in ns."""
    read = layout.unpack(found[topic].data)
    if not np.array_equal(nanoseconds_of(read["stamp"]), time):
        raise ValueError(f"{topic} has other times than it should")
    return read


def _contents(found: _Found, topic: str) -> list[Any]:
    """What the messages of a topic say in JSON."""
    return [json.loads(_messages.string_of(data)) for _, data in _pairs(found, topic)]
