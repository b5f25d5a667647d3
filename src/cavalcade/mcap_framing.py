"""How records follow each other in an MCAP file, and what of a file is whole that was cut off.

The format: https://mcap.dev/spec.
"""

from __future__ import annotations

import os
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from cavalcade.errors import RecordingError

MAGIC = b"\x89MCAP0\r\n"

FOOTER, DATA_END = 2, 15
"""Kinds of the records that end a file and its data."""

_HEADER, _LAST_KIND = 1, 15
_PREFIX = struct.Struct("<BQ")
"""Of every record: its kind and how many bytes follow."""


def record(kind: int, content: bytes) -> bytes:
    """A record."""
    return _PREFIX.pack(kind, len(content)) + content


ENDING = record(DATA_END, bytes(4)) + record(FOOTER, bytes(20)) + MAGIC
"""The end of a file that has no index."""


@contextmanager
def readable(path: Path) -> Iterator[tuple[Path, bool]]:
    """A file that readers of MCAP take, and whether its end is there.

    A recording whose writer was killed has no index; if it stopped in the midst of a record, its
    end is torn. Then the file given is a copy, for as long as the context lasts, of the records
    that are whole.

    Raises:
        RecordingError: It cannot be read, is no MCAP file, or no message in it is whole.
    """
    try:
        with path.open("rb") as stream:
            if _has_index(stream):
                yield path, True
                return
            end = _end_of_whole(stream, path)
            stream.seek(end)
            if stream.read(len(ENDING) + 1) == ENDING:
                yield path, False
                return
            with tempfile.TemporaryDirectory(prefix="cavalcade-") as folder:
                copy = Path(folder) / path.name
                stream.seek(0)
                copy.write_bytes(stream.read(end) + ENDING)
                yield copy, False
    except OSError as error:
        raise RecordingError(f"cannot be read: {error.strerror}", file=path) from error


def _has_index(stream: BinaryIO) -> bool:
    """Whether the file ends as it does when its writer has finished."""
    size = stream.seek(0, os.SEEK_END)
    footer = _PREFIX.size + 20 + len(MAGIC)
    if size < 2 * footer:
        return False
    stream.seek(size - footer)
    data = stream.read()
    kind, length, index = struct.unpack_from("<BQQ", data)
    return data.endswith(MAGIC) and (kind, length) == (FOOTER, 20) and index > 0


def _end_of_whole(stream: BinaryIO, path: Path) -> int:
    """Where the last whole record of the data ends."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    if stream.read(len(MAGIC)) != MAGIC:
        raise RecordingError("not a readable MCAP recording: it begins otherwise", file=path)
    end, kinds = len(MAGIC), []
    while True:
        stream.seek(end)
        prefix = stream.read(_PREFIX.size)
        if len(prefix) < _PREFIX.size:
            break
        kind, length = _PREFIX.unpack(prefix)
        after = end + _PREFIX.size + length
        if not 0 < kind < _LAST_KIND or kind == FOOTER or after > size:
            break
        end = after
        kinds.append(kind)
    if set(kinds) <= {_HEADER}:
        raise RecordingError("its end is missing, and nothing before it is whole", file=path)
    return end
