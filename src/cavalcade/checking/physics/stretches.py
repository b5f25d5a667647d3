"""Uninterrupted stretches of samples beyond a limit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


def stretches(beyond: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Begin and end (exclusive) of every stretch of `beyond` `(T,)` that holds."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], beyond.astype(np.int8), [0]))))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        yield int(begin), int(end)
