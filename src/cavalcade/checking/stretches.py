"""From values and what they may reach to violations: one per uninterrupted excess."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.report import Kind, Violation
from cavalcade.geometry import Array


def stretches(beyond: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Begin and end (exclusive) of every stretch of `beyond` `(T,)` that holds."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], beyond.astype(np.int8), [0]))))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        yield int(begin), int(end)


def excesses(
    kind: Kind,
    robot: int,
    time: Array,
    value: Array,
    limit: Array | float,
    words: str,
    slack: Array | float = 0.0,
) -> list[Violation]:
    """One violation per stretch with `value > limit + slack`, at its first moment.

    Args:
        kind, robot: As in `Violation`.
        time: `(K,)` s, when each value holds.
        value: `(K,)` in SI units.
        limit: `(K,)` or one for all.
        words: What the robot does; `{value:.3f}` and `{limit:.3f}` are those of the worst moment.
        slack: `(K,)` or one for all.
    """
    return beyond_by(value - limit - slack, kind, robot, time, value, limit, words)


def beyond_by(
    excess: Array,
    kind: Kind,
    robot: int,
    time: Array,
    value: Array,
    limit: Array | float,
    words: str,
) -> list[Violation]:
    """Likewise where `excess` `(K,)` is positive; where it is largest is the worst moment."""
    limits = np.broadcast_to(limit, value.shape)
    result = []
    for begin, end in stretches(excess > 0.0):
        worst = begin + int(excess[begin:end].argmax())
        reached, wanted = float(value[worst]), float(limits[worst])
        text = f"robot {robot} {words.format(value=reached, limit=wanted)}"
        result.append(Violation(kind, float(time[begin]), (robot,), text, reached, wanted))
    return result
