"""Reading files that may be anything, and writing files that are whole or not there."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from cavalcade.errors import MapError, OutputError


def read_bytes(path: Path, limit: int) -> bytes:
    """Content of a regular file of at most `limit` bytes.

    Raises:
        MapError: It is missing, no regular file, larger, or cannot be read.
    """
    content = read_head(path, limit + 1)
    if len(content) > limit:
        raise MapError(f"is larger than the {limit} bytes expected at most", file=path)
    return content


def read_head(path: Path, count: int) -> bytes:
    """The first `count` bytes of a regular file, fewer if it has fewer.

    Raises:
        MapError: It is missing, no regular file, or cannot be read.
    """
    try:
        if not path.exists():
            raise MapError("no such file", file=path)
        if not path.is_file():
            raise MapError("not a regular file", file=path)
        with path.open("rb") as stream:
            return stream.read(count)
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise MapError(f"cannot be read: {_reason(error)}", file=path) from None


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file by way of a temporary one beside it.

    Raises:
        OutputError: It cannot be written; nothing half-written is left.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be written: {_reason(error)}") from None
    finally:
        with suppress(OSError, ValueError):
            temporary.unlink(missing_ok=True)


def _reason(error: OSError | ValueError) -> str:
    if isinstance(error, OSError) and error.strerror:
        return error.strerror.lower()
    return str(error)
