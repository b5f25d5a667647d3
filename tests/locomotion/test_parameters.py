"""The controller's parameters of a robot against MuJoCo's, and robots whose legs it cannot move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.locomotion.parameters import composite, robot_parameters
from cavalcade.robots import robot_model

GO1 = robot_model("go1").description


def changed(leg, joint=None, foot=None, **values):
    """Go1 with one leg's joint or foot otherwise."""
    parts = GO1.legs[leg]
    if joint is not None:
        joints = list(parts.joints)
        joints[joint] = replace(joints[joint], **values)
        parts = replace(parts, joints=tuple(joints))
    if foot is not None:
        parts = replace(parts, foot=foot)
    legs = list(GO1.legs)
    legs[leg] = parts
    return replace(GO1, legs=tuple(legs))


@pytest.mark.parametrize("name", ["go1", "go2"])
def test_a_locked_robot_weighs_what_mujoco_says(name):
    mujoco = pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import TeamSimulator

    simulator = TeamSimulator([robot_model(name)], [[0.0, 0.0, 0.0]])
    model, data, rng = simulator.model, simulator.data, np.random.default_rng(1)
    for _ in range(5):
        joints = rng.uniform(-1.0, 1.0, 12)
        data.qpos[:7], data.qpos[7:] = [0, 0, 0, 1, 0, 0, 0], joints
        mujoco.mj_forward(model, data)
        whole = composite(simulator.descriptions[0], joints)
        trunk = int(simulator.team.trunks[0])
        assert whole.mass == pytest.approx(model.body_subtreemass[trunk])
        np.testing.assert_allclose(whole.center, data.subtree_com[trunk], atol=1e-12)
        # Links' inertia about the whole's centre from MuJoCo's own frames.
        inertia = np.zeros((3, 3))
        for body in range(1, model.nbody):
            frame = data.ximat[body].reshape(3, 3)
            arm = data.xipos[body] - data.subtree_com[trunk]
            inertia += frame @ np.diag(model.body_inertia[body]) @ frame.T
            inertia += model.body_mass[body] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        np.testing.assert_allclose(whole.matrix, inertia, atol=1e-7)


def test_figures_are_those_of_the_description():
    row = robot_parameters(GO1)
    assert row["mass"] == pytest.approx(GO1.mass)
    assert row["mass"] == pytest.approx(row["trunk_mass"] + row["link_mass"].sum())
    assert (row["thigh"], row["calf"]) == (0.213, 0.213)
    np.testing.assert_allclose(row["side"], [0.08, -0.08, 0.08, -0.08])
    np.testing.assert_array_equal(row["torque"], GO1.torque_limits)


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        (changed(1, 0, axis=(0.0, 1.0, 0.0)), "hip joint of leg FR to turn about x"),
        (changed(2, 1, offset=(0.0, 0.08, -0.03)), "thigh of leg RL beside its hip"),
        (changed(0, 2, offset=(0.05, 0.0, -0.2)), "leg FL to hang straight down"),
        (changed(0, foot=(0.0, 0.0, 0.2)), "leg FL to hang straight down"),
        (changed(3, foot=(0.0, 0.0, -0.25)), "leg RR to be as long as FL"),
    ],
)
def test_legs_of_another_kind_are_refused(robot, words):
    with pytest.raises(InputError, match=words) as caught:
        robot_parameters(robot)
    assert caught.value.key == robot.name
    # Of a user's own MuJoCo model the file was not named.
    with pytest.raises(InputError, match=words) as caught:
        robot_parameters(replace(robot, file="mine.xml"))
    assert str(caught.value).startswith(f"mine.xml: {robot.name}: ")
