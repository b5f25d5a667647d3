"""Solid obstacles as prisms: what the replay needs to build them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array

_MOST_RECTANGLES = 3000


@dataclass(frozen=True)
class Prism:
    """An upright prism.

    Attributes:
        ring: `(K, 2)` its outline, counter-clockwise, not closed, map frame, m.
        triangles: `(K - 2, 3)` that fill the outline, indices of `ring`.
        low, high: Heights of its foot and its top, m.
    """

    ring: Array
    triangles: NDArray[np.int64]
    low: float
    high: float


def triangulate(ring: Array) -> NDArray[np.int64]:
    """Triangles `(K - 2, 3)` of a simple polygon `(K, 2)` given counter-clockwise.

    By cutting off ears; a polygon without any left, such as one that crosses itself, is fanned.
    """
    left = list(range(len(ring)))
    found: list[tuple[int, int, int]] = []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _is_ear(ring, left, a, b, c):
                found.append((a, b, c))
                del left[k]
                break
        else:
            found += [(left[0], left[k], left[k + 1]) for k in range(1, len(left) - 2)]
            left = [left[0], left[-2], left[-1]]
    found.append((left[0], left[1], left[2]))
    return np.array(found, dtype=np.int64)


def counter_clockwise(ring: Array) -> Array:
    """The same outline in the mathematical sense of turning."""
    x, y = ring.T
    twice = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    return ring if twice >= 0.0 else ring[::-1]


def rectangles(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int64], int]:
    """Rectangles `(K, 4)` first row, first column, last row + 1, last column + 1 of true cells.

    They cover them exactly, but for very ragged grids, whose cells are joined two by two, and
    again, until there are few enough.

    Returns:
        The rectangles in cells of the joined grid, and how many cells were joined per side.
    """
    factor = 1
    while True:
        found = _greedy(mask)
        if len(found) <= _MOST_RECTANGLES:
            return found, factor
        rows, cols = mask.shape
        padded = np.pad(mask, ((0, rows % 2), (0, cols % 2)))
        fours = padded.reshape(padded.shape[0] // 2, 2, padded.shape[1] // 2, 2)
        mask = np.asarray(fours.any(axis=(1, 3)))
        factor *= 2


def _greedy(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    left = mask.copy()
    found = []
    for row in range(mask.shape[0]):
        while left[row].any():
            first = int(np.argmax(left[row]))
            gap = np.flatnonzero(~left[row, first:])
            last = first + int(gap[0]) if len(gap) else mask.shape[1]
            end = row + 1
            while end < mask.shape[0] and left[end, first:last].all():
                end += 1
            left[row:end, first:last] = False
            found.append((row, first, end, last))
            if len(found) > 4 * _MOST_RECTANGLES:  # joined anyway
                return np.array(found, dtype=np.int64)
    return np.array(found, dtype=np.int64).reshape(-1, 4)


def _is_ear(ring: Array, left: list[int], a: int, b: int, c: int) -> bool:
    if _side(ring[a], ring[b], ring[c]) <= 0.0:
        return False
    for k in left:
        if k in (a, b, c):
            continue
        p = ring[k]
        if (
            _side(ring[a], ring[b], p) >= 0.0
            and _side(ring[b], ring[c], p) >= 0.0
            and _side(ring[c], ring[a], p) >= 0.0
        ):
            return False
    return True


def _side(a: Array, b: Array, p: Array) -> float:
    return float((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]))
