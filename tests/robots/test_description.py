"""Quadrupeds as mechanisms: laws that hold for every one of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.robots import MODELS, PARTS, body_of

DESCRIBED = {name: model.description for name, model in MODELS.items() if model.description}


@pytest.fixture(params=DESCRIBED)
def robot(request):
    return DESCRIBED[request.param]


def turn(axis, angle):
    """Rotation `(3, 3)` about a unit vector."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def foot_in_trunk(robot, leg, angles):
    """Centre of a foot in the trunk's frame, m."""
    place, orientation = np.zeros(3), np.eye(3)
    for joint, angle in zip(robot.legs[leg].joints, angles, strict=True):
        place = place + orientation @ joint.offset
        orientation = orientation @ turn(joint.axis, angle)
    return place + orientation @ robot.legs[leg].foot


def test_go1_and_go2_are_described():
    assert set(DESCRIBED) == {"go1", "go2"}
    assert all(name == robot.name for name, robot in DESCRIBED.items())


def test_feet_are_where_the_joints_bring_them(robot):
    joints = np.random.default_rng(1).uniform(-2.5, 2.5, (3, 5, 12))
    places = robot.foot_places(joints)
    assert places.shape == (3, 5, 4, 3)
    for i, j in np.ndindex(3, 5):
        for leg in range(4):
            wanted = foot_in_trunk(robot, leg, joints[i, j, 3 * leg : 3 * leg + 3])
            np.testing.assert_allclose(places[i, j, leg], wanted, atol=1e-12)


@pytest.mark.parametrize("name", ["go1", "go2", "spirit"])
def test_joints_bring_feet_where_they_are_to_be(name):
    body = body_of(MODELS[name])
    joints = body.standing + np.random.default_rng(2).uniform(-0.4, 0.4, (3, 5, 12))
    np.testing.assert_allclose(body.joints_at(body.foot_places(joints)), joints, atol=1e-9)


@pytest.mark.parametrize("name", ["go1", "go2", "spirit"])
def test_legs_point_at_what_they_do_not_reach(name):
    body = body_of(MODELS[name])
    feet = body.foot_places(body.standing)
    far = feet - (0.0, 0.0, 1.0)
    found = body.foot_places(body.joints_at(far))
    assert np.isfinite(found).all()
    assert (found[:, 2] < feet[:, 2]).all()
    np.testing.assert_allclose(found[:, :2], feet[:, :2], atol=1e-3)


def test_the_mass_is_that_of_all_links(robot):
    links = [link.mass for leg in robot.legs for link in leg.links]
    assert robot.mass == pytest.approx(robot.trunk.mass + sum(links))
    assert 12.0 < robot.mass < 17.0


def test_every_inertia_is_that_of_a_real_body(robot):
    for body in (robot.trunk, *(link for leg in robot.legs for link in leg.links)):
        moments = np.linalg.eigvalsh(body.matrix)
        assert moments[0] > 0.0
        assert moments[2] <= moments[0] + moments[1]


def test_left_and_right_front_and_rear_stand_alike(robot):
    hips = robot.joint_offsets[:, 0]
    np.testing.assert_allclose(hips[:, 0], abs(hips[0, 0]) * np.array([1, 1, -1, -1]))
    np.testing.assert_allclose(hips[:, 1], abs(hips[0, 1]) * np.array([1, -1, 1, -1]))
    sides = robot.joint_offsets[:, 1, 1]
    np.testing.assert_allclose(sides, abs(sides[0]) * np.array([1, -1, 1, -1]))
    centers = np.array([[link.center for link in leg.links[:2]] for leg in robot.legs])
    np.testing.assert_allclose(centers[0], centers[1] * (1.0, -1.0, 1.0))
    np.testing.assert_allclose(centers[2], centers[3] * (1.0, -1.0, 1.0))
    masses = np.array([[link.mass for link in leg.links] for leg in robot.legs])
    np.testing.assert_array_equal(masses, np.broadcast_to(masses[0], masses.shape))


def test_standing_feet_are_below_the_thighs_and_on_the_ground(robot):
    angles = robot.standing.reshape(4, 3)
    assert (robot.joint_range[:, 0] <= robot.standing).all()
    assert (robot.standing <= robot.joint_range[:, 1]).all()
    for leg in range(4):
        foot = foot_in_trunk(robot, leg, angles[leg])
        thigh = robot.joint_offsets[leg, 0] + robot.joint_offsets[leg, 1]
        np.testing.assert_allclose(foot[:2], thigh[:2], atol=1e-9)
        assert foot[2] - robot.foot_radius == pytest.approx(-robot.stand_height)


@pytest.mark.parametrize("drop", [0.15, 0.2, 0.3, 0.36])
def test_a_leg_reaches_straight_down(robot, drop):
    for leg in range(4):
        foot = foot_in_trunk(robot, leg, robot.leg_angles(leg, drop))
        assert foot[2] == pytest.approx(-drop)
        assert foot[0] == pytest.approx(robot.joint_offsets[leg, 0, 0])


def test_a_drop_out_of_reach_is_answered_by_the_nearest_in_the_joints_range(robot):
    for leg in range(4):
        for drop in (0.0, 2.0):
            lower, upper = robot.joint_range[3 * leg : 3 * leg + 3].T
            angles = robot.leg_angles(leg, drop)
            assert (lower <= angles).all()
            assert (angles <= upper).all()


def test_figures_of_joints_are_in_order_and_read_only(robot):
    assert robot.torque_limits.shape == robot.speed_limits.shape == (12,)
    for number, joint in enumerate(robot.joints):
        assert joint is robot.legs[number // 3].joints[number % 3]
        assert robot.torque_limits[number] == joint.torque > 0.0
        assert robot.speed_limits[number] == joint.speed > 0.0
        assert joint.lower < joint.upper
        assert joint.stall_torque >= joint.torque
        assert joint.no_load_speed >= joint.speed
        assert np.linalg.norm(joint.axis) == pytest.approx(1.0)
    with pytest.raises(ValueError, match="read-only"):
        robot.torque_limits[0] = 1.0


def test_a_knee_has_the_power_of_its_motor(robot):
    power = robot.torque_limits * robot.speed_limits
    np.testing.assert_allclose(power, power[0], rtol=1e-3)


@pytest.mark.parametrize("kind", ["looks", "solids"])
def test_shapes_hang_on_their_links(robot, kind):
    shapes = getattr(robot, kind)
    assert {shape.part for shape in shapes} == set(PARTS)
    for shape in shapes:
        assert (shape.leg == -1) == (shape.part == "trunk")
        expected = {"trunk": 0, "hip": 1, "thigh": 2, "calf": 3, "foot": 3}[shape.part]
        assert shape.link == expected + 3 * max(shape.leg, 0)
        assert np.linalg.norm(shape.rotation) == pytest.approx(1.0)
        used = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2}[shape.kind]
        assert all(size > 0.0 for size in shape.size[:used])
        assert not any(shape.size[used:])
        assert all(0.0 <= share <= 1.0 for share in shape.color)


def test_feet_are_balls_where_the_legs_end(robot):
    for kind in (robot.looks, robot.solids):
        feet = [shape for shape in kind if shape.part == "foot"]
        assert [shape.leg for shape in feet] == [0, 1, 2, 3]
        for shape in feet:
            assert shape.kind == "sphere"
            assert shape.size[0] == robot.foot_radius
            assert shape.position == robot.legs[shape.leg].foot


def test_no_solid_of_a_leg_lies_lower_than_the_foot_when_standing(robot):
    for shape in robot.solids:
        if shape.part == "calf":
            ends = shape.position[2] - shape.size[1] - shape.size[0]
            assert ends > robot.legs[shape.leg].foot[2] - robot.foot_radius
