"""Leaps worked out by hand: one succeeds, and everything that spoils it is found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.checking.heights import Heights
from cavalcade.checking.physics import Floor, Leap, Touch, judge_leap
from cavalcade.checking.physics.leaps import leap_reason

from .conftest import GO1, GRAVITY, still

GAP = Leap(edge=(0.55, 0.0), heading=0.0, begin=0.4)
TAKE_OFF, LANDING = 0.5, 0.9


def leapt(far=1.0, height=0.0, seconds=3.0):
    """Stands at x = 0, flies from 0.5 to 0.9 s, and stands `far` on and `height` up."""
    record = still(seconds)
    time, base = record.time, record.base.copy()
    part = np.clip((time - TAKE_OFF) / (LANDING - TAKE_OFF), 0.0, 1.0)
    base[:, 0] = far * part
    flight = LANDING - TAKE_OFF
    base[:, 2] += height * part + 0.5 * GRAVITY * flight**2 * part * (1.0 - part)
    stands = (time <= TAKE_OFF + 1e-9) | (time > LANDING + 1e-9)
    forces = np.zeros_like(record.forces)
    forces[stands, :, 2] = GO1.mass * GRAVITY / 4.0
    return replace(record, base=base, forces=forces)


def verdict(record, leap=GAP):
    return judge_leap(record, GO1, leap, Floor())


def pitched(record, angle, begin, end):
    base = record.base.copy()
    there = (record.time > begin) & (record.time < end)
    base[there, 3:] = (np.cos(angle / 2.0), 0.0, np.sin(angle / 2.0), 0.0)
    return replace(record, base=base)


def test_a_leap_across_a_gap_succeeds():
    found = verdict(leapt())
    assert (found.ok, found.reason) == (True, "")
    assert found.flight == pytest.approx(LANDING - TAKE_OFF, abs=0.03)
    assert found.touch_down == pytest.approx(LANDING, abs=0.03)
    assert found.lowest == pytest.approx(0.0, abs=1e-9)
    assert found.pitch == 0.0


def test_a_leap_onto_a_step_succeeds():
    step = Leap(edge=(0.55, 0.0), heading=0.0, beyond=0.2, begin=0.4)
    assert verdict(leapt(height=0.2), step).ok
    assert "touch down" in verdict(leapt(height=0.1), step).reason


def test_it_may_lie_in_any_direction():
    turned = leapt()
    base = turned.base.copy()
    base[:, 1], base[:, 0] = base[:, 0], 0.0
    base[:, 3], base[:, 6] = np.sqrt(0.5), np.sqrt(0.5)
    leap = Leap(edge=(5.0, 0.55), heading=np.pi / 2.0, begin=0.4)
    assert verdict(replace(turned, base=base), leap).ok


def test_hind_feet_that_stay_behind_fail():
    found = verdict(leapt(far=0.6))
    assert not found.ok
    assert found.reason == "only 2 feet touch down beyond the edge"
    assert np.isnan(found.touch_down)


def test_a_foot_in_the_gap_fails():
    record = leapt()
    base = record.base.copy()
    inside = (record.time > 0.86) & (record.time < 0.96)
    base[inside, 2] -= 0.07
    found = verdict(replace(record, base=base))
    assert "below the surface" in found.reason
    assert found.lowest > 0.05


@pytest.mark.parametrize("part", ["trunk", "hip", "thigh"])
def test_a_body_that_touches_fails(part):
    record = replace(leapt(), touches=(Touch(0.95, part, "ground"),))
    assert verdict(record).reason == f"the {part} touches the ground at 0.95 s"


def test_a_calf_may_touch_and_so_may_what_was_before():
    touches = (Touch(0.1, "trunk", "ground"), Touch(0.95, "calf", "ground"))
    assert verdict(replace(leapt(), touches=touches)).ok


def test_a_body_that_touches_unrecorded_fails():
    record = leapt(seconds=4.0)
    joints = record.joints.copy()
    lies = record.time > 3.0
    joints[lies] = np.tile((0.0, 1.5, -2.8), 4)
    base = record.base.copy()
    base[lies, 2] = 0.05
    assert "says nothing of it" in verdict(replace(record, joints=joints, base=base)).reason


def test_a_steep_trunk_fails():
    assert "pitched" in verdict(pitched(leapt(), -0.6, 0.6, 0.7)).reason
    assert verdict(pitched(leapt(), -0.4, 0.6, 0.7)).ok


def test_a_robot_that_does_not_stay_up_fails():
    record = leapt()
    tipped = record.base.copy()
    late = record.time > 2.0
    tipped[late, 3:] = (np.cos(0.3), np.sin(0.3), 0.0, 0.0)
    assert "does not stay up" in verdict(replace(record, base=tipped)).reason
    later = record.base.copy()
    later[record.time > 2.5] = tipped[record.time > 2.5]
    assert verdict(replace(record, base=later)).ok


def test_a_recording_that_ends_early_fails():
    assert "ends" in verdict(leapt(seconds=2.0)).reason
    assert verdict(leapt(seconds=2.5)).ok


def test_a_robot_that_falls_back_fails():
    record = leapt()
    base = record.base.copy()
    base[record.time > 1.5, 0] = 0.6
    assert "back before the edge" in verdict(replace(record, base=base)).reason


def test_of_a_run_that_ended_before_its_leap_there_is_nothing_to_say():
    record = still(1.0)
    names = ("time", "base", "joints", "rates", "torques", "forces")
    nothing = replace(record, **{name: getattr(record, name)[:0] for name in names})
    level = Heights(np.zeros((40, 60)), 0.05, (-1.0, -1.0, 0.0))
    assert leap_reason(nothing, GO1, level, np.array([1.0, 0.0]), 2.0) == ""
    assert "only 0 feet" in verdict(nothing).reason
