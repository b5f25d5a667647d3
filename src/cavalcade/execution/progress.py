"""Where a run stands, for whoever wants to watch it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Progress:
    """Where a run stands.

    Attributes:
        time: Simulated time, s.
        timeout: When it will be given up, s.
        state: The planner's.
        note: What just happened, empty mostly.
    """

    time: float
    timeout: float
    state: str
    note: str = ""


class ProgressSink(Protocol):
    """Anything that is called once per cycle; a function will do."""

    def __call__(self, progress: Progress, /) -> None:
        """Take note."""
