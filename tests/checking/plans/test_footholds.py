"""Planted faults in footholds."""

from __future__ import annotations

import numpy as np
import pytest


def only(report):
    found = [v for v in report.violations if v.kind == "foothold"]
    assert len(found) == len(report.violations) == 1, report.violations
    return found[0]


def some_step(judged, leg=None):
    """A foothold in the middle of the plan."""
    feet = judged.arrays["footholds_0"]
    half = judged.arrays["t_0"][-1] / 2
    rows = np.flatnonzero((feet[:, 0] > half) & ((leg is None) | (feet[:, 2] == leg)))
    return int(rows[0])


def test_no_footholds_at_all(walker):
    walker.arrays["footholds_0"] = np.zeros((0, 6))
    assert "has no footholds" in only(walker.report()).message


@pytest.mark.parametrize("height", [0.05, -0.05])
def test_a_foot_off_the_ground(walker, height):
    k = some_step(walker)
    walker.arrays["footholds_0"][k, 5] = height
    violation = only(walker.report())
    assert violation.robots == (0,)
    assert violation.time == walker.arrays["footholds_0"][k, 0]
    assert violation.value == pytest.approx(0.05)


def test_a_leg_nobody_has(walker):
    walker.arrays["footholds_0"][some_step(walker), 2] = 4
    assert "belongs to no leg" in only(walker.report()).message


def test_a_foot_that_leaves_before_it_comes(walker):
    k = some_step(walker)
    walker.arrays["footholds_0"][k, 1] = walker.arrays["footholds_0"][k, 0] - 0.1
    assert "leaves before it comes" in only(walker.report()).message


def test_a_leg_in_two_places(walker):
    k = some_step(walker, leg=2)
    walker.arrays["footholds_0"][k, 1] += 0.3
    messages = [v.message for v in walker.report().violations]
    assert "before the leg has left" in messages[0]


def test_a_body_without_feet_below(walker):
    feet = walker.arrays["footholds_0"]
    time = feet[some_step(walker), 0]
    walker.arrays["footholds_0"] = feet[feet[:, 0] != time]
    violation = only(walker.report())
    assert violation.time == pytest.approx(time)
    assert "stands on no foot" in violation.message


def test_feet_that_end_before_the_plan(walker):
    feet = walker.arrays["footholds_0"]
    walker.arrays["footholds_0"] = feet[feet[:, 0] < feet[:, 0].max()]
    assert "stands on no foot" in only(walker.report()).message


@pytest.mark.parametrize(("away", "ok"), [(0.2, True), (0.4, False)])
def test_reach(walker, away, ok):
    k = some_step(walker)
    walker.arrays["footholds_0"][k, 4] += away
    report = walker.report()
    assert report.ok == ok
    if not ok:
        violation = only(report)
        down, up = walker.arrays["footholds_0"][k, :2]
        assert down - 1e-6 <= violation.time <= up
        assert violation.limit == pytest.approx(1.2 * 0.375)


def test_left_and_right_are_not_the_same(walker):
    feet = walker.arrays["footholds_0"]
    swapped = feet[:, 2].copy()
    swapped[feet[:, 2] == 0], swapped[feet[:, 2] == 3] = 3, 0
    feet[:, 2] = swapped
    assert any(v.kind == "foothold" for v in walker.report().violations)


def test_a_foot_on_the_ground_in_flight(leaper):
    feet, phase = leaper.arrays["footholds_0"], leaper.arrays["phase_0"]
    time = leaper.arrays["t_0"]
    take_off, touch_down = time[phase == 2][0], time[phase == 3][0]
    k = int(np.flatnonzero(np.isclose(feet[:, 1], take_off) & (feet[:, 2] == 3))[0])
    feet[k, 1] = (take_off + touch_down) / 2
    violation = only(leaper.report())
    assert "stands in the flight" in violation.message
    assert violation.time == feet[k, 0]


def test_in_take_off_the_front_legs_may_hang(leaper):
    feet, phase = leaper.arrays["footholds_0"], leaper.arrays["phase_0"]
    start = leaper.arrays["t_0"][phase == 1][0]
    beginning = np.isclose(feet[:, 0], start)
    for leg, ok in ((0, True), (2, False)):
        k = int(np.flatnonzero(beginning & (feet[:, 2] == leg))[0])
        feet[k, 4] += 0.5
        assert leaper.report().ok == ok
