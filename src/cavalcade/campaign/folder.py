"""Folders that are made and taken away again, and locks on folders."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path

from cavalcade.errors import OutputError

LOCK = ".campaign.lock"


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
        remove_empty(made)
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from None
    return made


def remove_empty(made: Sequence[Path]) -> None:
    """Take folders away again as far as they are empty; `made` as `make_folders` gave it."""
    with contextlib.suppress(OSError):
        for folder in reversed(made):
            folder.rmdir()


def locked(folder: Path) -> int:
    """A handle that keeps other campaigns out of a folder for as long as it is open.

    Raises:
        OutputError: Another campaign has it.
        OSError: The folder cannot be written.
    """
    file = folder / LOCK
    while True:
        handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:  # not on every system
            return handle
        except OSError as error:
            os.close(handle)
            if isinstance(error, BlockingIOError):
                raise OutputError(f"{folder}: another campaign is at work in this folder") from None
            raise
        # Whoever had the lock takes the file away when done, perhaps after it was opened here.
        with contextlib.suppress(FileNotFoundError):
            if file.stat().st_ino == os.fstat(handle).st_ino:
                return handle
        os.close(handle)


def unlock(folder: Path) -> None:
    """Take the lock's file away; then close the handle."""
    with contextlib.suppress(OSError):
        (folder / LOCK).unlink()
