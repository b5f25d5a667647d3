"""Forward kinematics and momentum against MuJoCo's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.checking.physics.kinematics import posture
from cavalcade.checking.physics.rotations import about, matrices, roll_pitch_yaw, turns
from cavalcade.robots import robot_model

from .conftest import GO1, still


def random_state(rng):
    """A trunk anywhere and joints within their range."""
    turn = rng.normal(size=4)
    low, high = GO1.joint_range.T
    return np.concatenate((rng.normal(size=3), turn / np.linalg.norm(turn), rng.uniform(low, high)))


def record_of(states, step):
    states = np.array(states)
    nothing = still().rates[: len(states)]
    return replace(
        still(),
        time=step * np.arange(len(states)),
        base=states[:, :7],
        joints=states[:, 7:],
        rates=nothing,
        torques=nothing,
        forces=np.zeros((len(states), 4, 3)),
    )


@pytest.fixture(scope="module")
def simulator():
    pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import TeamSimulator

    return TeamSimulator([robot_model("go1")], [(0.0, 0.0, 0.0)])


@pytest.mark.parametrize("seed", range(5))
def test_links_and_centre_of_mass(simulator, seed):
    import mujoco

    state = random_state(np.random.default_rng(seed))
    links = posture(record_of([state, state], 0.02), GO1)
    data, model, team = simulator.data, simulator.model, simulator.team
    data.qpos[team.qpos[0]] = state
    mujoco.mj_forward(model, data)
    joints = team.qvel[0, 6:]
    bodies = np.concatenate((team.trunks, model.dof_bodyid[joints]))
    np.testing.assert_allclose(links.place[0], data.xpos[bodies], atol=1e-9)
    np.testing.assert_allclose(links.turn[0].reshape(13, 9), data.xmat[bodies], atol=1e-9)
    np.testing.assert_allclose(links.center[0], data.subtree_com[team.trunks[0]], atol=1e-9)
    np.testing.assert_allclose(links.axes[0], data.xaxis[model.dof_jntid[joints]], atol=1e-9)
    assert links.weight == pytest.approx(float(model.body_mass[bodies].sum()))


@pytest.mark.parametrize("seed", range(3))
def test_momentum_and_spin(simulator, seed):
    """Differences over a short time are MuJoCo's momenta in its middle."""
    import mujoco

    rng = np.random.default_rng(seed)
    data, model, team = simulator.data, simulator.model, simulator.team
    middle, speed, step = random_state(rng), rng.normal(size=18), 1e-4
    states = []
    for sign in (-0.5, 0.5):
        moved = data.qpos.copy()
        moved[team.qpos[0]] = middle
        rate = np.zeros(model.nv)
        rate[team.qvel[0]] = speed
        mujoco.mj_integratePos(model, moved, rate, sign * step)
        states.append(moved[team.qpos[0]])
    links = posture(record_of(states, step), GO1)
    data.qpos[team.qpos[0]], data.qvel[team.qvel[0]] = middle, speed
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    trunk = team.trunks[0]
    np.testing.assert_allclose(links.velocity[0], data.subtree_linvel[trunk], atol=1e-5)
    np.testing.assert_allclose(links.spin[0], data.subtree_angmom[trunk], atol=1e-4)


def test_turns_add_up_to_what_was_turned():
    axis = np.array([0.36, 0.48, 0.8])
    angles = np.array([0.0, 0.1, 0.5, -0.4])
    vectors = turns(about(axis, angles))
    np.testing.assert_allclose(vectors, np.outer(np.diff(angles), axis), atol=1e-12)


def test_angles_of_a_turned_trunk():
    turn = about(np.array([0.0, 0.0, 1.0]), np.array(0.7)) @ about(
        np.array([0.0, 1.0, 0.0]), np.array(-0.3)
    )
    turn = turn @ about(np.array([1.0, 0.0, 0.0]), np.array(0.2))
    np.testing.assert_allclose(roll_pitch_yaw(turn), (0.2, -0.3, 0.7), atol=1e-12)


def test_quaternions_turn_as_they_say():
    half = 0.35
    turn = matrices(np.array([np.cos(half), 0.0, 0.0, np.sin(half)]))
    np.testing.assert_allclose(turn @ (1.0, 0.0, 0.0), (np.cos(0.7), np.sin(0.7), 0.0), atol=1e-12)
