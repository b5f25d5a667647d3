"""The planner's own time: it advances in every cycle, whatever the caller's clock does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cavalcade.errors import InputError
from cavalcade.formation.estimation import longest_gap
from cavalcade.geometry import Array

LATEST = 1e11
"""Largest time, s: some 3000 years; milliseconds since 1970 are beyond it."""
_WRONG_UNIT = 100.0  # periods per cycle that no loop takes,
_IN_A_ROW = 3  # when so many cycles after another do
_SAME = 1e-6  # s by which a time that repeats may differ
_LEAST = 0.1  # of a period: what a cycle counts for when repeats were counted before
_TOLD = 1.0  # s for which a message stands


class CycleClock:
    """Turns times of the caller's clock into times that increase from cycle to cycle.

    As long as the caller's clock advances they are the same. A time that repeats, is set back or
    jumps ahead counts as one cycle; so commands that are under way stay so, and patience runs on.
    A clock that repeats and catches up, as one of 10 Hz does under a loop of 20 Hz, is followed;
    one that stood still and goes on from there has lost that time.

    Attributes:
        now: The present cycle's time, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._longest = longest_gap(period)
        self.now = 0.0
        self._message = ""
        self._told = 0.0
        self._last: float | None = None
        # What is added to the caller's times, and what was before they last broke off.
        self._offset = self._former = 0.0
        self._swift = 0  # cycles in a row that advance as if in another unit
        self._gap = False
        self._raw: Array = np.empty(0)
        self._stamps: Array = np.empty(0)

    @property
    def message(self) -> str:
        """What is odd about the caller's clock; empty if nothing was lately."""
        return self._message if self.now - self._told <= _TOLD else ""

    def expect_gap(self) -> None:
        """Time may pass without cycles before the next one."""
        self._gap = True

    def advance(self, time: float, foreseen: Callable[[float], bool]) -> float:
        """The cycle's time for a `time` of the caller's clock, s.

        Args:
            time: s.
            foreseen: Whether the robots are where they would be at a given time of this clock;
                asked where the caller's jumps ahead, to know whether so much time has passed.

        Raises:
            InputError: The clock advances by far more per cycle than a cycle lasts.
        """
        last, self._last = self._last, time
        if last is None:
            self.now = time
            return time
        passed = time - last
        self._swift = self._swift + 1 if passed > _WRONG_UNIT * self._period else 0
        if self._swift >= _IN_A_ROW:
            raise InputError(
                f"advances by {passed:g} per cycle of {self._period:g} s; expected seconds",
                key="time",
            )
        then = time + self._offset
        if passed <= _SAME:
            then = self.now + self._period
            if passed < -_SAME:
                self._break_off(time, then)
                self._tell(f"the clock was set back by {-passed:.3g} s", then)
            elif then - (time + self._offset) > self._longest:
                self._tell("the clock stands still", then)
        elif then - self.now >= self._longest and not self._gap:
            soon = self.now + self._period
            if foreseen(soon):
                then = soon
                self._break_off(time, then)
                self._tell(f"the clock jumped ahead by {passed:.3g} s", then)
        elif self.now - then >= self._period - _SAME:
            then = self.now + min(passed, self._period)
            self._break_off(time, then)
        then = max(then, self.now + _LEAST * min(self._period, passed or self._period))
        self._gap = False
        self.now = then
        return then

    def placed(self, stamps: Array) -> Array:
        """Stamps `(N,)` of the caller's clock, those of the present cycle, on this one, s.

        One that does not change stays where it was.
        """
        if len(self._raw) != len(stamps):
            self._raw = np.full(len(stamps), np.nan)
            self._stamps = np.zeros(len(stamps))
        there = stamps + self._offset
        if self._former != self._offset:
            # Poses that were measured before the clock broke off have stamps of before.
            before = stamps + self._former
            nearer = np.abs(before - self.now) < np.abs(there - self.now)
            there = np.where(nearer, before, there)
        self._stamps = np.where(stamps == self._raw, self._stamps, there)
        self._raw = stamps
        return self._stamps.copy()

    def _break_off(self, time: float, then: float) -> None:
        self._former, self._offset = self._offset, then - time

    def _tell(self, message: str, time: float) -> None:
        self._message, self._told = message, time
