"""Planted lies: each is found, and by the rule that is about it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.checking.physics import Touch
from cavalcade.checking.physics.kinematics import posture

from .conftest import GO1, GRAVITY, carried, still, with_rates


def kinds(violations):
    return {violation.kind for violation in violations}


def moved(record, change):
    """The same robot with its trunk, and so its feet, displaced by `change` `(T, 3)`."""
    base = record.base.copy()
    base[:, :3] += change
    return replace(record, base=base)


def ramp(time, speed):
    """Displacement `(T, 3)` along x: still, then at once at that speed."""
    return np.column_stack((speed * np.maximum(time - 1.0, 0.0), 0.0 * time, 0.0 * time))


@pytest.mark.parametrize("speed", [0.05, 0.2, 0.5])
def test_a_robot_that_is_slid_without_legs_is_refused(standing, verdict, speed):
    found = verdict(moved(standing, ramp(standing.time, speed)))
    assert "slide" in kinds(found)


def test_a_sudden_start_without_force_is_refused(standing, verdict):
    found = verdict(moved(standing, ramp(standing.time, 0.3)))
    assert "momentum" in kinds(found)
    first = next(violation for violation in found if violation.kind == "momentum")
    assert first.time == pytest.approx(1.0, abs=0.15)


def test_a_slow_start_without_force_is_refused(standing, verdict):
    """Whatever the feet do: here all of them are said to be in the air half of the time."""
    time = standing.time
    speed = 0.4 * np.clip((time - 1.0) / 1.0, 0.0, 1.0)
    change = np.column_stack((np.cumsum(speed) * 0.02, 0.0 * time, 0.0 * time))
    assert "momentum" in kinds(verdict(moved(standing, change)))


def test_a_slid_robot_with_all_the_right_forces_slides(verdict):
    slid = carried(moved(still(), ramp(still().time, 0.2)))
    assert "slide" in kinds(verdict(slid))


def test_a_robot_that_floats_is_refused(standing, verdict):
    floating = moved(standing, np.tile((0.0, 0.0, 0.03), (len(standing.time), 1)))
    assert kinds(verdict(floating)) == {"footing"}


def test_a_robot_that_floats_without_forces_is_refused(standing, verdict):
    floating = moved(standing, np.tile((0.0, 0.0, 0.03), (len(standing.time), 1)))
    floating = replace(floating, forces=0.0 * floating.forces, torques=0.0 * floating.torques)
    assert kinds(verdict(floating)) == {"weight", "momentum"}


def test_forces_with_the_right_mean_only_are_refused(standing, verdict):
    """A robot that bobs, with the forces of one that stands."""
    bob = 0.02 * np.sin(2.0 * np.pi * standing.time)
    base = standing.base.copy()
    base[:, 2] += bob
    joints = standing.joints.copy()
    for k, height in enumerate(base[:, 2]):
        joints[k] = np.concatenate(
            [GO1.leg_angles(leg, height - GO1.foot_radius) for leg in range(4)]
        )
    bobbing = with_rates(replace(standing, base=base, joints=joints))
    assert kinds(verdict(carried(bobbing))) == set()
    found = kinds(verdict(bobbing))
    assert "momentum" in found
    assert "weight" not in found


def test_forces_under_the_wrong_feet_are_refused(standing, verdict):
    """Their sum is right; the robot would have tipped over."""
    forces = standing.forces.copy()
    forces[:, :2, 2] += 10.0
    forces[:, 2:, 2] -= 10.0
    assert "angular-momentum" in kinds(verdict(replace(standing, forces=forces)))


def test_a_teleport_is_refused(standing, verdict):
    jump = np.where(standing.time > 1.5, 0.3, 0.0)
    change = np.column_stack((jump, 0.0 * jump, 0.0 * jump))
    assert {"momentum", "slide"} <= kinds(verdict(moved(standing, change)))


def test_too_much_weight_is_refused(standing, verdict):
    heavy = replace(standing, forces=1.05 * standing.forces)
    assert "weight" in kinds(verdict(heavy))


def test_legs_that_do_no_work_are_refused(standing, verdict):
    idle = replace(standing, torques=0.0 * standing.torques)
    assert kinds(verdict(idle)) == {"torque"}


def test_too_large_a_torque_is_refused(standing, verdict):
    torques = standing.torques.copy()
    torques[70, 4] = -24.5
    found = next(v for v in verdict(replace(standing, torques=torques)) if v.limit == 23.7)
    assert (found.kind, found.value) == ("torque", 24.5)
    assert found.time == pytest.approx(standing.time[70])
    assert "FR thigh" in found.message


def test_a_joint_beyond_its_range_is_refused(standing, verdict):
    joints = standing.joints.copy()
    joints[:, 2] = -0.7
    assert "joint" in kinds(verdict(replace(standing, joints=joints)))


def test_rates_that_are_not_those_of_the_angles_are_refused(standing, verdict):
    rates = np.full_like(standing.rates, 3.0)
    assert kinds(verdict(replace(standing, rates=rates))) == {"joint"}


def test_a_single_sliding_foot_is_refused(standing, verdict):
    joints = standing.joints.copy()
    joints[:, 4] += 0.3 * np.clip(standing.time - 1.0, 0.0, 1.0)
    found = verdict(with_rates(replace(standing, joints=joints)))
    slid = [violation for violation in found if violation.kind == "slide"]
    assert len(slid) == 1
    assert "FR" in slid[0].message


def test_a_foot_may_roll(verdict):
    """Its ball turns with the calf: what touches the ground stays where it is."""
    from cavalcade.checking.physics.feet import slides

    record = still()
    angle = 0.4 * np.sin(np.pi * record.time)
    base = record.base.copy()
    # The whole robot pitches about the feet's balls as these roll along the ground.
    base[:, 3], base[:, 5] = np.cos(angle / 2.0), np.sin(angle / 2.0)
    pitched = replace(record, base=base)
    feet = posture(pitched, GO1).feet
    start = posture(record, GO1).feet
    base[:, :3] += (start - feet)[:, 0]
    base[:, 0] += GO1.foot_radius * angle
    rolled = carried(replace(record, base=base))
    assert slides(rolled, posture(rolled, GO1))[:, 0].max() < 1e-3
    base[:, 0] -= GO1.foot_radius * angle
    turned = carried(replace(record, base=base))
    assert slides(turned, posture(turned, GO1))[:, 0].max() > 0.005


def test_a_sunken_foot_is_refused(standing, verdict):
    sunk = moved(standing, np.tile((0.0, 0.0, -0.02), (len(standing.time), 1)))
    assert kinds(verdict(sunk)) == {"footing"}


def test_more_friction_than_there_is_is_refused(standing, verdict):
    forces = standing.forces.copy()
    forces[:, 0, 1] += 60.0
    forces[:, 1, 1] -= 60.0
    assert "friction" in kinds(verdict(replace(standing, forces=forces)))


def test_a_pulling_foot_is_refused(standing, verdict):
    forces = standing.forces.copy()
    forces[:, [0, 3], 2] += 40.0
    forces[:, [1, 2], 2] -= 40.0
    assert "friction" in kinds(verdict(replace(standing, forces=forces)))


def lying():
    """A robot that lies on its belly, its legs folded beside it."""
    record = still()
    base = record.base.copy()
    base[:, 2] = 0.05
    joints = np.tile((0.0, 1.3, -2.7), (len(base), 4))
    return carried(replace(record, base=base, joints=joints))


def test_contacts_that_the_recorder_left_out_are_found(verdict):
    found = verdict(lying())
    hidden = [violation for violation in found if violation.kind == "contact"]
    assert hidden
    assert "says nothing of it" in hidden[0].message
    assert "fall" in kinds(found)


def test_recorded_contacts_are_named_with_their_moment(standing, verdict):
    touches = (Touch(1.234, "thigh", "ground"), Touch(1.25, "thigh", "ground"))
    (found,) = verdict(replace(standing, touches=touches))
    assert (found.kind, found.time) == ("contact", 1.234)
    assert "thigh" in found.message


def test_a_calf_on_the_ground_is_let_pass(standing, verdict):
    assert verdict(replace(standing, touches=(Touch(1.0, "calf", "ground"),))) == []


def test_a_robot_does_not_walk_on_its_calves(standing, verdict):
    """It might hide everything that carries it by saying so."""
    touches = tuple(Touch(float(time), "calf", "ground") for time in standing.time[1:])
    (found,) = verdict(replace(standing, touches=touches))
    assert found.kind == "contact"


def test_a_robot_that_tips_over_has_fallen(standing, verdict):
    base = standing.base.copy()
    tilt = 1.2 * np.clip(standing.time - 1.0, 0.0, 1.0)
    base[:, 3], base[:, 4] = np.cos(tilt / 2.0), np.sin(tilt / 2.0)
    falls = [v for v in verdict(replace(standing, base=base)) if v.kind == "fall"]
    assert len(falls) == 1
    assert falls[0].time == pytest.approx(1.0 + 1.0 / 1.2, abs=0.03)


def test_robots_in_each_other_are_found_though_nothing_was_recorded(verdict):
    one, two = carried(still()), carried(still(robot=1, place=(0.45, 0.1)))
    found = verdict(one, two)
    assert kinds(found) == {"robot-robot"}
    assert {violation.robots for violation in found} == {(0, 1), (1, 0)}
    assert verdict(one, carried(still(robot=1, place=(0.75, 0.1)))) == []


def test_the_weight_is_that_of_all_links(standing):
    assert posture(standing, GO1).weight == pytest.approx(GO1.mass)
    assert standing.forces[5, :, 2].sum() == pytest.approx(GO1.mass * GRAVITY)
