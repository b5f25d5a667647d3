"""From values and what they may reach to violations: one per uninterrupted excess."""

from __future__ import annotations

import numpy as np

from cavalcade.checking.report import Kind, Violation
from cavalcade.geometry import Array


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
    return _stretches(kind, robot, time, value, limit, words, value - limit - slack)


def shortfalls(
    kind: Kind,
    robot: int,
    time: Array,
    value: Array,
    limit: Array | float,
    words: str,
    slack: Array | float = 0.0,
) -> list[Violation]:
    """Likewise where `value < limit - slack`."""
    return _stretches(kind, robot, time, value, limit, words, limit - value - slack)


def _stretches(
    kind: Kind,
    robot: int,
    time: Array,
    value: Array,
    limit: Array | float,
    words: str,
    excess: Array,
) -> list[Violation]:
    beyond = np.concatenate(([False], excess > 0.0, [False]))
    edges = np.flatnonzero(np.diff(beyond.astype(np.int8)))
    limits = np.broadcast_to(limit, value.shape)
    result = []
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        worst = begin + int(excess[begin:end].argmax())
        reached, wanted = float(value[worst]), float(limits[worst])
        text = f"robot {robot} {words.format(value=reached, limit=wanted)}"
        result.append(Violation(kind, float(time[begin]), (robot,), text, reached, wanted))
    return result
