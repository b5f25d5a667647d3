"""Recordings as MCAP files of standard ROS 2 messages, for RViz, Foxglove and for us."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import OutputError
from cavalcade.geometry import Array
from cavalcade.recording import _messages
from cavalcade.recording.cdr import nanoseconds, stamps_of
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.recording.status import encoded
from cavalcade.robots import LEGS, RobotModel
from cavalcade.world import OccupancyMap

if TYPE_CHECKING:
    from rosbags.rosbag2 import Writer

FILE = "recording.mcap"
"""A run's recording in its folder."""

MARKER_PERIOD = 0.1
"""Markers are written this often, s."""

_Message = tuple[int, int, str, bytes | memoryview]
"""Time in ns, order among messages of the same time, topic, bytes."""


def write_recording(
    path: str | Path,
    recording: Recording,
    models: Sequence[RobotModel],
    maps: Iterable[tuple[float, OccupancyMap]] = (),
) -> Path:
    """Write a recording, all at once.

    Args:
        path: The new file; one that is there is replaced.
        recording: What happened.
        models: One per robot, for the size of the markers.
        maps: (time in s, map) as it was from then on.

    Returns:
        The file written.

    Raises:
        OutputError: It cannot be written.
    """
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    target = Path(path)
    messages = _all_messages(recording, tuple(models), maps)
    bodies = 0
    if recording.physics is not None:
        bodies = recording.physics.size
        messages += physics_messages(recording.physics)
        messages += _physics_frames(recording.physics, models)
    topics = _messages.topics_of(recording.poses.shape[1], bodies)
    messages.sort(key=itemgetter(0, 1))
    try:
        # rosbags writes a folder of its own; only the file in it is wanted.
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.name}-") as folder:
            bag = Path(folder) / "recording"
            # From version 9 on, names stand for the policies of a quality of service. Up to ROS 2
            # Iron only numbers are understood; Jazzy and later go by the version.
            writer = Writer(bag, version=8, storage_plugin=StoragePlugin.MCAP)
            writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            with writer:
                connections = _connect(writer, topics)
                for time, _, topic, data in messages:
                    writer.write(connections[topic], time, data)
            os.replace(bag / "recording.mcap", target)
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None
    return target


def physics_messages(track: PhysicsTrack) -> Iterator[_Message]:
    """Every message of a track; of each topic in order of time."""
    times = nanoseconds(track.time)
    count, stamp = len(times), stamps_of(times)
    for robot in range(track.size):
        name = f"/robot_{robot}"
        # The quaternion is w, x, y, z in memory and x, y, z, w in messages.
        pose = track.base[:, robot][:, (0, 1, 2, 4, 5, 6, 3)]
        yield from _series(
            times, 10, f"{name}/body", _messages.POSE.pack(count, stamp=stamp, pose=pose)
        )
        columns = {
            column: getattr(track, name)[:, robot]
            for column, name in _messages.JOINT_COLUMNS.items()
        }
        joints = _messages.joints_layout(robot).pack(count, stamp=stamp, **columns)
        yield from _series(times, 10, f"{name}/joint_states", joints)
        wrench = np.zeros((count, len(LEGS), 6))
        wrench[..., :3] = track.foot_forces[:, robot]
        for k, leg in enumerate(LEGS):
            layout = _messages.force_layout(robot, leg)
            forces = layout.pack(count, stamp=stamp, wrench=wrench[:, k])
            yield from _series(times, 10, f"{name}/foot_force/{leg}", forces)
    for contact in track.contacts:
        yield _text(contact.time, 10, _messages.CONTACTS_TOPIC, asdict(contact))
    for fall in track.falls:
        yield _text(fall.time, 10, _messages.FALLS_TOPIC, asdict(fall))


def _physics_frames(track: PhysicsTrack, models: Sequence[RobotModel]) -> Iterator[_Message]:
    """The transforms of all robots at each sample."""
    frames: list[_messages.Transform] = []
    for robot, model in enumerate(models):
        legs, joints = model.description, track.joints[:, robot]
        feet = None if legs is None else legs.foot_places(joints)
        frames += _messages.legged_frames(robot, track.base[:, robot], feet)
    times = nanoseconds(track.time)
    return _series(times, 5, "/tf", _messages.transform_messages(times, frames))


def _connect(writer: Writer, kinds: dict[str, str]) -> dict[str, Any]:
    from rosbags import interfaces as ros
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    definitions = {
        kind: (store.generate_msgdef(kind, ros_version=2)[0], store.hash_rihs01(kind))
        for kind in sorted(set(kinds.values()))
    }
    for_ever = ros.QosTime(9223372036, 854775807)
    # With this quality of service late subscribers still get the map.
    latched = ros.Qos(
        history=ros.QosHistory.KEEP_LAST,
        depth=1,
        reliability=ros.QosReliability.RELIABLE,
        durability=ros.QosDurability.TRANSIENT_LOCAL,
        deadline=for_ever,
        lifespan=for_ever,
        liveliness=ros.QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=for_ever,
        avoid_ros_namespace_conventions=False,
    )
    return {
        topic: writer.add_connection(
            topic,
            kind,
            msgdef=definitions[kind][0],
            rihs01=definitions[kind][1],
            offered_qos_profiles=[latched] if topic in ("/map", _messages.OBSTACLES_TOPIC) else [],
        )
        for topic, kind in kinds.items()
    }


def _all_messages(
    recording: Recording,
    models: tuple[RobotModel, ...],
    maps: Iterable[tuple[float, OccupancyMap]],
) -> list[_Message]:
    times = nanoseconds(recording.time)
    stamps = times.tolist()
    found: list[_Message] = [
        (int(nanoseconds(time)), 0, "/map", _messages.grid_message(int(nanoseconds(time)), grid))
        for time, grid in maps
    ]
    tracks = [_plain(track) for track in recording.obstacles]
    start = recording.time[0] if stamps else 0.0
    found.append(_text(start, 1, _messages.OBSTACLES_TOPIC, tracks))
    for time, text in recording.notes:
        found.append(_text(time, 2, _messages.NOTES_TOPIC, {"time": time, "text": text}))
    if not stamps:
        return found
    # The paths come before the status that they belong to.
    found.extend(_paths(recording, stamps))
    said = [_messages.string_message(text) for text in encoded(recording.status)]
    found.extend(_series(times, 4, _messages.STATUS_TOPIC, said))
    if recording.physics is None:  # otherwise its samples tell of these frames, too
        frames = _messages.planar_frames(recording.poses)
        found.extend(_series(times, 5, "/tf", _messages.transform_messages(times, frames)))
    for robot in range(recording.poses.shape[1]):
        name = f"/robot_{robot}"
        for order, topic, data in (
            (6, "pose", _messages.pose_messages(times, recording.poses[:, robot])),
            (7, "pose_estimated", _messages.pose_messages(times, recording.estimated[:, robot])),
            (8, "cmd_vel", _messages.twist_messages(times, recording.commands[:, robot], robot)),
        ):
            found.extend(_series(times, order, f"{name}/{topic}", data))
    found.extend(_markers(recording, times, models))
    return found


def _paths(recording: Recording, stamps: list[int]) -> Iterable[_Message]:
    before: tuple[Array, ...] = ()
    for time, status in zip(stamps, recording.status, strict=True):
        if status.paths is not before:
            for robot, path in enumerate(status.paths):
                yield time, 3, f"/robot_{robot}/path", _messages.path_message(time, path)
        before = status.paths


def _markers(
    recording: Recording, times: NDArray[np.int64], models: tuple[RobotModel, ...]
) -> Iterable[_Message]:
    """Markers at their own, lower rate, packed together per number of springs."""
    groups: dict[int, list[int]] = {}
    last = -np.inf
    for k, time in enumerate(recording.time):
        if time - last >= MARKER_PERIOD - 1e-9:
            groups.setdefault(len(recording.status[k].connections), []).append(k)
            last = time
    for chosen in groups.values():
        status = [recording.status[k] for k in chosen]
        poses = recording.poses[chosen]
        pairs = np.array([s.connections for s in status], dtype=int).reshape(len(chosen), -1, 2)
        row = np.arange(len(chosen))[:, None, None]
        packed = _messages.marker_messages(
            times[chosen],
            poses,
            models,
            roles=np.array([s.roles for s in status]),
            leaders=np.array([s.leader for s in status]),
            goals=np.array([s.goals for s in status]),
            springs=poses[row, pairs, :2],
        )
        for k, data in zip(chosen, packed, strict=True):
            yield int(times[k]), 9, "/markers", data


def _plain(track: ObstacleTrack) -> dict[str, Any]:
    return {
        "shape": track.shape,
        "start": track.start,
        "end": None if np.isinf(track.end) else track.end,
        "time": np.asarray(track.time).tolist(),
        "offset": np.asarray(track.offset).tolist(),
    }


def _series(
    times: NDArray[np.int64], order: int, topic: str, data: Sequence[bytes | memoryview]
) -> Iterator[_Message]:
    """A message for each of these times in ns."""
    return ((time, order, topic, one) for time, one in zip(times.tolist(), data, strict=True))


def _text(time: float, order: int, topic: str, content: Any) -> _Message:
    """What happened at a time in s, as JSON."""
    said = json.dumps(content, ensure_ascii=False)
    return int(nanoseconds(time)), order, topic, _messages.string_message(said)
