"""What a summary says of bodies and contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.metrics.physics_summary import count_contacts, summarise_physics
from cavalcade.recording.physics_track import ContactEvent, PhysicsTrack
from cavalcade.robots import robot_model

GO1 = robot_model("go1")
NOTHING = {"trunk": 0, "hip": 0, "thigh": 0, "calf": 0}


def lasting(begin: float, end: float, robot: int, part: str, other: str) -> list[ContactEvent]:
    return [ContactEvent(float(time), robot, part, other) for time in np.arange(begin, end, 0.02)]


def standing(samples: int = 51, robots: int = 2) -> PhysicsTrack:
    description = GO1.description
    assert description is not None
    base = np.zeros((samples, robots, 7))
    base[..., 2], base[..., 3] = description.stand_height, 1.0
    forces = np.zeros((samples, robots, 4, 3))
    forces[1:, ..., 2] = description.mass * 9.81 / 4.0
    zeros = np.zeros((samples, robots, 12))
    return PhysicsTrack(0.02 * np.arange(samples), base, zeros, zeros, zeros, forces)


def test_contacts_that_last_count_once() -> None:
    events = [
        *lasting(1.0, 2.0, 0, "calf", "obstacle"),
        *lasting(1.5, 2.5, 0, "thigh", "obstacle"),
        *lasting(3.0, 3.1, 0, "calf", "obstacle"),
        *lasting(3.0, 3.1, 1, "calf", "obstacle"),
    ]
    assert count_contacts(events)["robot_obstacle"] == 3


def test_both_robots_tell_of_one_contact() -> None:
    events = [
        *lasting(1.0, 1.3, 0, "trunk", "robot 2"),
        *lasting(1.0, 1.3, 2, "foot", "robot 0"),
        *lasting(1.0, 1.3, 2, "foot", "robot 1"),
        *lasting(1.0, 1.3, 1, "calf", "robot 2"),
    ]
    found = count_contacts(events)
    assert (found["robot_robot"], found["robot_obstacle"], found["ground"]) == (2, 0, NOTHING)


def test_parts_on_the_ground_count_by_part_and_robot() -> None:
    events = [
        *lasting(1.0, 1.3, 0, "calf", "ground"),
        *lasting(1.0, 1.3, 1, "calf", "ground"),
        *lasting(1.2, 1.3, 1, "trunk", "ground"),
    ]
    assert count_contacts(events)["ground"] == {**NOTHING, "calf": 2, "trunk": 1}


def test_the_order_does_not_matter() -> None:
    events = [*lasting(1.0, 1.5, 0, "calf", "obstacle"), *lasting(2.0, 2.5, 0, "hip", "obstacle")]
    assert count_contacts(events[::-1]) == count_contacts(events)


def test_robots_that_stand_carry_their_weight() -> None:
    found = summarise_physics(standing(), (GO1, GO1))
    assert found["carried_share"] == pytest.approx([1.0, 1.0])
    assert found["max_tilt_rad"] == found["max_torque_share"] == found["max_speed_share"] == 0.0
    assert found["contacts"] == {"robot_robot": 0, "robot_obstacle": 0, "ground": NOTHING}


def test_shares_are_of_the_joint_s_own_limits() -> None:
    description = GO1.description
    assert description is not None
    track = standing()
    torques, rates = track.torques.copy(), track.joint_rates.copy()
    torques[3, 1, 5] = -0.5 * description.torque_limits[5]
    torques[4, 1, 4] = 0.4 * description.torque_limits[4]
    rates[3, 0, 2] = 0.25 * description.speed_limits[2]
    found = summarise_physics(replace(track, torques=torques, joint_rates=rates), (GO1, GO1))
    assert found["max_torque_share"] == pytest.approx(0.5)
    assert found["max_speed_share"] == pytest.approx(0.25)


@pytest.mark.parametrize("axis", [1, 2])
def test_tilt_is_the_angle_to_the_vertical(axis: int) -> None:
    track = standing()
    base = track.base.copy()
    base[7, 0, 3] = np.cos(0.2)
    base[7, 0, 3 + axis] = np.sin(0.2)
    base[9, 1, 3], base[9, 1, 6] = np.cos(0.7), np.sin(0.7)
    found = summarise_physics(replace(track, base=base), (GO1, GO1))
    assert found["max_tilt_rad"] == pytest.approx(0.4, abs=1e-6)


def test_a_run_that_ended_at_once_has_a_summary() -> None:
    assert summarise_physics(standing(1), (GO1, GO1))["carried_share"] == [None, None]
