"""What is sound passes: robots that stand and shift, worked out by hand and simulated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.checking.physics.kinematics import posture
from cavalcade.robots import robot_model

from .conftest import GO1, GRAVITY, Recorder, carried, still, with_rates


def kinds(violations):
    return {violation.kind for violation in violations}


def shifted(record, sideways, lower):
    """The trunk moves over standing feet: legs follow, worked out by search."""
    time = record.time
    base = record.base.copy()
    base[:, 1] += sideways * (1.0 - np.cos(2.0 * np.pi * time / 3.0))
    base[:, 2] -= lower * (1.0 - np.cos(2.0 * np.pi * time / 3.0))
    feet = posture(record, GO1).feet[0]
    joints = record.joints.copy()
    for k in range(len(time)):
        joints[k] = joints[max(k - 1, 0)]
        for _ in range(20):
            joints[k] -= _newton(replace_one(record, base[k], joints[k]), feet)
    return with_rates(replace(record, base=base, joints=joints))


def replace_one(record, base, joints):
    return replace(record, time=record.time[:1], base=base[None], joints=joints[None])


def _newton(one, feet):
    """Changes of the joints that bring the feet of a single sample to where they should be."""
    links = posture(one, GO1)
    change = np.zeros(12)
    for leg in range(4):
        joints = slice(3 * leg, 3 * leg + 3)
        arms = links.feet[0, leg] - links.place[0, 1 + 3 * leg : 4 + 3 * leg]
        jacobian = np.cross(links.axes[0, joints], arms).T
        change[joints] = np.linalg.solve(jacobian, links.feet[0, leg] - feet[leg])
    return change


def test_a_standing_robot_passes(standing, verdict):
    assert verdict(standing) == []
    total = standing.forces.sum(axis=1)
    np.testing.assert_allclose(total[:, 2], GO1.mass * GRAVITY)


def test_a_robot_that_shifts_its_weight_passes(verdict):
    assert verdict(carried(shifted(still(), 0.015, 0.015))) == []


def test_two_robots_beside_each_other_pass(verdict):
    assert verdict(carried(still()), carried(still(robot=1, place=(0.0, 0.6)))) == []


def waved(simulator, seconds, size):
    """Records of a robot whose joints follow sines around standing."""
    recorder = Recorder(simulator)
    for _ in range(round(seconds / 0.002)):
        angles = GO1.standing.copy()
        swing = size * np.sin(2.0 * np.pi * simulator.time)
        angles[0::3] += 0.6 * swing
        angles[1::3] += swing
        angles[2::3] -= 1.6 * swing
        state, rates = simulator.qpos[0], simulator.qvel[0]
        recorder.step([60.0 * (angles - state[7:]) - 2.0 * rates[6:]])
    return recorder.records()


def test_a_simulated_robot_that_moves_on_the_spot_passes(verdict):
    pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import TeamSimulator

    simulator = TeamSimulator([robot_model("go1")], [(1.0, 2.0, 0.7)])
    (record,) = waved(simulator, 3.0, 0.25)
    assert verdict(record) == []


def test_a_push_counts_as_a_force_if_it_is_known(verdict):
    pytest.importorskip("mujoco")
    from cavalcade.checking.physics import Conditions, Push
    from cavalcade.fleet.mujoco import TeamSimulator

    simulator = TeamSimulator([robot_model("go1")], [(0.0, 0.0, 0.0)])
    simulator.push(0, (0.0, 0.0, 60.0), 2.0)
    (record,) = waved(simulator, 3.0, 0.0)
    assert kinds(verdict(record)) >= {"weight", "momentum"}
    push = Push(0, 0.0, 2.0, (0.0, 0.0, 60.0))
    assert verdict(record, conditions=Conditions(pushes=(push,))) == []


def test_a_robot_that_is_dragged_is_refused(verdict):
    """Its feet hold against a force of which nobody speaks."""
    pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import TeamSimulator

    simulator = TeamSimulator([robot_model("go1")], [(0.0, 0.0, 0.0)])
    simulator.push(0, (15.0, 0.0, 0.0), 3.0)
    (record,) = waved(simulator, 3.0, 0.1)
    assert {"momentum", "angular-momentum"} & kinds(verdict(record))


def test_a_heavier_robot_passes_if_masses_vary(verdict):
    from cavalcade.checking.physics import Conditions

    pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import PhysicsSettings, TeamSimulator

    settings = PhysicsSettings(mass_scale=1.05)
    (record,) = waved(TeamSimulator([robot_model("go1")], [(0, 0, 0)], settings=settings), 3.0, 0.2)
    assert verdict(record, conditions=Conditions(variation=0.06)) == []
    assert "weight" in kinds(verdict(record, conditions=Conditions(variation=0.01)))
    assert "weight" in kinds(verdict(record))
