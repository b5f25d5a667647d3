"""Recorded motion: the true poses of each robot, read from the recording and nothing else.

And whether they show the whole run: time stamps, gaps, the same samples for all.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.checking.report import Violation, broken
from cavalcade.errors import RecordingError
from cavalcade.geometry import Array, wrap_angle
from cavalcade.mcap_framing import readable

_TOPIC = re.compile(r"/robot_(\d+)/pose")
_TYPE = "geometry_msgs/msg/PoseStamped"
_LARGEST = 1e10
"""Of any figure in a sample: it must leave room for squares, and for seconds since 1970."""


Pose = tuple[float, float, float]

_SLACK = 1e-6
_START = (0.05, 0.05)
"""How far the first sample may lie from the scenario's start, m and rad: one cycle of motion."""


@dataclass(frozen=True)
class Track:
    """One robot's motion; between samples the pose changes evenly.

    Attributes:
        time: `(T,)` s, as stamped.
        pose: `(T, 3)` x, y in m, yaw in rad, map frame; the yaw does not jump at pi.
    """

    time: Array
    pose: Array

    def at(self, time: Array) -> Array:
        """Poses `(K, 3)` at times `(K,)`; before the first and after the last sample it stands."""
        columns = [np.interp(time, self.time, self.pose[:, k]) for k in range(3)]
        return np.stack(columns, axis=1)


def read_tracks(path: Path, robots: int) -> tuple[Track, ...]:
    """The tracks of robots 0 to `robots` - 1; if the file's end is missing, what all have.

    Raises:
        RecordingError: The file is missing or damaged, a robot has no poses, there are robots
            that the scenario does not have, or a pose is not finite or not planar.
    """
    samples: dict[int, list[tuple[float, ...]]] = {}

    def type_of(topic: str) -> str:
        return _TYPE if _TOPIC.fullmatch(topic) else ""

    def take(topic: str, message: Any) -> None:
        robot = int(topic[len("/robot_") : -len("/pose")])
        place, turn = message.pose.position, message.pose.orientation
        sample = (stamp_of(message), place.x, place.y, turn.x, turn.y, turn.z, turn.w)
        samples.setdefault(robot, []).append(sample)

    read_messages(path, type_of, take)
    unknown = sorted(set(samples) - set(range(robots)))
    if unknown:
        raise RecordingError(
            f"poses of a robot that the scenario does not have; it has {robots}",
            file=path,
            key=f"/robot_{unknown[0]}/pose",
        )
    tracks = tuple(_track(samples.get(k, []), path, f"/robot_{k}/pose") for k in range(robots))
    if has_end(path):
        return tracks
    count = min(len(track.time) for track in tracks)
    return tuple(Track(track.time[:count], track.pose[:count]) for track in tracks)


def has_end(path: Path) -> bool:
    """Whether a recording was written to its end; otherwise its writer was stopped before.

    Raises:
        RecordingError: It cannot be read, or nothing in it is whole.
    """
    with readable(path) as (_, ended):
        return ended


def _track(samples: list[tuple[float, ...]], path: Path, topic: str) -> Track:
    if not samples:
        raise RecordingError("no poses recorded", file=path, key=topic)
    table = table_of(samples, path, topic)
    x, y, z, w = table[:, 3:].T
    tilted = (np.abs(table[:, 3:] ** 2 @ np.ones(4) - 1.0) > 1e-3) | (np.hypot(x, y) > 1e-3)
    if tilted.any():
        raise RecordingError(
            f"the orientation at {table[tilted.argmax(), 0]:.3f} s is not a planar rotation",
            file=path,
            key=topic,
        )
    yaw = np.unwrap(2.0 * np.arctan2(z, w))
    return Track(table[:, 0], np.column_stack((table[:, 1:3], yaw)))


def read_messages(
    path: Path, type_of: Callable[[str], str], take: Callable[[str, Any], None]
) -> None:
    """Hand messages of an MCAP file to `take`, with their topics, in order.

    `type_of` says of what type a topic's messages must be: empty if they are of no interest.

    Raises:
        RecordingError: The file is missing or damaged, a topic is of another type, or `take`
            raises it.
    """
    from rosbags.rosbag2 import Reader, ReaderError
    from rosbags.typesys import Stores, get_typestore

    if not path.is_file():
        raise RecordingError("there is no such file", file=path)
    store = get_typestore(Stores.ROS2_HUMBLE)
    try:
        with readable(path) as (whole, _), Reader(whole) as reader:
            wanted = [one for one in reader.connections if type_of(one.topic)]
            for one in wanted:
                if one.msgtype != (expected := type_of(one.topic)):
                    text = f"expected {expected}, not {one.msgtype}"
                    raise RecordingError(text, file=path, key=one.topic)
            for one, _, data in reader.messages(wanted) if wanted else ():
                take(one.topic, store.deserialize_cdr(data, one.msgtype))
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


def stamp_of(message: Any) -> float:
    """The time in s in a message's header."""
    stamp = message.header.stamp
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def table_of(samples: list[tuple[float, ...]], path: Path, topic: str) -> Array:
    """The samples `(T, K)` of a topic.

    Raises:
        RecordingError: A figure is no finite number.
    """
    table = np.array(samples, dtype=float)
    # Written so that nan is bad too.
    bad = ~(np.abs(table) < _LARGEST).all(axis=1)
    if bad.any():
        raise RecordingError(
            f"sample {int(bad.argmax())} is not finite or beyond all measure", file=path, key=topic
        )
    return table


def disordered(tracks: tuple[Track, ...]) -> list[Violation]:
    """Time stamps that do not increase; such tracks can be judged no further."""
    result = []
    for robot, track in enumerate(tracks):
        steps = np.diff(track.time)
        for k in np.flatnonzero(steps <= 0.0)[:1]:
            text = f"the time stamps of robot {robot} do not increase"
            result.append(broken("samples", track.time[k + 1], robot, text, steps[k]))
    return result


def joined(parts: Sequence[Track]) -> Track:
    """One track of its parts, which follow each other."""
    time = np.concatenate([one.time for one in parts])
    return Track(time, np.concatenate([one.pose for one in parts]))


def incomplete(
    tracks: tuple[Track, ...], rate: float, end: float | None, live: bool = False
) -> list[Violation]:
    """Samples that are missing: between others, at the end, or for some robots only.

    There is at least a sample per cycle of the planner's `rate`, Hz; `end` is the simulated time
    that the summary claims, s, if it does. Cycles of `live` robots may be late: see `breaks`.
    """
    result = []
    cycle = 1.0 / rate
    longest = np.inf if live else cycle
    samples = np.unique(np.concatenate([track.time for track in tracks]))
    for robot, track in enumerate(tracks):
        gaps = np.diff(track.time)
        for k in np.flatnonzero(gaps > longest * (1.0 + 1e-3) + _SLACK):
            text = f"robot {robot} has no samples for {gaps[k]:.3f} s; a cycle lasts {cycle:.3f} s"
            result.append(broken("samples", track.time[k], robot, text, gaps[k], longest))
        if len(track.time) != len(samples):
            missing = float(np.setdiff1d(samples, track.time)[0])
            have, most = len(track.time), len(samples)
            text = f"robot {robot} has {have} samples of {most}"
            result.append(Violation("samples", missing, (robot,), text, have, most))
    if end is not None and samples[-1] - samples[0] < end - 2.0 * cycle - _SLACK:
        duration = float(samples[-1] - samples[0])
        everyone = tuple(range(len(tracks)))
        text = f"the recording covers {duration:.2f} s, the summary says {end:.2f} s"
        result.append(Violation("samples", float(samples[-1]), everyone, text, duration, end))
    return result


def broken_off(tracks: tuple[Track, ...]) -> Violation:
    """That the recording's end is missing: what came then, nobody knows."""
    end = max(float(track.time[-1]) for track in tracks)
    text = f"the recording breaks off at {end:.2f} s: whoever wrote it was stopped before its end"
    return Violation("samples", end, tuple(range(len(tracks))), text, end, end)


def misplaced(
    tracks: tuple[Track, ...],
    starts: tuple[Pose, ...],
    unsure: Sequence[tuple[float, float]] | None = None,
) -> list[Violation]:
    """Robots that do not begin where the scenario says, but for what is `unsure`, m and rad."""
    result = []
    for robot, (track, start) in enumerate(zip(tracks, starts, strict=True)):
        away, turn = (0.0, 0.0) if unsure is None else unsure[robot]
        most = (_START[0] + away, _START[1] + turn)
        result += off_start(robot, track.time[0], track.pose[0], start, most)
    return result


def off_start(
    robot: int, time: float, pose: Array, start: Pose, most: tuple[float, float], heads: bool = True
) -> list[Violation]:
    """A robot that begins further from its start than `most`, m and rad.

    It does not matter how it is turned unless it `heads` anywhere.
    """
    x, y, yaw = pose - start
    distance, turn = np.hypot(x, y), np.abs(wrap_angle(yaw))
    if distance <= most[0] and (turn <= most[1] or not heads):
        return []
    text = f"robot {robot} begins {distance:.3f} m and {turn:.3f} rad from its start"
    return [broken("start", time, robot, text, distance, most[0])]
