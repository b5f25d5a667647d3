"""The budget of one call: iterations, which decide, and wall time, which is a separate limit."""

from __future__ import annotations

import time

from cavalcade.errors import InputError


class Budget:
    """Counts what is spent.

    Args:
        iterations: Expansions of searches and trees in all.
        seconds: Of wall time; None for no limit.

    Raises:
        InputError: One of them is not positive.
    """

    def __init__(self, iterations: int, seconds: float | None = None) -> None:
        if iterations <= 0:
            raise InputError("expected at least 1", key="planner.budget.iterations")
        if seconds is not None and not seconds > 0.0:
            raise InputError("expected more than 0 s", key="planner.budget.seconds")
        self.iterations = iterations
        self.seconds = seconds
        self.used = 0
        self._begin = time.perf_counter()

    @property
    def elapsed(self) -> float:
        """Time since the call began, s."""
        return time.perf_counter() - self._begin

    @property
    def left(self) -> float | None:
        """Wall time that is left, s; None without a limit."""
        return None if self.seconds is None else max(self.seconds - self.elapsed, 0.0)

    @property
    def late(self) -> bool:
        """Whether the wall time is over."""
        return self.seconds is not None and self.elapsed >= self.seconds

    @property
    def spent(self) -> bool:
        """Whether nothing is left."""
        return self.used >= self.iterations or self.late

    def most(self, wanted: int) -> int:
        """As many expansions as are wanted and left, at least one."""
        return max(1, min(wanted, self.iterations - self.used))

    def share(self, part: float) -> Budget:
        """A budget of that part of what is left, which the caller notes as spent afterwards."""
        left = max(1, int(part * (self.iterations - self.used)))
        seconds = None if self.left is None else max(part * self.left, 1e-3)
        return Budget(left, seconds)

    def spend(self, iterations: int) -> None:
        """Note what was used."""
        self.used += iterations

    def __str__(self) -> str:
        if self.late:
            return f"{self.seconds:g} s are over"
        if self.used < self.iterations:
            return f"its searches ended after {self.used:,} iterations"
        return f"{self.used:,} of {self.iterations:,} iterations are used up"
