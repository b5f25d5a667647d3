"""When cycles are due."""

from __future__ import annotations

import math

import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.schedule import Schedule


class Clock:
    """Goes on by `tick` whenever somebody looks."""

    def __init__(self, tick: float) -> None:
        self.now, self.tick = 100.0, tick

    def __call__(self) -> float:
        self.now += self.tick
        return self.now


def test_cycles_do_not_drift_and_missed_ones_are_skipped() -> None:
    clock, schedule = Clock(0.001), Schedule()
    schedule.wait(0.05, clock)
    first = clock.now
    for _ in range(20):
        schedule.wait(0.05, clock)
    assert clock.now == pytest.approx(first + 1.0, abs=0.003)
    clock.now += 0.12
    schedule.wait(0.05, clock)  # at once: two cycles were missed, one of them is skipped
    assert clock.now == pytest.approx(first + 1.12, abs=0.003)
    schedule.wait(0.05, clock)
    assert clock.now == pytest.approx(first + 1.15, abs=0.003)


def test_a_clock_that_stands_still_or_goes_back_is_not_waited_for_without_end() -> None:
    still, schedule = Clock(0.0), Schedule()
    schedule.wait(0.05, still)
    schedule.wait(0.05, still)
    back = Clock(0.001)
    schedule.wait(0.05, back)
    back.now = 10.0
    schedule.wait(0.05, back)
    assert back.now == pytest.approx(10.05, abs=0.003)


@pytest.mark.parametrize("period", [0.0, -0.05, math.nan, math.inf])
def test_a_period_is_positive_and_finite(period: float) -> None:
    with pytest.raises(InputError, match="dt"):
        Schedule().wait(period, Clock(0.001))
