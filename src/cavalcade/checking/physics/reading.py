"""Records of robots in physics, read from a recording and nothing else."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.checking.physics.record import RobotRecord, Touch
from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.robots.description import JOINTS, LEGS, PARTS

CONTACTS = "/cavalcade/contacts"
_LARGEST = 1e10
"""Of any figure in a sample, as for poses."""

_NAMES = tuple(f"{leg}_{joint}" for leg in LEGS for joint in JOINTS)
_OTHER = re.compile(r"ground|obstacle|robot \d+")
_TOPIC = re.compile(r"/robot_(\d+)/(body|joint_states|foot_force/(?:FL|FR|RL|RR))")
_TYPES = {
    "body": "geometry_msgs/msg/PoseStamped",
    "joint_states": "sensor_msgs/msg/JointState",
    "foot_force": "geometry_msgs/msg/WrenchStamped",
}
_WIDTHS = {"body": 7, "joint_states": 36, "foot_force": 3}
_TEXT = "std_msgs/msg/String"

Rows = dict[str, list[tuple[float, ...]]]
"""By topic: the stamp and the figures of every message."""


def read_records(path: Path, robots: int) -> tuple[RobotRecord, ...]:
    """The records of robots 0 to `robots` - 1.

    Raises:
        RecordingError: The file is missing or damaged, a topic is missing or of another type, a
            robot's topics have not the same stamps, these do not increase, or a figure is no
            finite number.
    """
    rows, texts = _read(path)
    touches = _touches(texts, robots, path)
    records = tuple(_record(k, rows, touches[k], path) for k in range(robots))
    for record in records[1:]:
        if not np.array_equal(record.time, records[0].time):
            topic = f"/robot_{record.robot}/body"
            raise RecordingError("has other stamps than /robot_0/body", file=path, key=topic)
    return records


def _record(robot: int, rows: Rows, touches: tuple[Touch, ...], path: Path) -> RobotRecord:
    names = ("body", "joint_states", *(f"foot_force/{leg}" for leg in LEGS))
    tables = [_table(rows, f"/robot_{robot}/{name}", path) for name in names]
    time = tables[0][:, 0]
    for name, table in zip(names, tables, strict=True):
        if not np.array_equal(table[:, 0], time):
            topic = f"/robot_{robot}/{name}"
            raise RecordingError(f"has other stamps than /robot_{robot}/body", file=path, key=topic)
    body, joints, forces = tables[0][:, 1:], tables[1][:, 1:], tables[2:]
    if (np.diff(time) <= 0.0).any():
        raise RecordingError("the stamps do not increase", file=path, key=f"/robot_{robot}/body")
    if (np.abs((body[:, 3:] ** 2).sum(axis=1) - 1.0) > 1e-3).any():
        raise RecordingError(
            "the orientation is not a rotation", file=path, key=f"/robot_{robot}/body"
        )
    return RobotRecord(
        robot,
        time,
        body,
        joints[:, :12],
        joints[:, 12:24],
        joints[:, 24:],
        np.stack([table[:, 1:] for table in forces], axis=1),
        touches,
    )


def _table(rows: Rows, topic: str, path: Path) -> Array:
    # Where there is no plan a run ends at once, with one sample.
    if not rows.get(topic):
        raise RecordingError("no messages recorded", file=path, key=topic)
    table = np.array(rows[topic], dtype=float)
    # Written so that nan is bad too.
    bad = ~(np.abs(table) < _LARGEST).all(axis=1)
    if bad.any():
        raise RecordingError(
            f"sample {int(bad.argmax())} is not finite or beyond all measure", file=path, key=topic
        )
    return table


def _touches(texts: list[str], robots: int, path: Path) -> list[tuple[Touch, ...]]:
    result: list[list[Touch]] = [[] for _ in range(robots)]
    for text in texts:
        try:
            said = json.loads(text)
            touch = Touch(float(said["time"]), str(said["part"]), str(said["other"]))
            robot = said["robot"]
            known = isinstance(robot, int) and 0 <= robot < robots and touch.part in PARTS
            if not known or not _OTHER.fullmatch(touch.other) or not np.isfinite(touch.time):
                raise ValueError(text)
        except (KeyError, TypeError, ValueError):
            raise RecordingError(f"not a contact: {text[:80]}", file=path, key=CONTACTS) from None
        result[robot].append(touch)
    return [tuple(sorted(touches, key=lambda touch: touch.time)) for touches in result]


def _read(path: Path) -> tuple[Rows, list[str]]:
    from rosbags.rosbag2 import Reader, ReaderError
    from rosbags.typesys import Stores, get_typestore

    if not path.is_file():
        raise RecordingError("there is no such file", file=path)
    store = get_typestore(Stores.ROS2_HUMBLE)
    rows: Rows = {}
    texts: list[str] = []
    try:
        with Reader(path) as reader:
            wanted = [c for c in reader.connections if c.topic == CONTACTS or _kind(c.topic)]
            for connection in wanted:
                kind = _kind(connection.topic)
                expected = _TYPES[kind] if kind else _TEXT
                if connection.msgtype != expected:
                    raise RecordingError(
                        f"expected {expected}, not {connection.msgtype}",
                        file=path,
                        key=connection.topic,
                    )
            for connection, _, data in reader.messages(wanted) if wanted else ():
                message: Any = store.deserialize_cdr(data, connection.msgtype)
                if connection.topic == CONTACTS:
                    texts.append(message.data)
                    continue
                figures = _FIGURES[_kind(connection.topic)](message)
                stamp = message.header.stamp
                row = (stamp.sec + 1e-9 * stamp.nanosec, *figures)
                if len(row) != 1 + _WIDTHS[_kind(connection.topic)]:
                    raise RecordingError(
                        "expected the 12 joints, each with position, velocity and effort",
                        file=path,
                        key=connection.topic,
                    )
                rows.setdefault(connection.topic, []).append(row)
    except RecordingError:
        raise
    except ReaderError as error:
        raise RecordingError(f"not a readable MCAP recording: {error}", file=path) from error
    except OSError as error:
        raise RecordingError(f"cannot be read: {error.strerror}", file=path) from error
    except Exception as error:
        # The reader lets a damaged file surface as whatever its parser tripped over.
        raise RecordingError(
            f"not a readable MCAP recording ({type(error).__name__})", file=path
        ) from error
    return rows, texts


def _kind(topic: str) -> str:
    found = _TOPIC.fullmatch(topic)
    return found[2].split("/")[0] if found else ""


def _body(message: Any) -> Iterator[float]:
    place, turn = message.pose.position, message.pose.orientation
    yield from (place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z)


def _joints(message: Any) -> Iterator[float]:
    if tuple(message.name) != _NAMES:
        return
    for values in (message.position, message.velocity, message.effort):
        yield from values


def _force(message: Any) -> Iterator[float]:
    force = message.wrench.force
    yield from (force.x, force.y, force.z)


_FIGURES: dict[str, Callable[[Any], Iterator[float]]] = {
    "body": _body,
    "joint_states": _joints,
    "foot_force": _force,
}
