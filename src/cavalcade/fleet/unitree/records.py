"""The two records that a fleet and a robot's helper process share; neither ever waits.

Each has one writer and holds its newest content alone. A reader that comes in the midst of
writing sees it by the checksum and looks again.
"""

from __future__ import annotations

import mmap
import os
import struct
import weakref
import zlib
from enum import IntEnum
from typing import Any, Generic, NamedTuple, TypeVar, get_type_hints

_SUM = struct.Struct("<I")
_RECORD = 128
"""Bytes set aside for each record."""

_LOOKS = 100
"""How often a record that is being written is looked at again; writing takes a microsecond."""


class Wish(IntEnum):
    """What a robot is to do."""

    WAIT = 0  # nothing: it is left alone
    STAND = 1  # stand up, ready to walk
    MOVE = 2  # walk as commanded
    DAMP = 3  # motors damped, whatever happens
    LEAVE = 4  # stop, and end the helper
    LIE = 5  # stop, lie down, and end the helper


class Stage(IntEnum):
    """How far a helper is with a robot."""

    LISTENING = 0
    RISING = 1
    READY = 2
    FAILED = 3  # a request was refused: see `failed_api`


class Order(NamedTuple):
    """What the fleet wants.

    Attributes:
        beat: When it was written, s of the monotonic clock; after 0.5 s the robot is stopped.
        wish: A `Wish`.
        number: Counts wishes: the same one again is done again.
        x, y, turn: Body-frame velocity, m/s and rad/s.
    """

    beat: float
    wish: int
    number: int
    x: float
    y: float
    turn: float


class Report(NamedTuple):
    """What is known of the robot.

    Attributes:
        beat: When it was written, s of the monotonic clock.
        number: Of the wish that `stage` is about.
        stage: A `Stage`.
        heard: When the last sport state came, s of the monotonic clock; 0 if none did.
        x, y, yaw: Its odometry, m and rad.
        roll, pitch: rad.
        mode, error_code: As in the sport state.
        charge: Of the battery, %; -1 if it was not heard.
        failed_api, failed_code: The request that failed last and was not answered well since, and
            its code; 0 if there is none.
        rival: When another program last told it to move, s of the monotonic clock; 0 if none did.
    """

    beat: float
    number: int
    stage: int
    heard: float
    x: float
    y: float
    yaw: float
    roll: float
    pitch: float
    mode: int
    error_code: int
    charge: float
    failed_api: int
    failed_code: int
    rival: float


_T = TypeVar("_T", Order, Report)


class Slot(Generic[_T]):
    """One record in memory shared by two processes; give each process its own."""

    def __init__(self, memory: mmap.mmap, offset: int, kind: type[_T]) -> None:
        self._memory = memory
        self._offset = offset
        self._kind: Any = kind
        types = get_type_hints(kind)
        self._struct = struct.Struct(
            "<" + "".join("q" if types[name] is int else "d" for name in kind._fields)
        )

    def write(self, record: _T) -> None:
        """Put a record in the place of the last one."""
        content = self._struct.pack(*record)
        start = self._offset
        self._memory[start : start + len(content) + 4] = content + _SUM.pack(zlib.crc32(content))

    def read(self) -> _T | None:
        """The newest record; None if there is none, or its writer died while writing."""
        size = self._struct.size
        for _ in range(_LOOKS):
            seen = self._memory[self._offset : self._offset + size + 4]
            content = seen[:size]
            if _SUM.unpack(seen[size:])[0] == zlib.crc32(content):
                return self._kind(*self._struct.unpack(content))
        return None


class SharedRecords:
    """Both records.

    Attributes:
        file: Descriptor of the memory, to hand on to the helper.
    """

    def __init__(self, file: int | None = None) -> None:
        if file is None:
            file = os.memfd_create("cavalcade-go2")
            weakref.finalize(self, os.close, file)  # it may be read until nobody knows it any more
            os.ftruncate(file, 2 * _RECORD)
        self.file = file
        memory = mmap.mmap(file, 2 * _RECORD)
        self.order: Slot[Order] = Slot(memory, 0, Order)
        self.report: Slot[Report] = Slot(memory, _RECORD, Report)
