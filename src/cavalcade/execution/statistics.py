"""How well a control loop keeps its pace: periods, planning times, ages of poses, misses."""

from __future__ import annotations

from collections import deque
from threading import Lock
from typing import Any

import numpy as np

_KEPT = 100_000
"""Cycles that percentiles are taken of, the last ones: more than an hour at 20 Hz."""

_Spread = dict[str, float] | None


class CycleStatistics:
    """Figures of the cycles so far; any thread may ask.

    Args:
        period: That the loop is to keep, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._lock = Lock()
        self._cycles = 0
        self._last: float | None = None
        self._periods: deque[float] = deque(maxlen=_KEPT)
        self._took: deque[float] = deque(maxlen=_KEPT)
        self._ages: deque[float] = deque(maxlen=_KEPT)

    def add(self, begin: float, took: float, age: float) -> None:
        """A cycle that began at `begin` s, and whose commands left `took` s later.

        `age` is that of the oldest pose that they were planned by, as they left, s.
        """
        with self._lock:
            if self._last is not None:
                self._periods.append(begin - self._last)
            self._last = begin
            self._cycles += 1
            self._took.append(took)
            self._ages.append(age)

    def to_dict(self, missed: int = 0) -> dict[str, Any]:
        """Plain data, ms: `cycles`, `missed`, `period_ms`, `jitter_ms`, `cycle_ms`, `pose_age_ms`.

        Jitter is how far periods were from what they should be. Null where there is nothing yet.
        """
        with self._lock:
            periods, took = np.array(self._periods), np.array(self._took)
            ages, cycles = np.array(self._ages), self._cycles
        return {
            "cycles": cycles,
            "missed": missed,
            "period_ms": _spread(periods),
            "jitter_ms": _spread(np.abs(periods - self._period)),
            "cycle_ms": _spread(took),
            "pose_age_ms": _spread(ages),
        }


def _spread(seconds: np.ndarray) -> _Spread:
    known = seconds[np.isfinite(seconds)]
    if not len(known):
        return None
    p50, p99 = np.percentile(known, (50.0, 99.0))
    figures = {"p50": p50, "p99": p99, "max": known.max()}
    return {name: round(1e3 * float(value), 3) for name, value in figures.items()}
