"""The seam between a campaign and the processes that carry its trials out, and what these share.

Imports nothing that starts threads: their number is set here, before numpy and numba come in.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, Self

Fate = Literal["done", "overtime", "lost"]
"""`lost`: the process died, or could not give its result back."""

Work = Callable[..., Any]
"""A function of a module that workers can import; it must not raise."""


ONE_THREAD = (
    "NUMBA_NUM_THREADS",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
)
"""A trial is one core's work; the campaign has as many as it has cores."""


@dataclass(frozen=True)
class Ended:
    """A job that is over: what the work gave back if it is done, one line about it otherwise."""

    key: str
    fate: Fate
    value: Any = None
    detail: str = ""


class Engine(Protocol):
    """Carries jobs out in processes of their own. A context: leaving it ends every process.

    An engine keeps to each job's time limit and survives the death of its processes. It decides
    nothing: whether a lost job is tried again is the campaign's matter.
    """

    @property
    def room(self) -> int:
        """How many more jobs may be submitted now."""

    def submit(self, key: str, work: Work, arguments: tuple[Any, ...], limit: float) -> None:
        """Have `work(*arguments)` carried out; the arguments are picklable.

        `key` comes back with the result. `limit` is of wall clock from the job's start, s; beyond
        it the job is killed.
        """

    def collect(self, timeout: float) -> list[Ended]:
        """The jobs that ended since; waits for one for up to `timeout` s."""

    def __enter__(self) -> Self:
        """Start."""

    def __exit__(self, *error: object) -> None:
        """End every process at once, finished or not."""


def cores() -> int:
    """How many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


def use_one_thread() -> None:
    """Let numerical packages that are imported from now on use one thread."""
    os.environ |= dict.fromkeys(ONE_THREAD, "1")
