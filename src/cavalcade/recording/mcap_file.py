"""An MCAP file of ROS 2 messages that is whole whenever somebody looks.

Messages are gathered in a chunk in memory. `flush` puts the chunk into the file together with an
end of the file, in one write; the next chunk overwrites that end. So a process may be killed at
any moment, and what was flushed stands in a file that every reader of MCAP takes. Only `close`
adds the index of the chunks: its absence tells that whoever wrote the file did not get so far.

The format: https://mcap.dev/spec; what ROS 2 expects in it, as rosbag2 and rosbags write it.
"""

from __future__ import annotations

import json
import os
import struct
import sys
from binascii import crc32
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from cavalcade.mcap_framing import DATA_END, ENDING, FOOTER, MAGIC, record

if sys.version_info >= (3, 14):
    from compression import zstd
else:  # pragma: no cover
    from backports import zstd

_HEADER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 1, 3, 4, 5, 6
_MESSAGE_INDEX, _CHUNK_INDEX, _STATISTICS, _METADATA = 7, 8, 11, 12
_METADATA_INDEX, _SUMMARY_OFFSET = 13, 14

_NAME = "recording.mcap"
"""What the file is called in its own metadata, wherever it lies."""

_LARGEST_CHUNK = 2**20
"""Larger chunks should be flushed, bytes."""

_MESSAGE_HEAD = struct.Struct("<BQHIQQ")

_NEVER = 2**64 - 1

# Numbers stand for the policies, which all distributions of ROS 2 read if the version says so.
_VERSION = 8
_LATCHED = (
    "- avoid_ros_namespace_conventions: false\n"
    "  deadline: {nsec: 854775807, sec: 9223372036}\n"
    "  depth: 1\n  durability: 1\n  history: 1\n"
    "  lifespan: {nsec: 854775807, sec: 9223372036}\n"
    "  liveliness: 1\n"
    "  liveliness_lease_duration: {nsec: 854775807, sec: 9223372036}\n"
    "  reliability: 1"
)


@dataclass
class _Chunk:
    """What is gathered for the next flush."""

    data: bytearray = field(default_factory=bytearray)
    start: int = _NEVER
    end: int = 0
    places: dict[int, list[tuple[int, int]]] = field(default_factory=dict)


class McapFile:
    """Writes one file.

    Args:
        path: A new file; one that is there is replaced.
        topics: By topic, its type such as `std_msgs/msg/String`.
        latched: Topics whose last message is kept for late subscribers.

    Raises:
        OSError: It cannot be written.
    """

    def __init__(
        self, path: str | Path, topics: Mapping[str, str], latched: Collection[str] = ()
    ) -> None:
        self.path = Path(path)
        self._topics = dict(topics)
        self._latched = frozenset(latched)
        self._channels = {topic: number for number, topic in enumerate(topics, start=1)}
        self._counts = dict.fromkeys(self._channels.values(), 0)
        self._indices: list[bytes] = []
        self._span = (_NEVER, 0)
        self._schemas, self._hashes = _schemas_of(sorted(set(topics.values())))
        self._head = self._schema_records() + self._channel_records()
        self._chunk = _Chunk(bytearray(self._head))
        self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666)
        self._end = 0
        try:
            start = MAGIC + record(_HEADER, _text("ros2") + _text("cavalcade"))
            self._put(start)
        except OSError:
            os.close(self._file)
            raise

    @property
    def full(self) -> bool:
        """Whether so much has been gathered that it should be flushed."""
        return len(self._chunk.data) > _LARGEST_CHUNK

    def write(self, topic: str, time: int, data: bytes | memoryview) -> None:
        """Gather a message; `time` in ns, not before that of the message before."""
        chunk, channel = self._chunk, self._channels[topic]
        chunk.places.setdefault(channel, []).append((time, len(chunk.data)))
        chunk.start, chunk.end = min(chunk.start, time), max(chunk.end, time)
        chunk.data += _MESSAGE_HEAD.pack(_MESSAGE, 22 + len(data), channel, 0, time, time)
        chunk.data += data

    def flush(self) -> None:
        """Put what was gathered into the file, which is whole afterwards.

        Raises:
            OSError: It cannot be written; the file is as it was before, and what was gathered is
                lost.
        """
        chunk, self._chunk = self._chunk, _Chunk()
        if not chunk.places:
            self._chunk = chunk  # the topics wait for the first message
            return
        raw = bytes(chunk.data)
        packed = zstd.compress(raw)
        times = struct.pack("<QQ", chunk.start, chunk.end)
        sizes = struct.pack("<QQ", len(packed), len(raw))
        written = record(
            _CHUNK,
            times + struct.pack("<QI", len(raw), crc32(raw)) + _text("zstd") + sizes[:8] + packed,
        )
        length, offsets = len(written), b""
        for channel, places in chunk.places.items():
            offsets += struct.pack("<HQ", channel, self._end + len(written))
            entries = b"".join(struct.pack("<QQ", *place) for place in places)
            written += record(_MESSAGE_INDEX, struct.pack("<HI", channel, len(entries)) + entries)
        start = self._end
        try:
            self._put(written)
        except OSError:
            if not self._indices:
                self._chunk.data += self._head  # nobody knows the topics yet
            raise
        index = times + struct.pack("<QQI", start, length, len(offsets)) + offsets
        index += struct.pack("<Q", len(written) - length) + _text("zstd") + sizes
        self._indices.append(record(_CHUNK_INDEX, index))
        self._span = (min(self._span[0], chunk.start), max(self._span[1], chunk.end))
        for channel, places in chunk.places.items():
            self._counts[channel] += len(places)

    def close(self) -> None:
        """Flush, put the index at the end, and close the file; once.

        Raises:
            OSError: It cannot be written; the file is closed, and whole but for the index.
        """
        if self._file < 0:
            return
        try:
            if not self._indices and not self._chunk.places:
                # Nothing was said: readers shall find the topics nevertheless.
                self._put(self._head)
            self.flush()
            self._put(*self._summary())
        finally:
            os.close(self._file)
            self._file = -1

    def abandon(self) -> None:
        """Close the file as it is."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def _put(self, data: bytes, ending: bytes = ENDING) -> None:
        """Write over the file's end, with an end anew; all or nothing."""
        rest, place = memoryview(data + ending), self._end
        try:
            while rest:
                done = os.pwrite(self._file, rest, place)
                rest, place = rest[done:], place + done
        except OSError:
            os.ftruncate(self._file, self._end)
            if self._end:
                os.pwrite(self._file, ENDING, self._end)
            raise
        self._end += len(data)

    def _schema_records(self) -> bytes:
        return b"".join(
            record(
                _SCHEMA,
                struct.pack("<H", number) + _text(kind) + _text("ros2msg") + _text(text),
            )
            for number, (kind, text) in enumerate(self._schemas.items(), start=1)
        )

    def _channel_records(self) -> bytes:
        numbers = {kind: number for number, kind in enumerate(self._schemas, start=1)}
        found = b""
        for topic, channel in self._channels.items():
            qos = _text("offered_qos_profiles") + _text(self._qos(topic))
            said = struct.pack("<HH", channel, numbers[self._topics[topic]])
            said += _text(topic) + _text("cdr") + struct.pack("<I", len(qos)) + qos
            found += record(_CHANNEL, said)
        return found

    def _qos(self, topic: str) -> str:
        return _LATCHED if topic in self._latched else ""

    def _summary(self) -> tuple[bytes, bytes]:
        """The metadata, and everything that follows: the index and the end."""
        text = _text("serialized_metadata") + _text(self._metadata())
        metadata = record(_METADATA, _text("rosbag2") + struct.pack("<I", len(text)) + text)
        data = metadata + record(DATA_END, bytes(4))
        place = struct.pack("<QQ", self._end, len(metadata)) + _text("rosbag2")
        counts = b"".join(struct.pack("<HQ", *count) for count in sorted(self._counts.items()))
        total = sum(self._counts.values())
        numbers = (total, len(self._schemas), len(self._channels), 0, 1, len(self._indices))
        start, end = self._span
        statistics = struct.pack("<QHIIIIQQI", *numbers, start if total else 0, end, len(counts))
        groups = (
            (_SCHEMA, self._schema_records()),
            (_CHANNEL, self._channel_records()),
            (_CHUNK_INDEX, b"".join(self._indices)),
            (_METADATA_INDEX, record(_METADATA_INDEX, place)),
            (_STATISTICS, record(_STATISTICS, statistics + counts)),
        )
        begin = self._end + len(data)
        summary, offsets = b"", b""
        for kind, group in groups:
            if group:
                said = struct.pack("<BQQ", kind, begin + len(summary), len(group))
                offsets += record(_SUMMARY_OFFSET, said)
                summary += group
        footer = struct.pack("<QQI", begin, begin + len(summary), 0)
        return data, summary + offsets + record(FOOTER, footer) + MAGIC

    def _metadata(self) -> str:
        """What rosbag2 wants to know beforehand."""
        total = sum(self._counts.values())
        start, end = self._span if total else (0, 0)
        span = {
            "duration": {"nanoseconds": end - start},
            "starting_time": {"nanoseconds_since_epoch": start},
            "message_count": total,
        }
        said = {
            "version": _VERSION,
            "storage_identifier": "mcap",
            "relative_file_paths": [_NAME],
            **span,
            "topics_with_message_count": [
                {
                    "topic_metadata": {
                        "name": topic,
                        "type": self._topics[topic],
                        "serialization_format": "cdr",
                        "offered_qos_profiles": self._qos(topic),
                        "type_description_hash": self._hashes[self._topics[topic]],
                    },
                    "message_count": self._counts[channel],
                }
                for topic, channel in self._channels.items()
            ],
            "compression_format": "",
            "compression_mode": "",
            "files": [{"path": _NAME, **span}],
            "custom_data": None,
            "ros_distro": "rosbags",
        }
        # Copied by way of JSON: what is the same object twice would be said by reference.
        return str(yaml.safe_dump(json.loads(json.dumps(said)), width=10**6)).strip()


def _schemas_of(kinds: Collection[str]) -> tuple[dict[str, str], dict[str, str]]:
    """The definitions of types of messages, and their hashes."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    texts = {kind: store.generate_msgdef(kind, ros_version=2)[0] for kind in kinds}
    return texts, {kind: store.hash_rihs01(kind) for kind in kinds}


def _text(value: str) -> bytes:
    data = value.encode()
    return struct.pack("<I", len(data)) + data
