"""Which boxes may meet: the cheap first look that leaves few pairs for exact distances."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array

_LEAF = 16

Pairs = tuple[NDArray[np.int64], NDArray[np.int64]]


def overlapping(along: Array, others: Array, margin: float) -> Pairs:
    """Pairs of boxes closer than `margin` in x and in y, `(K,)` and `(K,)` indices.

    Args:
        along: `(T, 4)` boxes x0, y0, x1, y1 in m of which neighbours lie close together, as those
            of a path do: it is halved until few others are left.
        others: `(S, 4)` boxes in any order.
        margin: m.
    """
    grown = along + np.array([-margin, -margin, margin, margin])
    first: list[NDArray[np.int64]] = []
    second: list[NDArray[np.int64]] = []
    stack = [(0, len(grown), np.arange(len(others)))]
    while stack:
        begin, end, candidates = stack.pop()
        part = grown[begin:end]
        hull = np.concatenate((part[:, :2].min(axis=0), part[:, 2:].max(axis=0)))
        candidates = candidates[_meet(hull[None], others[candidates])[0]]
        if not len(candidates):
            continue
        if end - begin > _LEAF:
            middle = (begin + end) // 2
            stack += [(middle, end, candidates), (begin, middle, candidates)]
            continue
        one, two = np.nonzero(_meet(part, others[candidates]))
        first.append(begin + one)
        second.append(candidates[two])
    if not first:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    return np.concatenate(first), np.concatenate(second)


def _meet(one: Array, two: Array) -> NDArray[np.bool_]:
    """Whether boxes `(A, 4)` and `(B, 4)` overlap, `(A, B)`."""
    a, b = one[:, None], two[None]
    met: NDArray[np.bool_] = (
        (a[..., 0] <= b[..., 2])
        & (b[..., 0] <= a[..., 2])
        & (a[..., 1] <= b[..., 3])
        & (b[..., 1] <= a[..., 3])
    )
    return met
