"""Cycles at a fixed rate on a clock that is somebody else's."""

from __future__ import annotations

import math
import time as wall
from collections.abc import Callable

from cavalcade.errors import InputError

_NAP = 0.002
"""Longest wait between two looks at a clock that may run at any pace, s."""

_STILL = 0.25
"""A clock that shows the same for so long, s of the wall's time, is not waited for any more."""


class Schedule:
    """When the next cycle is due: a period after the last one was, so that nothing drifts.

    Who is late by more than a period skips those that were missed. After a clock was set back, or
    ahead by far, the schedule begins anew. A clock that stands still is waited for no longer than
    0.25 s and two periods: then somebody has to look at it.
    """

    def __init__(self) -> None:
        self._due: float | None = None

    def wait(self, period: float, clock: Callable[[], float]) -> None:
        """Wait until the next cycle is due on the clock, s.

        Raises:
            InputError: The period is not positive and finite.
        """
        if not (math.isfinite(period) and period > 0.0):
            raise InputError("expected a positive time step", key="dt")
        now = clock()
        due = now + period if self._due is None else self._due + period
        if due < now:
            due += period * ((now - due) // period)
        if not now - period <= due <= now + period:
            due = now + period
        self._due = due
        changed, began = wall.monotonic(), now
        while now < due and now >= began - period:
            if wall.monotonic() - changed > max(_STILL, 2.0 * period):
                self._due = None
                return
            wall.sleep(min(_NAP, due - now))
            before, now = now, clock()
            if now != before:
                changed = wall.monotonic()
        if now < due:  # set back meanwhile
            self._due = None
