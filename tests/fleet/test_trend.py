"""The velocity that the poses of the last second show."""

from __future__ import annotations

import math

import pytest

from cavalcade.fleet.trend import PoseTrend


def test_velocity_is_the_trend_of_the_last_second() -> None:
    trend = PoseTrend()
    assert trend.velocity() == trend.pose == (0.0, 0.0, 0.0)
    for k in range(100):
        time, turn = 0.02 * k, math.remainder(3.0 + 0.01 * k, 2.0 * math.pi)
        noise = 0.01 * (-1) ** k
        trend.add(time, (0.3 * time + noise, 1.0, turn))
    assert trend.velocity() == pytest.approx((0.3, 0.0, 0.5), abs=0.01)
    assert trend.pose[1] == 1.0


def test_a_report_that_comes_again_and_again_is_one() -> None:
    trend = PoseTrend()
    for _ in range(1000):
        trend.add(5.0, (1.0, 2.0, 0.0))
    assert trend.velocity() == (0.0, 0.0, 0.0)
    trend.add(5.0, (3.0, 2.0, 0.0))
    assert trend.pose == (3.0, 2.0, 0.0)


def test_after_a_clock_that_was_set_back_what_came_before_does_not_count() -> None:
    trend = PoseTrend()
    for stamp, x in ((8.0, 50.0), (8.1, 60.0), (8.2, 70.0), (2.0, 1.0), (2.1, 1.1), (2.2, 1.2)):
        trend.add(stamp, (x, 0.0, 0.0))
    assert trend.velocity() == pytest.approx((1.0, 0.0, 0.0))
