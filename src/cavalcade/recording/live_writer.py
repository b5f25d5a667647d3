"""A recording that is written while the run goes on, for robots that nobody can run again."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from cavalcade.errors import OutputError
from cavalcade.files import reason_of
from cavalcade.geometry import Array
from cavalcade.recording import _messages
from cavalcade.recording.cdr import nanoseconds
from cavalcade.recording.cycle_messages import CycleMessages, Message, opening, text_message
from cavalcade.recording.frames import Frame, FrameThinner, maps_of, recording_of
from cavalcade.recording.mcap_file import McapFile
from cavalcade.robots import RobotModel
from cavalcade.values import path_of
from cavalcade.world import OccupancyMap

PERIOD = 0.5
"""What happened is in the file after so long, s of the wall's time."""

_MOST = 600
"""Frames that wait for the writer; those that come when so many do are left out."""

_STEP = 0.05
"""Of the recording's clock where that of the robots stood still or went back, s."""

_PATIENCE = 10.0
"""The writer is waited for so long at the end, s."""


@dataclass(frozen=True)
class _Note:
    text: str


class LiveRecording:
    """A sink of frames that appends them to a recording, at once and beside the control cycle.

    The file is one that all readers of MCAP take, after each half second: if the process dies,
    what happened until then is there, and `read_recording` and `cavalcade check` say that the end
    is missing. Topics and messages are those of `write_recording`. Calls never wait for the disk.
    If that is full, what happens meanwhile is missing, with a note as soon as there is room again;
    nothing is raised, `problem` tells. Clocks that stand still or go back do so in a note only:
    the recording's own goes on. Frames of robots whose pose is not known yet are left out.

    Args:
        path: The new file; one that is there is replaced.
        models: One per robot, in the order of the poses.
        names: What the robots are called; a note says so. In topics they are `robot_0` and so on.
        maps: (time in s, map) at the start; frames bring those that follow.

    Raises:
        OutputError: It cannot be written.
    """

    def __init__(
        self,
        path: str | Path,
        models: Sequence[RobotModel],
        names: Sequence[str] | None = None,
        maps: Iterable[tuple[float, OccupancyMap]] = (),
    ) -> None:
        self.path = path_of(path)
        count = len(models)
        try:
            self._file = McapFile(
                self.path, _messages.topics_of(count, 0, count), _messages.latched(count)
            )
        except OSError as error:
            raise OutputError(f"cannot be written: {reason_of(error)}", file=self.path) from None
        self._count = count
        self._models = tuple(models)
        self._maps = list(maps)
        self._names = tuple(names) if names is not None else ()
        self._messages = CycleMessages(models)
        self._thin = FrameThinner()
        self._waiting: queue.Queue[Frame | _Note] = queue.Queue(_MOST)
        self._closing = threading.Event()
        self._left_out = 0
        self._problem = ""
        self._known: Array = np.full((count, 3), np.nan)
        self._time: float | None = None
        self._shift = 0.0
        self._written = 0
        self._opened = False
        self._thread = threading.Thread(
            # What is in the file is whole without it: it may die with the process.
            target=self._run,
            name="cavalcade-recording",
            daemon=True,
        )
        self._thread.start()

    @property
    def problem(self) -> str:
        """What is wrong with the recording now, such as a full disk; empty if nothing is."""
        if not self._problem and self._left_out:
            return f"{self.path}: the disk is too slow, cycles or notes are missing"
        return self._problem

    def __call__(self, frame: Frame) -> None:
        """Append one cycle; returns at once."""
        self._append(frame)

    def note(self, text: str) -> None:
        """Append what just happened, one line, at the time of the last cycle; returns at once."""
        self._append(_Note(text))

    def close(self) -> None:
        """Write what is waiting and the file's end. What cannot be written is in `problem`."""
        self._closing.set()
        self._thread.join(_PATIENCE)
        if self._thread.is_alive():
            self._problem = "the disk is too slow: the end of the recording is missing"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _append(self, item: Frame | _Note) -> None:
        if self._closing.is_set():
            return
        try:
            self._waiting.put_nowait(item)
        except queue.Full:
            self._left_out += 1

    def _run(self) -> None:
        """The writer's thread."""
        try:
            while True:
                closing = self._closing.wait(PERIOD)
                self._write(self._taken())
                if closing:
                    self._file.close()
                    return
        except Exception as error:
            # A recording must never stop robots; everything that follows is left out.
            reason = reason_of(error) if isinstance(error, OSError) else repr(error)
            self._problem = f"{self.path}: the recording ended: {reason}"
            self._closing.set()
            self._file.abandon()

    def _taken(self) -> list[Frame | _Note]:
        """Everything that waits now."""
        return [self._waiting.get_nowait() for _ in range(self._waiting.qsize())]

    def _write(self, items: list[Frame | _Note]) -> None:
        frames: list[Frame] = []
        texts: list[str] = []
        for item in items:
            if isinstance(item, _Note):
                texts.append(item.text)
                continue
            texts += item.notes
            frame = self._usable(item, texts)
            if frame is not None:
                frames.append(replace(self._thin(frame), notes=tuple(texts)))
                texts = []
        if left_out := self._left_out:
            self._left_out -= left_out
            texts.append(f"recording: {left_out} cycles or notes are missing, the disk is too slow")
        if not frames and not texts:
            return
        found = self._messages(recording_of(frames), maps_of(frames))
        last = self._time or 0.0
        found += [_note_message(last, text) for text in texts]
        self._put(found)

    def _put(self, found: list[Message]) -> None:
        """Write messages of one piece, all or none."""
        if not self._opened:
            found += self._opening(min(found, key=itemgetter(0))[0] / 1e9)
        found.sort(key=itemgetter(0, 1))
        if self._problem:
            text = f"recording: what happened before is missing ({self._problem})"
            found.insert(0, _note_message(found[0][0] / 1e9, text))
        for time, _, topic, data in found:
            # Readers without an index want messages in order.
            self._written = max(self._written, time)
            self._file.write(topic, self._written, data)
        try:
            self._file.flush()
        except OSError as error:
            self._problem = f"{self.path}: cannot be written: {reason_of(error)}"
            self._messages.forget()
        else:
            self._opened, self._problem = True, ""

    def _opening(self, start: float) -> list[Message]:
        """What stands at the beginning."""
        found = list(opening(self._models, start))
        for time, grid in self._maps:
            stamp = int(nanoseconds(max(time, 0.0)))
            found.append((stamp, 0, "/map", _messages.grid_message(stamp, grid)))
        if self._names:
            said = ", ".join(f"robot {k} is {name}" for k, name in enumerate(self._names))
            found.append(_note_message(start, f"recording: {said}"))
        return found

    def _usable(self, frame: Frame, texts: list[str]) -> Frame | None:
        """The frame on the recording's clock with poses that are known, if all are."""
        poses = np.asarray(frame.poses, dtype=float)
        if poses.shape != self._known.shape or not np.isfinite(frame.time):
            return None
        sound = np.isfinite(poses).all(axis=1)
        self._known = np.where(sound[:, None], poses, self._known)
        if not np.isfinite(self._known).all():
            return None
        commands = np.nan_to_num(np.asarray(frame.commands, dtype=float), posinf=0.0, neginf=0.0)
        time = frame.time + self._shift
        before = -_STEP if self._time is None else self._time
        if time <= before:
            self._shift += before + _STEP - time
            time = before + _STEP
            texts.append(
                f"recording: the clock stood still or went back to {frame.time:.3f} s; "
                f"recorded times are {self._shift:.3f} s later from here on"
            )
        self._time = time
        return replace(frame, time=time, poses=self._known, commands=commands)


def _note_message(time: float, text: str) -> Message:
    return text_message(time, 2, _messages.NOTES_TOPIC, {"time": time, "text": text})
