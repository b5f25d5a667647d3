"""The campaign's folder: one line per finished trial, and nothing finished is ever lost."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Self

from cavalcade.campaign.definition import FILE, Definition, difference, read_definition_file
from cavalcade.campaign.table import LINES
from cavalcade.campaign.trial import Line, failure_line
from cavalcade.errors import OutputError
from cavalcade.files import make_folders, remove_folders, write_file

CORRUPT, LOCK = "trials.corrupt.jsonl", ".campaign.lock"
_OF_THE_DEFINITION = ("trial", "suite", "scenario", "variant", "disturbance", "seed")


class Store:
    """A campaign's folder, locked against other campaigns while it is open.

    Use it as a context.

    Attributes:
        done: The IDs of the trials that have their line.

    Args:
        folder: Missing or empty, or with this very campaign in it if `resume`.
        definition: Of the campaign.
        resume: Go on with what is there.
        warn: Told, one line each, of damaged lines that were taken out.

    Raises:
        OutputError: The folder holds something else, another campaign is at work in it, or it
            cannot be written.
        RecordingError: Its `campaign.json` cannot be read.
    """

    def __init__(
        self,
        folder: str | Path,
        definition: Definition,
        *,
        resume: bool = False,
        warn: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.folder = Path(folder)
        self._trials = definition.trials
        self._order = {trial.id: place for place, trial in enumerate(definition.trials)}
        self.done: set[str] = set()
        self._lock = -1
        self._file = -1
        self._size = 0
        made = make_folders(self.folder)
        try:
            if not resume or not (self.folder / FILE).exists():
                _check_empty(self.folder, resume)
            self._lock = locked(self.folder)
            if (self.folder / FILE).exists():
                if not resume:  # begun by another process this very moment
                    raise OutputError(f"{self.folder}: holds a campaign; use --resume to go on")
                other = difference(definition, read_definition_file(self.folder))
                if other is not None:
                    raise OutputError(f"{self.folder}: {other}; name another folder")
            else:
                text = json.dumps(definition.to_dict(), indent=2, ensure_ascii=False) + "\n"
                write_file(self.folder / FILE, _encoded(text), durable=True)
            self._mend(warn)
            flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
            self._file = os.open(self.folder / LINES, flags, 0o644)
            self._size = os.fstat(self._file).st_size
        except BaseException as error:
            self.__exit__()
            remove_folders(made)
            if isinstance(error, OSError):
                raise self._failed(error) from None
            raise

    def count(self) -> int:
        """How many lines there are on the disk; after Ctrl-C in `append` it may be one more."""
        with (self.folder / LINES).open("rb") as stream:
            return sum(raw.endswith(b"\n") for raw in stream)

    def append(self, line: Mapping[str, Any]) -> None:
        """Keep one line: afterwards it is on the disk, whole.

        Raises:
            OutputError: It is not, and nothing of it is; all lines before are.
        """
        text = json.dumps(line, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        data = _encoded(text) + b"\n"
        try:
            written = 0
            while written < len(data):
                # One call but for a disk that is full, which takes what still fits.
                written += os.write(self._file, data[written:])
            os.fsync(self._file)
        except OSError as error:
            # Leave nothing of it. Where this fails too, the torn line is mended when the campaign
            # goes on.
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._size)
            raise self._failed(error) from None
        self._size += len(data)
        self.done.add(str(line["trial"]))

    def lines(self) -> list[Line]:
        """All lines in the order of the trials, whatever order they were finished in."""
        try:
            with (self.folder / LINES).open("rb") as stream:
                lines = [json.loads(raw) for raw in stream]
        except OSError as error:
            raise self._failed(error, "read") from None
        return sorted(lines, key=lambda line: self._order[line["trial"]])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        """Unlock the folder."""
        if self._lock >= 0:
            with contextlib.suppress(OSError):
                (self.folder / LOCK).unlink()  # before its handle is closed
        for handle in (self._file, self._lock):
            if handle >= 0:
                os.close(handle)
        self._file = self._lock = -1

    def _mend(self, warn: Callable[[str], None]) -> None:
        """Read what is there; take out what is no line of this campaign."""
        file = self.folder / LINES
        if not file.exists():
            return
        kept: list[bytes] = []
        corrupt: list[bytes] = []
        warnings: list[str] = []
        with file.open("rb") as stream:
            for number, raw in enumerate(stream, 1):
                trial = self._trial_of(raw)
                if trial is not None and trial not in self.done:
                    self.done.add(trial)
                    kept.append(raw)
                    continue
                fault = f"not a trial of this campaign; moved to {CORRUPT}, its trial is repeated"
                if trial is not None:
                    fault = f"{trial} stands there twice"
                elif not raw.endswith(b"\n"):
                    fault = "torn; its trial is repeated"
                if raw.endswith(b"\n"):
                    corrupt.append(raw)
                warnings.append(f"{file}: line {number}: {fault}")
        if not warnings:
            return
        if corrupt:
            with (self.folder / CORRUPT).open("ab") as stream:
                stream.writelines(corrupt)
                stream.flush()
                os.fsync(stream.fileno())
        write_file(file, b"".join(kept), durable=True)
        for text in warnings:
            warn(text)

    def _trial_of(self, raw: bytes) -> str | None:
        """The trial whose whole line this is, if it is one of this campaign."""
        if not raw.endswith(b"\n"):
            return None
        try:
            line = json.loads(raw, parse_constant=_refuse)
        except (ValueError, RecursionError):
            return None
        trial = line.get("trial") if isinstance(line, dict) else None
        if not isinstance(trial, str) or trial not in self._order:
            return None
        # The report takes every line for whole.
        model = failure_line(self._trials[self._order[trial]], "", "")
        whole = all(
            key in line and (type(line[key]) is type(value) or key in ("level", "level_name"))
            for key, value in model.items()
        )
        same = whole and all(line[key] == model[key] for key in _OF_THE_DEFINITION)
        return trial if same else None

    def _failed(self, error: OSError, what: str = "written") -> OutputError:
        place = Path(error.filename) if error.filename else self.folder / LINES
        text = f"{place}: cannot be {what}: {error.strerror or error}"
        if self.done:
            text += f"; the {len(self.done)} trials so far are kept, go on with --resume"
        return OutputError(text)


def _encoded(text: str) -> bytes:
    # What a file's name has that is no text becomes what JSON reads as the same again.
    return text.encode(errors="backslashreplace")


def _refuse(constant: str) -> Any:
    raise ValueError(f"{constant} is no JSON")


def _check_empty(folder: Path, resume: bool) -> None:
    if (folder / FILE).exists():
        raise OutputError(f"{folder}: holds a campaign; use --resume to go on with it")
    if any(not entry.name.startswith(".") for entry in folder.iterdir()):
        what = "holds no campaign to go on with" if resume else "the folder is not empty"
        raise OutputError(f"{folder}: {what}; name another one")


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
