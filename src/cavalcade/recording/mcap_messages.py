"""The messages of an MCAP file, all at once.

A walk through the records in their order: long recordings hold a million messages, of which an
iterator that sorts them one by one would take several times as long.

The format: https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import sys
from binascii import crc32
from collections.abc import Callable, Container
from dataclasses import dataclass, field
from pathlib import Path

from cavalcade.errors import RecordingError
from cavalcade.mcap_framing import MAGIC

if sys.version_info >= (3, 14):
    from compression import zstd
else:  # pragma: no cover
    from backports import zstd

_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 3, 4, 5, 6, 15
_PREFIX = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQII")
_HEAD = struct.Struct("<BQHIQ")
_BEFORE_DATA = 31
"""Bytes of a message's record before its data."""


@dataclass
class Messages:
    """The messages of a topic, in order of time.

    Attributes:
        times: ns.
        data: As they stand on the wire.
    """

    times: list[int] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.times)

    def cut(self, count: int) -> None:
        """Leave out all but the first ones."""
        del self.times[count:], self.data[count:]

    def sort(self) -> None:
        """Put them in order of time."""
        if self.times != sorted(self.times):
            order = sorted(range(len(self.times)), key=self.times.__getitem__)
            self.times = [self.times[k] for k in order]
            self.data = [self.data[k] for k in order]


def read_messages(file: Path, unwanted: Container[str] = ()) -> dict[tuple[str, str], Messages]:
    """The messages of a file by topic and type, such as `std_msgs/msg/String`.

    Args:
        file: Whole, see `mcap_framing.readable`.
        unwanted: Topics that are left out.

    Raises:
        RecordingError: It is damaged; the file is left to the caller to name.
    """
    found = _Walk(unwanted)
    try:
        with file.open("rb") as stream:
            stream.seek(len(MAGIC))
            while True:
                kind, length = _PREFIX.unpack(stream.read(_PREFIX.size))
                if kind == _DATA_END:
                    break
                if kind == _CHUNK:
                    found.walk(_unpacked(stream.read(length)))
                elif kind in (_SCHEMA, _CHANNEL, _MESSAGE):
                    found.walk(_PREFIX.pack(kind, length) + stream.read(length))
                else:
                    stream.seek(length, 1)
    except RecordingError:
        raise
    except Exception as error:  # each library of compression has errors of its own
        raise RecordingError(f"cannot be read: {error}") from None
    for messages in found.messages.values():
        messages.sort()
    return found.messages


class _Walk:
    """What the records so far have told."""

    def __init__(self, unwanted: Container[str]) -> None:
        self.messages: dict[tuple[str, str], Messages] = {}
        self._unwanted = unwanted
        self._types: dict[int, str] = {}
        self._channels: dict[int, Messages | None] = {}

    def walk(self, data: bytes) -> None:
        """Note all records in `data`."""
        place, end, channels = 0, len(data), self._channels
        while place < end:
            kind, length, channel, _, time = _HEAD.unpack_from(data, place)
            after = place + _PREFIX.size + length
            if after > end:
                raise ValueError("a record is longer than its chunk")
            if kind == _MESSAGE:
                messages = channels[channel]
                if messages is not None:
                    messages.times.append(time)
                    messages.data.append(data[place + _BEFORE_DATA : after])
            elif kind == _SCHEMA:
                self._types[channel] = _text(data, place + 11)
            elif kind == _CHANNEL and channel not in channels:
                (schema,) = struct.unpack_from("<H", data, place + 11)
                topic = _text(data, place + 13)
                wanted = topic not in self._unwanted
                key = (topic, self._types[schema])
                channels[channel] = self.messages.setdefault(key, Messages()) if wanted else None
            place = after


def _text(data: bytes, place: int) -> str:
    (length,) = struct.unpack_from("<I", data, place)
    return data[place + 4 : place + 4 + length].decode()


def _unpacked(chunk: bytes) -> bytes:
    """The records in a chunk."""
    _, _, size, check, length = _CHUNK_HEAD.unpack_from(chunk)
    start = _CHUNK_HEAD.size + length
    name = chunk[_CHUNK_HEAD.size : start].decode()
    if name not in _UNPACK:
        raise RecordingError(f"compressed by {name!r}", choices=tuple(_UNPACK))
    data = _UNPACK[name](chunk[start + 8 :])
    if len(data) != size or check not in (0, crc32(data)):  # 0: nobody has reckoned it
        raise ValueError("a chunk is damaged")
    return data


def _lz4(data: bytes) -> bytes:
    import lz4.frame

    unpacked: bytes = lz4.frame.decompress(data)
    return unpacked


_UNPACK: dict[str, Callable[[bytes], bytes]] = {"": bytes, "lz4": _lz4, "zstd": zstd.decompress}
"""How chunks are unpacked that were compressed by a method."""
