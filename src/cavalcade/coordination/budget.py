"""The budget of one call: iterations, which decide, and wall time, which is a separate limit."""

from __future__ import annotations

from cavalcade.errors import InputError
from cavalcade.lattice.deadline import Deadline


class Budget:
    """Counts what is spent.

    Args:
        iterations: Expansions of searches and trees in all.
        deadline: Of wall time; None for no limit.

    Raises:
        InputError: One of them is not positive.
    """

    def __init__(self, iterations: int, deadline: Deadline | None = None) -> None:
        self.deadline = deadline or Deadline()
        if iterations <= 0:
            raise InputError("expected at least 1", key="planner.budget.iterations")
        if self.deadline.seconds is not None and not self.deadline.seconds > 0.0:
            raise InputError("expected more than 0 s", key="planner.budget.seconds")
        self.iterations = iterations
        self.used = 0

    @property
    def spent(self) -> bool:
        """Whether nothing is left."""
        return self.used >= self.iterations or self.deadline.late

    def most(self, wanted: int) -> int:
        """As many expansions as are wanted and left, at least one."""
        return max(1, min(wanted, self.iterations - self.used))

    def share(self, part: float) -> Budget:
        """That part of the iterations that are left, which the caller notes as spent afterwards.

        The wall time is not shared out: how much of it a part may take would change the answer.
        """
        return Budget(max(1, int(part * (self.iterations - self.used))), self.deadline)

    def spend(self, iterations: int) -> None:
        """Note what was used."""
        self.used += iterations

    def __str__(self) -> str:
        if self.deadline.cancelled:
            return "it was cancelled"
        if self.deadline.late:
            return f"{self.deadline.seconds:g} s are over"
        if self.used < self.iterations:
            return f"its searches ended after {self.used:,} iterations"
        return f"{self.used:,} of {self.iterations:,} iterations are used up"
