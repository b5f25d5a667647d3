"""Reading files that may be anything; writing files and making folders, whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from cavalcade.errors import InputError, MapError, OutputError


def read_bytes(path: Path, limit: int, kind: type[InputError] = MapError) -> bytes:
    """Content of a regular file of at most `limit` bytes.

    Raises:
        InputError: It is missing, no regular file, larger, or cannot be read; of that `kind`.
    """
    content = read_head(path, limit + 1, kind)
    if len(content) > limit:
        raise kind(f"is larger than the {limit} bytes expected at most", file=path)
    return content


def read_head(path: Path, count: int, kind: type[InputError] = MapError) -> bytes:
    """The first `count` bytes of a regular file, fewer if it has fewer.

    Raises:
        InputError: It is missing, no regular file, or cannot be read; of that `kind`.
    """
    try:
        if not path.exists():
            raise kind("no such file", file=path)
        if not path.is_file():
            raise kind("not a regular file", file=path)
        with path.open("rb") as stream:
            return stream.read(count)
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise kind(f"cannot be read: {reason_of(error)}", file=path) from None


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A new file beside `path`, to be written, that takes its place when the block ends well.

    Raises:
        OutputError: It cannot be written; nothing half-written is left, and what was there stays.
    """
    path = Path(path)
    if "\0" in str(path):
        raise OutputError("cannot be written: the name holds a null byte", file=path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(f"cannot be written: {reason_of(error)}", file=path) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def write_file(path: str | Path, content: bytes | str, durable: bool = False) -> None:
    """Write a file, whole or not at all; text in UTF-8 as it stands.

    `durable`: it must survive a failure of power from the moment that this returns.

    Raises:
        OutputError: It cannot be written; nothing half-written is left, and what was there stays.
    """
    data = content.encode() if isinstance(content, str) else content
    with replacing(path) as temporary, temporary.open("wb") as stream:
        stream.write(data)
        if durable:
            stream.flush()
            os.fsync(stream.fileno())


def make_folders(folder: Path) -> list[Path]:
    """Make a folder; gives those that were not there, outermost first.

    Raises:
        OutputError: It cannot be made, or is a file.
    """
    made = []
    try:
        for one in reversed([folder, *folder.parents]):
            if not one.exists():
                one.mkdir()
                made.append(one)
        if not folder.is_dir():
            raise OutputError(f"{folder}: expected a folder, this is a file")
    except OSError as error:
        remove_folders(made)
        raise OutputError(f"{folder}: cannot be written: {reason_of(error)}") from None
    return made


def remove_folders(made: Sequence[Path]) -> None:
    """Take folders away again as far as they are empty; `made` as `make_folders` gave it."""
    with suppress(OSError):  # someone else may have put something in one by now
        for folder in reversed(made):
            folder.rmdir()


def reason_of(error: OSError | ValueError) -> str:
    """What went wrong, in a few words."""
    return (isinstance(error, OSError) and error.strerror) or str(error)
