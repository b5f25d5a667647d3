"""What the controller sees of a body against MuJoCo's own kinematics and torques."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cavalcade.locomotion._joints import add_leg_weight, stance_torques
from cavalcade.locomotion._kinematics import measure_body
from cavalcade.locomotion.parameters import composite, robot_parameters
from cavalcade.locomotion.records import BODY, Measured
from cavalcade.robots import robot_model

LEGS = ("FL", "FR", "RL", "RR")


def drawn(seed, robot):
    """A state `qpos, qvel` anywhere, joints within their ranges."""
    rng = np.random.default_rng(seed)
    low, high = robot.joint_range.T
    turn = Rotation.from_euler("xyz", rng.uniform([-0.6, -0.6, -3.0], [0.6, 0.6, 3.0]))
    joints = rng.uniform(low, high)
    qpos = np.concatenate([rng.uniform(-2.0, 2.0, 3), np.roll(turn.as_quat(), 1), joints])
    return qpos, rng.normal(size=18)


def measured(qpos, qvel):
    return Measured(0.0, qpos, qvel, np.zeros(4))


def seen(parameters, qpos, qvel):
    body = np.zeros(1, BODY)[0]
    measure_body(parameters, measured(qpos, qvel), body)
    return body


def pushing(parameters, forces, qpos, qvel):
    """Torques `(12,)` of legs that the ground pushes with `forces` `(4, 3)`."""
    body, torques = seen(parameters, qpos, qvel), np.zeros(12)
    for leg in range(4):
        stance_torques(parameters, body, leg, forces[leg], measured(qpos, qvel), torques)
    return torques


def rates_of(body, qvel):
    """Velocities `(4, 3)` of the feet in the world: with still joints, and the joints' part."""
    own = np.einsum("lij,lj->li", body["jacobian"], qvel[6:].reshape(4, 3))
    return body["carried"] + own @ body["matrix"].T


@pytest.fixture(scope="module", params=["go1", "go2"])
def robot(request):
    """MuJoCo's modules, its simulator of one robot, and the controller's parameters of it."""
    mujoco = pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import TeamSimulator

    simulator = TeamSimulator([robot_model(request.param)], [[0.0, 0.0, 0.0]])
    return mujoco, simulator, robot_parameters(simulator.descriptions[0])[()]


@pytest.mark.parametrize("seed", range(5))
def test_feet_and_their_velocities_are_those_of_mujoco(robot, seed):
    mujoco, simulator, parameters = robot
    model, data = simulator.model, simulator.data
    qpos, qvel = drawn(seed, simulator.descriptions[0])
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)
    body = seen(parameters, qpos, qvel)
    twist, rates = np.empty(6), rates_of(body, qvel)
    for leg, name in enumerate(LEGS):
        foot = model.geom(f"robot_0/{name}_foot").id
        np.testing.assert_allclose(body["foot"][leg], data.geom_xpos[foot], atol=1e-10)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_GEOM, foot, twist, 0)
        np.testing.assert_allclose(rates[leg], twist[3:], atol=1e-9)
    np.testing.assert_allclose(body["spin"], body["matrix"] @ qvel[3:6], atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_the_torques_of_the_legs_weight_are_those_of_mujoco(robot, seed):
    mujoco, simulator, parameters = robot
    qpos, _ = drawn(seed, simulator.descriptions[0])
    data = simulator.data
    data.qpos[:], data.qvel[:] = qpos, 0.0
    mujoco.mj_forward(simulator.model, data)
    body, torques = seen(parameters, qpos, np.zeros(18)), np.zeros(12)
    for leg in range(4):
        add_leg_weight(parameters, body, leg, measured(qpos, np.zeros(18)), torques)
    np.testing.assert_allclose(torques, data.qfrc_bias[6:], atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_pushed_feet_let_joints_rest_in_mujoco(robot, seed):
    """With the foot's force applied to it, stance torques leave nothing to move the joints."""
    mujoco, simulator, parameters = robot
    model, data = simulator.model, simulator.data
    qpos, _ = drawn(seed, simulator.descriptions[0])
    data.qpos[:], data.qvel[:] = qpos, 0.0
    mujoco.mj_forward(model, data)
    body = seen(parameters, qpos, np.zeros(18))
    forces = np.random.default_rng(seed).normal(0.0, 50.0, (4, 3))
    torques, felt = pushing(parameters, forces, qpos, np.zeros(18)), np.zeros(model.nv)
    for leg, name in enumerate(LEGS):
        calf = model.body(f"robot_0/{name}_calf").id
        mujoco.mj_applyFT(model, data, forces[leg], np.zeros(3), body["foot"][leg], calf, felt)
    np.testing.assert_allclose((torques + felt[6:] - data.qfrc_bias[6:]), 0.0, atol=1e-8)


def test_pushing_joints_make_up_for_their_losses():
    go1 = robot_model("go1").description
    parameters = robot_parameters(go1)[()]
    qpos, _ = drawn(0, go1)
    still, turning = np.zeros(18), np.zeros(18)
    turning[6:] = 3.0
    without = pushing(parameters, np.zeros((4, 3)), qpos, still)
    torques = pushing(parameters, np.zeros((4, 3)), qpos, turning)
    losses = parameters["damping"] * 3.0 + parameters["friction"]
    np.testing.assert_allclose(torques - without, losses, atol=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_velocities_are_derivatives_of_places(seed):
    go1 = robot_model("go1").description
    parameters = robot_parameters(go1)[()]
    qpos, qvel = drawn(seed, go1)
    half, ends = 5e-7, []
    for time in (-half, half):
        moved = qpos + 0.0
        moved[:3] += time * qvel[:3]
        turn = Rotation.from_quat(np.roll(qpos[3:7], -1)) * Rotation.from_rotvec(time * qvel[3:6])
        moved[3:7] = np.roll(turn.as_quat(), 1)
        moved[7:] += time * qvel[6:]
        ends.append(seen(parameters, moved, qvel))
    body = seen(parameters, qpos, qvel)
    feet = (ends[1]["foot"] - ends[0]["foot"]) / (2.0 * half)
    np.testing.assert_allclose(rates_of(body, qvel), feet, atol=1e-7)
    centre = (ends[1]["centre"] - ends[0]["centre"]) / (2.0 * half)
    np.testing.assert_allclose(body["velocity"], centre, atol=1e-7)


def test_the_centre_of_mass_is_that_of_the_standing_robot():
    go1 = robot_model("go1").description
    qpos = np.concatenate([[1.0, 2.0, 0.3, 1.0, 0.0, 0.0, 0.0], go1.standing])
    body = seen(robot_parameters(go1)[()], qpos, np.zeros(18))
    np.testing.assert_allclose(
        body["centre"], [1.0, 2.0, 0.3] + np.array(composite(go1, go1.standing).center)
    )
    below = body["foot"][:, 2] - (0.3 - go1.stand_height + go1.foot_radius)
    np.testing.assert_allclose(below, 0.0, atol=1e-9)
