"""Recordings as MCAP files of standard ROS 2 messages, for RViz, Foxglove and for us."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Sequence
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import OutputError
from cavalcade.geometry import Array
from cavalcade.recording import _messages
from cavalcade.recording.cdr import Layout
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.recording.physics_mcap import physics_messages, physics_topics
from cavalcade.recording.status_text import StatusEncoder
from cavalcade.robots import RobotModel
from cavalcade.world import OccupancyMap

if TYPE_CHECKING:
    from rosbags.rosbag2 import Writer

MARKER_PERIOD = 0.1
"""Markers are written this often, s."""

STATUS_TOPIC = "/cavalcade/status"
"""std_msgs/String, JSON: the planner's status of every cycle (see `status_text`)."""

NOTES_TOPIC = "/cavalcade/notes"
"""std_msgs/String, JSON `{"time", "text"}`: events and watchdog messages."""

OBSTACLES_TOPIC = "/cavalcade/obstacles"
"""std_msgs/String, JSON: the obstacle tracks, once."""

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
    topics = _topics(recording.poses.shape[1])
    track = recording.physics
    if track is not None:
        topics |= physics_topics(track.size)
        messages += ((time, 10, topic, data) for time, topic, data in physics_messages(track))
    messages.sort(key=itemgetter(0, 1))
    try:
        # rosbags writes a folder of its own; only the file in it is wanted.
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.name}-") as folder:
            bag = Path(folder) / "recording"
            writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
            writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            with writer:
                connections = _connect(writer, topics)
                for time, _, topic, data in messages:
                    writer.write(connections[topic], time, data)
            os.replace(bag / "recording.mcap", target)
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None
    return target


def nanoseconds(time: Array) -> NDArray[np.int64]:
    """Times in s as whole ns."""
    return np.round(np.asarray(time, dtype=float) * 1e9).astype(np.int64)


def _topics(robots: int) -> dict[str, str]:
    """Topics and their message types."""
    kinds = {
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/markers": "visualization_msgs/msg/MarkerArray",
        STATUS_TOPIC: "std_msgs/msg/String",
        NOTES_TOPIC: "std_msgs/msg/String",
        OBSTACLES_TOPIC: "std_msgs/msg/String",
    }
    for robot in range(robots):
        kinds[f"/robot_{robot}/pose"] = "geometry_msgs/msg/PoseStamped"
        kinds[f"/robot_{robot}/pose_estimated"] = "geometry_msgs/msg/PoseStamped"
        kinds[f"/robot_{robot}/cmd_vel"] = "geometry_msgs/msg/TwistStamped"
        kinds[f"/robot_{robot}/path"] = "nav_msgs/msg/Path"
    return kinds


def _connect(writer: Writer, kinds: dict[str, str]) -> dict[str, Any]:
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    definitions = {
        kind: (store.generate_msgdef(kind, ros_version=2)[0], store.hash_rihs01(kind))
        for kind in sorted(set(kinds.values()))
    }
    latched = _latched()
    return {
        topic: writer.add_connection(
            topic,
            kind,
            msgdef=definitions[kind][0],
            rihs01=definitions[kind][1],
            offered_qos_profiles=[latched] if topic in ("/map", OBSTACLES_TOPIC) else [],
        )
        for topic, kind in kinds.items()
    }


def _latched() -> Any:
    """The quality of service with which late subscribers still get the map."""
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    for_ever = QosTime(9223372036, 854775807)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL,
        deadline=for_ever,
        lifespan=for_ever,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=for_ever,
        avoid_ros_namespace_conventions=False,
    )


def _all_messages(
    recording: Recording,
    models: tuple[RobotModel, ...],
    maps: Iterable[tuple[float, OccupancyMap]],
) -> list[_Message]:
    times = nanoseconds(recording.time)
    stamps = times.tolist()
    found: list[_Message] = []

    def series(order: int, topic: str, data: Sequence[bytes | memoryview]) -> None:
        found.extend((time, order, topic, one) for time, one in zip(stamps, data, strict=True))

    first = stamps[0] if stamps else 0
    for moment, grid in maps:
        time = int(nanoseconds(np.array(moment)))
        found.append((time, 0, "/map", _messages.grid_message(time, grid)))
    found.append((first, 1, OBSTACLES_TOPIC, _string(_tracks_text(recording.obstacles))))
    for moment, text in recording.notes:
        said = json.dumps({"time": moment, "text": text}, ensure_ascii=False)
        found.append((int(nanoseconds(np.array(moment))), 2, NOTES_TOPIC, _string(said)))
    if not stamps:
        return found
    encoder = StatusEncoder()
    # The paths come before the status that they belong to.
    found.extend(_paths(recording, stamps))
    series(4, STATUS_TOPIC, [_string(encoder.encode(status)) for status in recording.status])
    series(5, "/tf", _messages.transform_messages(times, recording.poses))
    for robot in range(recording.poses.shape[1]):
        name = f"/robot_{robot}"
        poses, seen = recording.poses[:, robot], recording.estimated[:, robot]
        series(6, f"{name}/pose", _messages.pose_messages(times, poses))
        series(7, f"{name}/pose_estimated", _messages.pose_messages(times, seen))
        commands = recording.commands[:, robot]
        series(8, f"{name}/cmd_vel", _messages.twist_messages(times, commands, robot))
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


def _tracks_text(tracks: tuple[ObstacleTrack, ...]) -> str:
    return json.dumps(
        [
            {
                "shape": track.shape,
                "start": track.start,
                "end": None if np.isinf(track.end) else track.end,
                "time": np.asarray(track.time).tolist(),
                "offset": np.asarray(track.offset).tolist(),
            }
            for track in tracks
        ]
    )


def _string(text: str) -> memoryview:
    return Layout().text(text).pack(1)[0]
