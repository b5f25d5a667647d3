"""What a campaign says while it goes on: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Callable, Mapping
from typing import Any, Self

from cavalcade.jobs.reporter import Reporter, duration

PLAIN_PERIOD, PLAIN_SHARE, PLAIN_LEAST = 30.0, 0.05, 5.0
"""Where there is no terminal, a line is printed every 30 s, or every 5 % but not within 5 s."""


class CampaignReporter(Reporter):
    """Says on stdout how far a campaign is. Use it as a context; with `quiet` it says nothing.

    Of `total` trials `done` were done before; `now` is the clock, s.
    """

    def __init__(
        self,
        name: str,
        total: int,
        done: int = 0,
        *,
        quiet: bool = False,
        now: Callable[[], float] = clock.monotonic,
    ) -> None:
        super().__init__(quiet)
        self._name, self._total, self._before, self._now = name, total, done, now
        self._finished = 0
        self._failed = 0
        self._started = self._said = now()
        self._said_at = 0

    def __enter__(self) -> Self:
        """Say what is to come."""
        super().__enter__()
        there = f", {self._before} of them done already" if self._before else ""
        self.say(f"{self._name}: {self._total} trials{there}")
        if self._console and self._console.is_terminal and self._before < self._total:
            from rich.progress import MofNCompleteColumn, TextColumn

            failed = TextColumn("{task.fields[failed]}{task.fields[left]}", markup=False)
            counts = {"total": self._total, "completed": self._before, "failed": "", "left": ""}
            self._show_bar([MofNCompleteColumn(), failed], 2, description=self._name, **counts)
        return self

    def warn(self, text: str) -> None:
        """One line on stderr, said even if quiet."""
        print(f"cavalcade: warning: {' '.join(text.split())}", file=sys.stderr, flush=True)

    def finished(self, line: Mapping[str, Any]) -> None:
        """Take note of a finished trial."""
        self._finished += 1
        self._failed += not line["success"]
        self.tick()

    def tick(self) -> None:
        """Show where things stand, if it is time to."""
        if self._console is None:
            return
        done = self._before + self._finished
        if self._bar is not None:
            self._bar.update(self._task, completed=done, failed=self._failures(), left=self._left())
            return
        now = self._now()
        share = (self._finished - self._said_at) / max(self._total, 1)
        waited = now - self._said
        due = waited >= PLAIN_PERIOD or (share >= PLAIN_SHARE and waited >= PLAIN_LEAST)
        if due and done < self._total and self._finished:
            self._said, self._said_at = now, self._finished
            percent = 100.0 * done / self._total
            text = f"{done} of {self._total} trials ({percent:.0f} %), {self._failures()}"
            self.say(f"{text}{self._left()}")

    def _failures(self) -> str:
        return f"{self._failed} failed" if self._failed else "none failed"

    def _left(self) -> str:
        """How much longer it will take at the pace so far; nothing before the first trial."""
        if not self._finished:
            return ""
        pace = (self._now() - self._started) / self._finished
        return f", {duration(pace * (self._total - self._before - self._finished))} left"
