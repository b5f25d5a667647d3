"""Numbers small: whole units as text, arrays as base 64."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array


def packed(values: NDArray) -> str:
    """The array's bytes as base 64."""
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def whole(values: Array, unit: float) -> list[int]:
    """All values, flat, as whole numbers of `1 / unit`."""
    return [int(value) for value in np.rint(np.asarray(values, dtype=float).ravel() * unit)]


def steps(values: Array, unit: float) -> list[int]:
    """The first value or row, then the differences, flat, as whole numbers of `1 / unit`."""
    rounded = np.rint(np.asarray(values, dtype=float) * unit).astype(np.int64)
    start = np.zeros((1, *rounded.shape[1:]), dtype=np.int64)
    return [int(value) for value in np.diff(rounded, axis=0, prepend=start).ravel()]


def ranged(values: Array) -> dict[str, Any]:
    """A column of numbers in 65535 steps between its lowest and its highest."""
    column = np.asarray(values, dtype=float).ravel()
    low = float(column.min(initial=np.inf)) if column.size else 0.0
    step = float(np.ptp(column)) / 65_535 if column.size else 0.0
    scaled = (column - low) / step if step > 0.0 else np.zeros_like(column)
    return {"low": low, "step": step, "data": packed(np.rint(scaled).astype("<u2"))}


def rounded(values: Any, digits: int) -> list[float]:
    """The values as numbers of so many digits behind the point."""
    return [round(float(value), digits) for value in values]
