"""Leg kernels against chains of rotations, finite differences, energies and MuJoCo."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cavalcade.geometry import GRAVITY
from cavalcade.locomotion._kinematics import (
    SINGULAR,
    angles,
    cross,
    leg_forward,
    leg_inverse,
    leg_weight,
    rotation,
    solve3,
    turned,
    turned_back,
    wrapped,
)
from cavalcade.locomotion.parameters import robot_parameters
from cavalcade.robots import robot_model

ROBOTS = {name: robot_model(name).description for name in ("go1", "go2")}
PARAMETERS = {name: robot_parameters(robot)[()] for name, robot in ROBOTS.items()}
LEGS = range(4)

robots = st.sampled_from(sorted(ROBOTS))
legs = st.integers(0, 3)
shares = st.tuples(*[st.floats(0.01, 0.99)] * 3)


def chain(robot, leg, joints):
    """Places of the links' centres `(3, 3)` and of the foot, joint by joint."""
    place, turn, centres = np.zeros(3), Rotation.identity(), []
    parts = robot.legs[leg]
    for joint, link, angle in zip(parts.joints, parts.links, joints, strict=True):
        place = place + turn.apply(joint.offset)
        turn = turn * Rotation.from_rotvec(angle * np.array(joint.axis))
        centres.append(place + turn.apply(link.center))
    return np.array(centres), place + turn.apply(parts.foot)


def forward(name, leg, joints):
    place, jacobian = np.empty(3), np.empty((3, 3))
    leg_forward(PARAMETERS[name], leg, np.array(joints), place, jacobian)
    return place, jacobian


def inverse(name, leg, place):
    joints = np.empty(3)
    leg_inverse(PARAMETERS[name], leg, np.array(place), joints)
    return joints


def drawn(name, leg, share):
    """Joints at shares of their ranges."""
    low, high = ROBOTS[name].joint_range[3 * leg : 3 * leg + 3].T
    return low + np.array(share) * (high - low)


@given(robots, legs, shares)
@settings(deadline=None)
def test_feet_are_where_a_chain_of_rotations_puts_them(name, leg, share):
    joints = drawn(name, leg, share)
    np.testing.assert_allclose(
        forward(name, leg, joints)[0], chain(ROBOTS[name], leg, joints)[1], atol=1e-12
    )


@given(robots, legs, shares)
@settings(deadline=None)
def test_the_jacobian_is_the_derivative(name, leg, share):
    joints, step = drawn(name, leg, share), 1e-6
    for j, unit in enumerate(np.eye(3)):
        ahead, behind = (forward(name, leg, joints + s * step * unit)[0] for s in (1.0, -1.0))
        np.testing.assert_allclose(
            forward(name, leg, joints)[1][:, j], (ahead - behind) / (2.0 * step), atol=1e-8
        )


@given(robots, legs, shares)
@settings(deadline=None)
def test_a_foot_below_its_hip_comes_back_to_its_place_by_the_same_angles(name, leg, share):
    joints = drawn(name, leg, share)
    place, _ = forward(name, leg, joints)
    robot = PARAMETERS[name]
    assume(-robot["thigh"] * np.cos(joints[1]) - robot["calf"] * np.cos(sum(joints[1:])) < -0.02)
    length = np.linalg.norm(place - chain(ROBOTS[name], leg, [joints[0], 0.0, 0.0])[1])
    assume(length > 0.01)
    again = inverse(name, leg, place)
    np.testing.assert_allclose(forward(name, leg, again)[0], place, atol=1e-9)
    np.testing.assert_allclose(again, joints, atol=1e-6)


@given(robots, legs, st.tuples(*[st.floats(-2.0, 2.0)] * 3))
@settings(deadline=None)
def test_joints_stay_in_their_ranges_wherever_a_foot_is_wanted(name, leg, place):
    joints = inverse(name, leg, place)
    low, high = ROBOTS[name].joint_range[3 * leg : 3 * leg + 3].T
    assert ((low <= joints) & (joints <= high)).all()


@pytest.mark.parametrize("leg", LEGS)
def test_a_leg_points_to_what_is_too_far(leg):
    robot = PARAMETERS["go1"]
    shoulder = robot["hip"][leg] + [0.0, robot["side"][leg], 0.0]
    far = np.array([0.35, 0.0, -1.0])
    place, _ = forward("go1", leg, inverse("go1", leg, shoulder + far))
    reached = place - shoulder
    # The calf cannot stretch all the way: its range ends before.
    most = np.linalg.norm(
        forward("go1", leg, [0.0, 0.0, robot["highest"][3 * leg + 2]])[0] - shoulder
    )
    assert np.linalg.norm(reached) == pytest.approx(most, abs=1e-9)
    assert reached @ far / np.linalg.norm(far) > 0.9 * most


@given(robots, legs, shares, st.floats(-3.0, 3.0), st.floats(-1.5, 1.5))
@settings(deadline=None)
def test_torques_of_a_legs_weight_are_the_slope_of_its_energy(name, leg, share, roll, pitch):
    joints, step = drawn(name, leg, share), 1e-6
    up = Rotation.from_euler("xy", [roll, pitch]).apply([0.0, 0.0, 1.0])
    masses = np.array([link.mass for link in ROBOTS[name].legs[leg].links])

    def energy(values):
        return GRAVITY * masses @ (chain(ROBOTS[name], leg, values)[0] @ up)

    found = np.empty(3)
    leg_weight(PARAMETERS[name], leg, joints, up, found)
    for j, unit in enumerate(np.eye(3)):
        slope = (energy(joints + step * unit) - energy(joints - step * unit)) / (2.0 * step)
        assert found[j] == pytest.approx(slope, abs=1e-7)


@pytest.mark.parametrize("leg", LEGS)
def test_a_leg_is_the_mirror_image_of_the_one_across(leg):
    across, joints = leg ^ 1, np.array([0.2, 0.9, -1.7])
    place, _ = forward("go2", leg, joints)
    other, _ = forward("go2", across, joints * [-1.0, 1.0, 1.0])
    np.testing.assert_allclose(other, place * [1.0, -1.0, 1.0], atol=1e-12)


@given(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0))
@settings(deadline=None)
def test_quaternions_matrices_and_angles_are_those_of_scipy(roll, pitch, yaw):
    turn = Rotation.from_euler("xyz", [roll, pitch, yaw])
    matrix = np.empty((3, 3))
    rotation(np.roll(turn.as_quat(), 1), matrix)
    np.testing.assert_allclose(matrix, turn.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(angles(matrix), [roll, pitch, yaw], atol=1e-9)


def test_small_products_are_those_of_numpy():
    rng = np.random.default_rng(0)
    for _ in range(20):
        matrix, a, b, out = rng.normal(size=(3, 3)), *rng.normal(size=(2, 3)), np.empty(3)
        cross(a, b, out)
        np.testing.assert_allclose(out, np.cross(a, b), atol=1e-14)
        turned(matrix, a, out)
        np.testing.assert_allclose(out, matrix @ a, atol=1e-14)
        turned_back(matrix, a, out)
        np.testing.assert_allclose(out, matrix.T @ a, atol=1e-14)
        solve3(matrix, a, out)
        np.testing.assert_allclose(out, np.linalg.solve(matrix, a), rtol=1e-9, atol=1e-12)


def test_a_stretched_leg_asks_for_no_endless_speed():
    """At the singular place the damped solution passes through zero; it is continuous."""
    sizes, right, out = np.logspace(-12, 0, 200), np.array([0.0, 0.0, 1.0]), np.empty(3)
    answers = []
    for size in sizes:
        solve3(np.diag([1.0, 1.0, size]), right, out)
        answers.append(out[2])
    assert max(answers) <= 1.0 / SINGULAR + 1e-9
    assert answers[0] < 1e-3
    exact = sizes > SINGULAR
    np.testing.assert_allclose(np.array(answers)[exact], 1.0 / sizes[exact])


@given(st.floats(-50.0, 50.0))
@settings(deadline=None)
def test_wrapped_angles_differ_by_whole_turns(angle):
    result = wrapped(angle)
    assert -math.pi <= result < math.pi
    turns = (angle - result) / (2.0 * math.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)
