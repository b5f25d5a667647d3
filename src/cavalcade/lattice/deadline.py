"""A limit of wall time: it ends a search that would have gone on, and changes nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

_LOOK = 0.05
"""Time between two looks at the clock that is aimed at, s."""

_FIRST = 16
"""Steps of a kernel before the first look, while it is not known how long they take."""

_GROWTH = 4.0
"""From one look to the next at most so many times the steps."""


class Deadline:
    """The clock of one call, begun when it is made.

    Args:
        seconds: Of wall time; None for no limit.
        cancelled: Asked now and then whether the answer is still wanted.
    """

    def __init__(
        self, seconds: float | None = None, cancelled: Callable[[], bool] | None = None
    ) -> None:
        self.seconds = seconds
        self._cancelled = cancelled
        self._begin = perf_counter()

    @property
    def elapsed(self) -> float:
        """Time since the call began, s."""
        return perf_counter() - self._begin

    @property
    def left(self) -> float | None:
        """Time that is left, s; None without a limit."""
        return None if self.seconds is None else max(self.seconds - self.elapsed, 0.0)

    @property
    def late(self) -> bool:
        """Whether the time is over, or nobody wants the answer any more."""
        if self.cancelled:
            return True
        return self.seconds is not None and self.elapsed >= self.seconds

    @property
    def cancelled(self) -> bool:
        """Whether nobody wants the answer any more."""
        return self._cancelled is not None and self._cancelled()

    @contextmanager
    def paused(self) -> Iterator[None]:
        """While kernels are compiled: that is no time of the call."""
        before = perf_counter()
        try:
            yield
        finally:
            self._begin += perf_counter() - before

    def slices(self, begin: int, end: int) -> Iterator[int]:
        """Cut steps `begin` to `end` of a kernel into slices between looks at the clock.

        Yields:
            The step to go on to: `end` at once without a limit, nothing more once it is late.
            What a kernel that goes on where it stopped comes to does not depend on it.
        """
        if self.seconds is None:
            if begin < end:
                yield end
            return
        at, size = begin, float(_FIRST)
        while at < end:
            before = self.elapsed
            if before >= self.seconds:
                return
            at = min(end, at + max(1, int(size)))
            yield at
            taken = max(self.elapsed - before, 1e-9)
            size = max(1.0, size * min(_GROWTH, _LOOK / taken))
