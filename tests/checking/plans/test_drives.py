"""Robots without legs: unicycles and integrators keep their own rules, and faults are found."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cavalcade.checking.plans.drives import check_driven
from cavalcade.checking.plans.motion import Motion
from cavalcade.robots import MODELS

UNICYCLE = replace(
    MODELS["go1"],
    name="by-hand",
    drive="unicycle",
    legs=None,
    max_speed_x=0.5,
    max_speed_y=0.5,
    max_yaw_rate=0.5,
    max_acceleration=0.25,
    max_yaw_acceleration=0.25,
)
MODELS_OF = {
    "unicycle": UNICYCLE,
    "unicycle-2": replace(UNICYCLE, drive="unicycle-2"),
    "integrator": replace(UNICYCLE, drive="integrator", round=True),
    "integrator-2": replace(UNICYCLE, drive="integrator-2", round=True),
}


def motion(forward, turning, dt=0.03, heading=0.0, yaw=0.0):
    """From functions of time for the speed and the turning rate of a unicycle, by fine steps.

    The integral is that of 50 steps of the midpoint rule in each interval.
    """
    count, fine = 200, 50
    t = np.arange(count * fine + 1) * dt / fine
    middle = (t[1:] + t[:-1]) / 2
    angle = yaw + np.concatenate(([0.0], np.cumsum(turning(middle)) * dt / fine))
    between = (angle[1:] + angle[:-1]) / 2 + heading
    way = np.column_stack((np.cos(between), np.sin(between), 0 * between))
    place = np.concatenate((np.zeros((1, 3)), np.cumsum(forward(middle)[:, None] * way, axis=0)))
    place *= dt / fine
    velocity = forward(t)[:, None] * np.column_stack(
        (np.cos(angle + heading), np.sin(angle + heading), 0 * t)
    )
    some = slice(None, None, fine)
    phase = np.zeros(count + 1, dtype=np.int64)
    return Motion(0, t[some], place[some], velocity[some], angle[some], phase, np.zeros((0, 6)))


def still(t):
    return 0.0 * t


def swell(size, length=6.0):
    """From 0 up to `size` and back to 0 over 6 s."""
    return lambda t: size * np.sin(math.pi * t / length) ** 2


def kinds(found):
    return {violation.kind for violation in found}


@pytest.mark.parametrize("drive", MODELS_OF)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_sound_motion(drive, sign):
    turning = swell(0.4) if drive.startswith("unicycle") else still
    assert check_driven(motion(swell(sign * 0.45), turning), MODELS_OF[drive]) == []


@pytest.mark.parametrize("drive", ["unicycle", "integrator"])
def test_first_order_may_start_at_full_speed_and_change_it_at_once(drive):
    path = motion(lambda t: np.where(t < 2.985, 0.5, -0.5), still)
    assert check_driven(path, MODELS_OF[drive]) == []


def test_an_arc_at_constant_speed():
    path = motion(lambda t: 0.5 + 0 * t, lambda t: 0.5 + 0 * t)
    assert check_driven(path, MODELS_OF["unicycle"]) == []


@pytest.mark.parametrize("drive", ["unicycle-2", "integrator-2"])
def test_second_order_begins_and_ends_at_rest(drive):
    found = check_driven(motion(lambda t: 0.3 + 0 * t, still), MODELS_OF[drive])
    assert kinds(found) == {"dynamics"}
    assert [v.time for v in found] == pytest.approx([0.0, 6.0])


@pytest.mark.parametrize("drive", MODELS_OF)
def test_too_fast(drive):
    found = check_driven(motion(swell(0.53), still), MODELS_OF[drive])
    assert "speed" in kinds(found)


@pytest.mark.parametrize("drive", ["unicycle-2", "integrator-2"])
def test_too_much_acceleration(drive):
    path = motion(swell(0.45, 2.0), still)
    (violation, *_) = check_driven(path, MODELS_OF[drive])
    assert violation.kind == "acceleration"
    assert violation.limit == 0.25


@pytest.mark.parametrize("drive", ["unicycle", "unicycle-2"])
def test_too_much_turning(drive):
    assert "yaw-rate" in kinds(check_driven(motion(still, swell(0.53)), MODELS_OF[drive]))


def test_too_much_yaw_acceleration():
    path = motion(still, swell(0.45, 2.0))
    assert kinds(check_driven(path, MODELS_OF["unicycle-2"])) == {"yaw-acceleration"}
    assert check_driven(path, MODELS_OF["unicycle"]) == []


def test_turning_that_begins_at_once():
    path = motion(still, lambda t: 0.3 + 0 * t)
    found = check_driven(path, MODELS_OF["unicycle-2"])
    assert [v.time for v in found] == pytest.approx([0.0, 6.0])
    assert kinds(found) == {"yaw-acceleration"}


@pytest.mark.parametrize("drive", ["unicycle", "unicycle-2"])
def test_a_unicycle_that_slides(drive):
    path = motion(swell(0.4), still, heading=0.2)
    found = check_driven(path, MODELS_OF[drive])
    assert kinds(found) == {"dynamics"}
    assert "sideways" in found[0].message


def test_an_integrator_goes_where_it_likes():
    path = motion(swell(0.4), still, heading=2.0)
    assert check_driven(path, MODELS_OF["integrator-2"]) == []


def test_an_integrator_may_be_turned_in_no_time():
    path = motion(swell(0.4), still)
    path.yaw[100:] += 2.0
    assert check_driven(path, MODELS_OF["integrator"]) == []


@pytest.mark.parametrize("drive", MODELS_OF)
def test_a_jump(drive):
    path = motion(swell(0.4), still)
    path.position[100:, 0] += 0.01
    found = check_driven(path, MODELS_OF[drive])
    assert "dynamics" in kinds(found)
    assert found[0].time == pytest.approx(99 * 0.03)


@pytest.mark.parametrize("drive", MODELS_OF)
def test_nobody_flies(drive):
    path = motion(swell(0.4), still)
    path.position[100, 2] += 0.01
    assert "no legs" in check_driven(path, MODELS_OF[drive])[0].message


@pytest.mark.parametrize("at", [2.981, 2.985, 2.99])
def test_bends_that_change_sides_between_two_samples(at):
    path = motion(lambda t: 0.5 + 0 * t, lambda t: np.where(t < at, 0.5, -0.5))
    assert check_driven(path, MODELS_OF["unicycle"]) == []
