"""What is recorded of robots in physics, as arrays, read from a recording and nothing else."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.checking.physics.rotations import matrices
from cavalcade.checking.tracks import has_end, read_messages, stamp_of, table_of
from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.robots.description import JOINTS, LEGS, PARTS

CONTACTS = "/cavalcade/contacts"

_JOINTS = tuple(f"{leg}_{joint}_joint" for leg in LEGS for joint in JOINTS)
_OTHER = re.compile(r"ground|obstacle|robot \d+")
_TOPIC = re.compile(r"/robot_\d+/(body|joint_states|foot_force/(?:FL|FR|RL|RR))")
_TYPES = {
    "body": "geometry_msgs/msg/PoseStamped",
    "joint_states": "sensor_msgs/msg/JointState",
    "foot_force": "geometry_msgs/msg/WrenchStamped",
    "contacts": "std_msgs/msg/String",
}

Rows = dict[str, list[tuple[float, ...]]]
"""By topic: the stamp and the figures of every message."""


@dataclass(frozen=True)
class Touch:
    """A recorded contact that is not a foot on the ground.

    Attributes:
        time: s.
        part: `trunk`, `hip`, `thigh`, `calf` or `foot`.
        other: `ground`, `obstacle` or `robot k`.
    """

    time: float
    part: str
    other: str


@dataclass(frozen=True)
class RobotRecord:
    """One robot's samples; legs front left, front right, rear left, rear right.

    Attributes:
        robot: Which.
        time: `(T,)` s, increasing.
        base: `(T, 7)` the trunk's frame in the map frame: x, y, z in m and quaternion w, x, y, z.
        joints: `(T, 12)` rad, per leg hip, thigh, calf.
        rates: `(T, 12)` rad/s.
        torques: `(T, 12)` N m, those of largest magnitude since the sample before.
        forces: `(T, 4, 3)` N, mean contact force on each foot since the sample before, map frame.
        touches: In order of time.
    """

    robot: int
    time: Array
    base: Array
    joints: Array
    rates: Array
    torques: Array
    forces: Array
    touches: tuple[Touch, ...] = ()

    @property
    def turn(self) -> Array:
        """Rotations `(T, 3, 3)` of the trunk, body to map."""
        return matrices(self.base[:, 3:])

    @property
    def steps(self) -> Array:
        """Durations `(T - 1,)` of the intervals between samples, s."""
        return self.time[1:] - self.time[:-1]


def records_from(
    time: Array, motion: Sequence[Array], touches: Sequence[Sequence[Touch]]
) -> tuple[RobotRecord, ...]:
    """The records of a team from arrays of all robots, as they would be read from a file.

    `motion` are base, joints, rates, torques and forces `(T, N, ...)`, in this order, as of
    `RobotRecord`; `touches` are those of each robot.
    """
    base, joints, rates, torques, forces = (np.moveaxis(array, 1, 0) for array in motion)
    return tuple(
        RobotRecord(k, time, base[k], joints[k], rates[k], torques[k], forces[k], _in_order(own))
        for k, own in enumerate(touches)
    )


def read_records(path: Path, robots: int) -> tuple[RobotRecord, ...]:
    """The records of robots 0 to `robots` - 1.

    Raises:
        RecordingError: The file is missing or damaged, a topic is missing or of another type, a
            robot's topics have not the same stamps, these do not increase, or a figure is no
            finite number.
    """
    rows: Rows = {}
    texts: list[str] = []

    def take(topic: str, message: Any) -> None:
        if topic == CONTACTS:
            texts.append(message.data)
            return
        figures = _figures(_kind(topic), message)
        if not figures:
            text = "expected the 12 joints, each with position, velocity and effort"
            raise RecordingError(text, file=path, key=topic)
        rows.setdefault(topic, []).append((stamp_of(message), *figures))

    read_messages(path, lambda topic: _TYPES.get(_kind(topic), ""), take)
    if not has_end(path):
        count = min(map(len, rows.values()), default=0)
        rows = {topic: figures[:count] for topic, figures in rows.items()}
    touches = _touches(texts, robots, path)
    records = tuple(_record(k, rows, touches[k], path) for k in range(robots))
    for record in records[1:]:
        if not np.array_equal(record.time, records[0].time):
            topic = f"/robot_{record.robot}/body"
            raise RecordingError("has other stamps than /robot_0/body", file=path, key=topic)
    return records


def _record(robot: int, rows: Rows, touches: tuple[Touch, ...], path: Path) -> RobotRecord:
    names = ("body", "joint_states", *(f"foot_force/{leg}" for leg in LEGS))
    topics = [f"/robot_{robot}/{name}" for name in names]
    tables = []
    for topic in topics:
        # Where there is no plan a run ends at once, with one sample.
        if not rows.get(topic):
            raise RecordingError("no messages recorded", file=path, key=topic)
        tables.append(table_of(rows[topic], path, topic))
    time = tables[0][:, 0]
    for topic, table in zip(topics, tables, strict=True):
        if not np.array_equal(table[:, 0], time):
            raise RecordingError(f"has other stamps than {topics[0]}", file=path, key=topic)
    body, joints, *forces = (table[:, 1:] for table in tables)
    if (np.diff(time) <= 0.0).any():
        raise RecordingError("the stamps do not increase", file=path, key=topics[0])
    if (np.abs((body[:, 3:] ** 2).sum(axis=1) - 1.0) > 1e-3).any():
        raise RecordingError("the orientation is not a rotation", file=path, key=topics[0])
    angles, rates, torques = np.split(joints, 3, axis=1)
    return RobotRecord(robot, time, body, angles, rates, torques, np.stack(forces, axis=1), touches)


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
    return [_in_order(touches) for touches in result]


def _in_order(touches: Sequence[Touch]) -> tuple[Touch, ...]:
    return tuple(sorted(touches, key=lambda touch: touch.time))


def _kind(topic: str) -> str:
    """Which of `_TYPES` a topic is of; empty if none."""
    if topic == CONTACTS:
        return "contacts"
    found = _TOPIC.fullmatch(topic)
    return found[1].split("/")[0] if found else ""


def _figures(kind: str, message: Any) -> tuple[float, ...]:
    """What a message says of a robot; nothing if it is of other joints."""
    if kind == "body":
        place, turn = message.pose.position, message.pose.orientation
        return place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z
    if kind == "foot_force":
        force = message.wrench.force
        return force.x, force.y, force.z
    figures = (*message.position, *message.velocity, *message.effort)
    whole = tuple(message.name) == _JOINTS and len(figures) == 3 * len(_JOINTS)
    return figures if whole else ()
