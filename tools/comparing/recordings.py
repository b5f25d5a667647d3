"""What two recordings differ in: message by message of every topic, times and payloads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from comparing.intended import Change, apply_changes

_NUMBERS = {
    "geometry_msgs/msg/PoseStamped": ("x", "y", "z", "qx", "qy", "qz", "qw"),
    "geometry_msgs/msg/TwistStamped": ("vx", "vy", "vz", "wx", "wy", "wz"),
}
"""The float64 numbers that a message ends with."""


@dataclass
class _Recording:
    topics: dict[str, str] = field(default_factory=dict)
    messages: dict[str, list[tuple[int, bytes]]] = field(default_factory=dict)
    order: list[tuple[int, str]] = field(default_factory=list)

    def rename(self, names: Mapping[str, str]) -> None:
        self.messages = {names[topic]: found for topic, found in self.messages.items()}
        self.order = [(time, names[topic]) for time, topic in self.order]


def recording_differences(
    name: str, old: Path, new: Path, changes: Sequence[Change]
) -> Iterator[tuple[str, str, str]]:
    """Key, old and new value: topics and their types, counts, the first other message of each."""
    if old.read_bytes() == new.read_bytes():
        return
    before, after = _read(old), _read(new)
    for messages in _texts(before):
        messages[:] = [(time, _reworded(name, data, changes)) for time, data in messages]
    names = list(before.topics)
    before.topics, after.topics = apply_changes(
        name, before.topics, after.topics, changes, flat=True
    )
    if len(names) == len(before.topics):
        before.rename(dict(zip(names, before.topics, strict=True)))
    equal = True
    topics = [*before.topics, *(topic for topic in after.topics if topic not in before.topics)]
    # Poses and commands first, since they say most about what went another way.
    for topic in sorted(topics, key=lambda topic: before.topics.get(topic) not in _NUMBERS):
        kinds = [side.topics.get(topic, "missing") for side in (before, after)]
        if kinds[0] != kinds[1]:
            equal = False
            yield topic, kinds[0], kinds[1]
            continue
        for place in _first(
            kinds[0], before.messages.get(topic, []), after.messages.get(topic, [])
        ):
            equal = False
            yield f"{topic} {place[0]}", place[1], place[2]
    if equal:
        sides = [[one for one in side.order if one[1] in side.topics] for side in (before, after)]
        for index, (one, other) in enumerate(zip(*sides, strict=True)):
            if one != other:
                yield f"order of messages, number {index}", str(one), str(other)
                return


def _texts(recording: _Recording) -> Iterator[list[tuple[int, bytes]]]:
    """The messages of each topic of texts."""
    for topic, kind in recording.topics.items():
        if kind == "std_msgs/msg/String":
            yield recording.messages.get(topic, [])


def _reworded(name: str, data: bytes, changes: Sequence[Change]) -> bytes:
    """A text in CDR - four bytes, its length, itself and a zero - as it would be said today."""
    said = data[8:].rstrip(b"\0").decode("utf-8")
    text, _ = apply_changes(name, said, "", changes)
    if text == said:
        return data
    body = text.encode("utf-8") + b"\0"
    return data[:4] + len(body).to_bytes(4, "little") + body


def _first(
    kind: str, old: list[tuple[int, bytes]], new: list[tuple[int, bytes]]
) -> Iterator[tuple[str, str, str]]:
    """The first message in which one topic differs, and the count if that differs."""
    if len(old) != len(new):
        yield "messages", str(len(old)), str(len(new))
    for index, (before, after) in enumerate(zip(old, new, strict=False)):
        if before == after:
            continue
        if before[0] != after[0]:
            yield f"message {index}: time in ns", str(before[0]), str(after[0])
            return
        place = f"message {index} at {before[0] / 1e9:.3f} s"
        yield (f"{place}: {(found := _payload(kind, before[1], after[1]))[0]}", *found[1:])
        return


def _payload(kind: str, old: bytes, new: bytes) -> tuple[str, str, str]:
    """Where two payloads differ first, with both values."""
    names = _NUMBERS.get(kind)
    if names is not None and len(old) == len(new) and len(old) >= 8 * len(names):
        ends = [data[-8 * len(names) :] for data in (old, new)]
        for k, name in enumerate(names):
            parts = [end[8 * k : 8 * k + 8] for end in ends]
            if parts[0] != parts[1]:
                values = [float(np.frombuffer(part, dtype="<f8")[0]) for part in parts]
                return name, repr(values[0]), repr(values[1])
    at = next(
        (k for k, (a, b) in enumerate(zip(old, new, strict=False)) if a != b),
        min(len(old), len(new)),
    )
    pieces = [data[max(at - 24, 0) : at + 24] for data in (old, new)]
    if kind == "std_msgs/msg/String":
        texts = [piece.decode("utf-8", "replace") for piece in pieces]
    else:
        texts = [piece[min(at, 24) :].hex() for piece in pieces]
    return f"byte {at} of {len(old)}", texts[0], texts[1]


def _read(file: Path) -> _Recording:
    from rosbags.rosbag2 import Reader

    found = _Recording()
    with Reader(file) as reader:
        for connection in reader.connections:
            found.topics[connection.topic] = connection.msgtype
        for connection, time, data in reader.messages():
            found.messages.setdefault(connection.topic, []).append((time, bytes(data)))
            found.order.append((time, connection.topic))
    return found
