"""Messages of ROS 2 in their wire form (CDR, little endian), many at once.

A recording holds thousands of messages that differ in a few numbers only. A `Layout` describes one
message whose texts are fixed; `pack` then fills the numbers of all its instances by numpy. What
rosbags' own deserialiser makes of the bytes is what the tests compare with.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.geometry import Array

ENCAPSULATION = b"\x00\x01\x00\x00"
"""Encapsulation: plain CDR, little endian. Alignment counts from its end."""


class Layout:
    """The fixed shape of one kind of message, built up field by field in their order."""

    def __init__(self) -> None:
        self._template = bytearray(ENCAPSULATION)
        self._names: list[str] = []
        self._formats: list[Any] = []
        self._offsets: list[int] = []

    def numbers(self, name: str, kind: str, count: int = 1) -> Layout:
        """`count` numbers of the numpy type `kind` that `pack` will be given as `name`."""
        dtype = np.dtype(kind).newbyteorder("<")
        self._align(dtype.itemsize)
        self._names.append(name)
        self._formats.append(dtype if count == 1 else (dtype, (count,)))
        self._offsets.append(len(self._template))
        self._template += bytes(dtype.itemsize * count)
        return self

    def constant(self, kind: str, *values: float) -> Layout:
        """Numbers of the numpy type `kind` that are the same in every message."""
        data = np.array(values, dtype=np.dtype(kind).newbyteorder("<"))
        self._align(data.itemsize)
        self._template += data.tobytes()
        return self

    def text(self, value: str) -> Layout:
        """A string that is the same in every message."""
        data = value.encode() + b"\x00"
        self.constant("u4", len(data))
        self._template += data
        return self

    def header(self, frame: str, name: str = "stamp") -> Layout:
        """A std_msgs/Header; its time is given to `pack` as `name`, `(M, 2)` s and ns."""
        return self.numbers(name, "u4", 2).text(frame)

    def pack(self, count: int, **columns: ArrayLike) -> list[memoryview]:
        """`count` messages; every column has one row per message.

        Raises:
            KeyError: A column is missing.
        """
        size = len(self._template)
        data = np.frombuffer(bytes(self._template) * count, dtype=np.uint8).copy()
        rows = data.view(self._rows)
        for name in self._names:
            rows[name] = columns[name]
        view = memoryview(data.tobytes())
        return [view[k * size : (k + 1) * size] for k in range(count)]

    def unpack(self, messages: Sequence[bytes | memoryview]) -> dict[str, NDArray[Any]]:
        """The numbers of messages that `pack` made, one row per message in every column.

        Raises:
            ValueError: A message is of another kind.
        """
        size = len(self._template)
        if set(map(len, messages)) - {size}:
            raise ValueError(f"expected messages of {size} bytes")
        data = np.frombuffer(b"".join(messages), dtype=np.uint8).reshape(-1, size).copy()
        rows = data.reshape(-1).view(self._rows)
        columns = {name: rows[name].copy() for name in self._names}
        for name in self._names:
            rows[name] = 0
        if not np.array_equal(data, np.broadcast_to(np.array(self._template), data.shape)):
            raise ValueError("expected messages whose texts are the same")
        return columns

    @property
    def _rows(self) -> np.dtype[Any]:
        return np.dtype(
            {
                "names": self._names,
                "formats": self._formats,
                "offsets": self._offsets,
                "itemsize": len(self._template),
            }
        )

    def _align(self, size: int) -> None:
        self._template += bytes(-(len(self._template) - len(ENCAPSULATION)) % size)


def planar_poses(poses: Array) -> Array:
    """Poses `(..., 3)` x, y, yaw as `(..., 7)`: position x, y, z, orientation x, y, z, w."""
    result = np.zeros((*poses.shape[:-1], 7))
    result[..., :2] = poses[..., :2]
    result[..., 5] = np.sin(poses[..., 2] / 2.0)
    result[..., 6] = np.cos(poses[..., 2] / 2.0)
    return result


def nanoseconds(time: ArrayLike) -> NDArray[np.int64]:
    """Times in s as whole ns."""
    return np.round(np.asarray(time, dtype=float) * 1e9).astype(np.int64)


def stamps_of(nanoseconds: NDArray[np.int64]) -> NDArray[np.int64]:
    """`(M, 2)` seconds and nanoseconds of times `(M,)` in ns."""
    return np.column_stack(np.divmod(nanoseconds, 1_000_000_000))


def nanoseconds_of(stamps: NDArray[Any]) -> NDArray[np.int64]:
    """Times `(M,)` in ns of `(M, 2)` seconds and nanoseconds."""
    return np.asarray(stamps, dtype=np.int64) @ np.array([1_000_000_000, 1], dtype=np.int64)
