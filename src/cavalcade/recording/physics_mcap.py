"""Tracks of physics as the messages of a recording, and back."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.recording import _physics_messages as messages
from cavalcade.recording._physics_messages import CONTACTS_TOPIC, FALLS_TOPIC
from cavalcade.recording.cdr import Layout, nanoseconds_of
from cavalcade.recording.physics_track import ContactEvent, FallEvent, PhysicsTrack
from cavalcade.robots import LEGS

FILE = "recording.mcap"
"""A run's recording in its folder."""


def physics_topics(robots: int) -> dict[str, str]:
    """Topics and their message types for so many robots."""
    kinds = {CONTACTS_TOPIC: "std_msgs/msg/String", FALLS_TOPIC: "std_msgs/msg/String"}
    for robot in range(robots):
        kinds[messages.body_topic(robot)] = "geometry_msgs/msg/PoseStamped"
        kinds[messages.joints_topic(robot)] = "sensor_msgs/msg/JointState"
        for leg in range(len(LEGS)):
            kinds[messages.force_topic(robot, leg)] = "geometry_msgs/msg/WrenchStamped"
    return kinds


def physics_messages(track: PhysicsTrack) -> Iterator[tuple[int, str, bytes | memoryview]]:
    """Time in ns, topic and bytes of every message; of each topic in order of time."""
    times = _nanoseconds(track.time)
    stamps = times.tolist()
    for robot in range(track.size):
        topic = messages.body_topic(robot)
        for time, data in zip(
            stamps, messages.body_messages(times, track.base[:, robot]), strict=True
        ):
            yield time, topic, data
        joints = messages.joints_messages(
            times,
            track.joints[:, robot],
            track.joint_rates[:, robot],
            track.torques[:, robot],
            robot,
        )
        topic = messages.joints_topic(robot)
        for time, data in zip(stamps, joints, strict=True):
            yield time, topic, data
        for leg in range(len(LEGS)):
            topic = messages.force_topic(robot, leg)
            forces = messages.force_messages(times, track.foot_forces[:, robot, leg], robot, leg)
            for time, data in zip(stamps, forces, strict=True):
                yield time, topic, data
    for contact in track.contacts:
        said: dict[str, Any] = {
            "time": contact.time,
            "robot": contact.robot,
            "part": contact.part,
            "other": contact.other,
        }
        yield _stamp(contact.time), CONTACTS_TOPIC, _string(json.dumps(said))
    for fall in track.falls:
        text = json.dumps({"time": fall.time, "robot": fall.robot})
        yield _stamp(fall.time), FALLS_TOPIC, _string(text)


def read_physics(path: str | Path) -> PhysicsTrack | None:
    """The track of a recording, None if it was not made in physics.

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
    found = _raw_messages(file)
    robots = sum(topic.endswith("/body") for topic in found)
    if not robots:
        return None
    try:
        return _track(found, robots)
    except (KeyError, TypeError, ValueError) as error:
        raise RecordingError(f"not a recording of physics: {error}", file=file) from None
    except RecordingError as error:
        raise RecordingError(str(error), file=file) from None


def _track(found: dict[str, list[bytes]], robots: int) -> PhysicsTrack:
    count = len(found[messages.body_topic(0)])
    time: NDArray[np.int64] | None = None
    base = np.zeros((count, robots, 7))
    joints = {name: np.zeros((count, robots, 12)) for name in ("position", "velocity", "effort")}
    forces = np.zeros((count, robots, len(LEGS), 3))

    def columns(topic: str, layout: Layout) -> dict[str, Any]:
        nonlocal time
        read = layout.unpack(found[topic])
        stamps = nanoseconds_of(read["stamp"])
        if time is None:
            time = stamps
        if len(stamps) != count or (stamps != time).any():
            raise ValueError(f"{topic} has other times than {messages.body_topic(0)}")
        return read

    for robot in range(robots):
        pose = columns(messages.body_topic(robot), messages.body_layout())["pose"]
        base[:, robot] = pose[:, (0, 1, 2, 6, 3, 4, 5)]
        read = columns(messages.joints_topic(robot), messages.joints_layout(robot))
        for name, values in joints.items():
            values[:, robot] = read[name]
        for leg in range(len(LEGS)):
            layout = messages.force_layout(robot, leg)
            read = columns(messages.force_topic(robot, leg), layout)
            forces[:, robot, leg] = read["wrench"][:, :3]
    return PhysicsTrack(
        time=np.array(time, dtype=float) / 1e9,
        base=base,
        joints=joints["position"],
        joint_rates=joints["velocity"],
        torques=joints["effort"],
        foot_forces=forces,
        contacts=tuple(_contacts(found.get(CONTACTS_TOPIC, ()))),
        falls=tuple(_falls(found.get(FALLS_TOPIC, ()))),
    )


def _contacts(data: Iterable[bytes]) -> Iterator[ContactEvent]:
    for one in data:
        said = json.loads(_text(one))
        yield ContactEvent(
            float(said["time"]), int(said["robot"]), str(said["part"]), str(said["other"])
        )


def _falls(data: Iterable[bytes]) -> Iterator[FallEvent]:
    for one in data:
        said = json.loads(_text(one))
        yield FallEvent(float(said["time"]), int(said["robot"]))


def _raw_messages(file: Path) -> dict[str, list[bytes]]:
    """The bytes of each topic of physics, in order of time."""
    from rosbags.rosbag2 import Reader

    found: dict[str, list[bytes]] = {}
    try:
        with Reader(file) as reader:
            robots = sum(c.topic.endswith("/body") for c in reader.connections)
            known = physics_topics(robots)
            wanted = [c for c in reader.connections if known.get(c.topic) == c.msgtype]
            if wanted:
                for connection, _, data in reader.messages(wanted):
                    found.setdefault(connection.topic, []).append(data)
    except Exception as error:  # rosbags meets damaged files with errors of many kinds
        raise RecordingError(f"cannot be read: {error}", file=file) from None
    return found


def _nanoseconds(time: Array) -> Any:
    return np.round(np.asarray(time, dtype=float) * 1e9).astype(np.int64)


def _stamp(time: float) -> int:
    return round(time * 1e9)


def _string(text: str) -> memoryview:
    return Layout().text(text).pack(1)[0]


def _text(data: bytes) -> str:
    return bytes(data[8:-1]).decode()
