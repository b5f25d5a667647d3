"""The seam between a campaign and the processes that carry its trials out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, Self

Fate = Literal["done", "overtime", "lost"]
"""`lost`: the process died, or could not give its result back."""

Work = Callable[..., Any]
"""A function of a module that workers can import; it must not raise."""


@dataclass(frozen=True)
class Ended:
    """A job that is over.

    Attributes:
        key: As it was submitted.
        fate: How it ended.
        value: What the work gave back if it is done.
        detail: One line otherwise.
    """

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
        """Have `work(*arguments)` carried out.

        Args:
            key: Comes back with the result.
            work: See `Work`.
            arguments: Picklable.
            limit: Wall clock from the job's start, s; beyond it the job is killed.
        """

    def collect(self, timeout: float) -> list[Ended]:
        """The jobs that ended since; waits for one for up to `timeout` s."""

    def __enter__(self) -> Self:
        """Start."""

    def __exit__(self, *error: object) -> None:
        """End every process at once, finished or not."""
