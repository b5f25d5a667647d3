"""The contact recorder against MuJoCo's own account of contacts."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.fleet.mujoco import ContactRecorder, PhysicsGround, TeamSimulator
from cavalcade.recording.physics_track import ContactEvent
from cavalcade.robots import PARTS, robot_model
from cavalcade.world import OccupancyMap, Terrain

mujoco = pytest.importorskip("mujoco")

GO1 = robot_model("go1")


def forces_on_feet(simulator):
    """`(N, 4, 3)` of the last step, contact by contact."""
    total = np.zeros((simulator.size, 4, 3))
    wrench = np.zeros(6)
    team, data = simulator.team, simulator.data
    for number in range(data.ncon):
        mujoco.mj_contactForce(simulator.model, data, number, wrench)
        force = data.contact.frame[number].reshape(3, 3).T @ wrench[:3]
        for side, geom in enumerate(data.contact.geom[number]):
            if team.geom_robot[geom] >= 0 and PARTS[team.geom_part[geom]] == "foot":
                # The normal points from the first to the second: the force on the second.
                sign = 1.0 if side == 1 else -1.0
                total[team.geom_robot[geom], team.geom_leg[geom]] += sign * force
    return total


def touching(simulator):
    """Set of (robot, part, other) that touch now, without feet on the ground."""
    team, found = simulator.team, set()
    for pair in simulator.data.contact.geom:
        for mine, its in (pair, pair[::-1]):
            robot, part = team.geom_robot[mine], PARTS[team.geom_part[mine]]
            if robot < 0:
                continue
            if team.geom_robot[its] >= 0:
                other = f"robot {team.geom_robot[its]}"
            else:
                other = ("ground", "obstacle")[team.geom_part[its]]
            if (part, other) != ("foot", "ground"):
                found.add((int(robot), part, other))
    return found


def crowd():
    """Four robots that fall over each other, walls and rough ground."""
    random = np.random.default_rng(1)
    terrain = Terrain.from_heights(random.uniform(0.0, 0.05, (30, 30)), 0.1)
    poses = [(1.0, 1.0, 0.0), (1.45, 1.1, 1.0), (2.5, 2.5, 2.0), (0.45, 2.6, 0.0)]
    return TeamSimulator([GO1] * 4, poses, PhysicsGround.of_terrain(terrain))


def test_mean_forces_and_begins_are_those_of_every_single_contact():
    simulator = crowd()
    recorder = ContactRecorder(simulator)
    random = np.random.default_rng(2)
    sums, last, expected = np.zeros((4, 4, 3)), {}, []
    for step in range(1500):
        if step % 100 == 0:
            torques = random.uniform(-15.0, 15.0, (4, 12))
        simulator.step(torques)
        recorder.record()
        sums += forces_on_feet(simulator)
        now = recorder.touching(1)
        assert {(c.robot, c.part, c.other) for c in now} == touching(simulator)
        assert all(c.time == pytest.approx(simulator.time) for c in now)
        for touch in sorted(touching(simulator)):
            if step - last.get(touch, -1000) > 50:
                expected.append((simulator.time, *touch))
            last[touch] = step
        if (step + 1) % 10 == 0:
            np.testing.assert_allclose(recorder.take_forces(), sums / 10.0, atol=1e-9)
            sums[:] = 0.0
    found = [(c.time, c.robot, c.part, c.other) for c in recorder.contacts]
    assert sorted(found) == sorted(expected)
    assert {contact.part for contact in recorder.contacts} >= {"trunk", "thigh", "calf", "foot"}
    others = {contact.other for contact in recorder.contacts}
    assert others >= {"ground", "obstacle", "robot 0", "robot 1"}
    times = [contact.time for contact in recorder.contacts]
    assert times == sorted(times)


def test_a_standing_robot_is_carried_by_its_feet_and_nothing_else_touches(hold):
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 1.0)])
    hold(simulator, 750)
    recorder = ContactRecorder(simulator)
    hold(simulator, 250, recorder.record)
    total = recorder.take_forces().sum(axis=(0, 1))
    weight = 9.81 * GO1.description.mass
    np.testing.assert_allclose(total, [0.0, 0.0, weight], atol=2e-3 * weight)
    assert recorder.contacts == ()
    np.testing.assert_array_equal(recorder.take_forces(), 0.0)


def test_the_recorder_agrees_with_the_sensors_in_the_feet(hold):
    simulator = TeamSimulator([GO1, GO1], [(0.0, 0.0, 0.0), (2.0, 0.0, 1.0)])
    hold(simulator, 500)
    recorder = ContactRecorder(simulator)
    hold(simulator, 1, recorder.record)
    np.testing.assert_allclose(recorder.take_forces()[..., 2], simulator.foot_forces, rtol=1e-6)


def test_a_flying_robot_touches_nothing():
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    simulator.data.qpos[2] = 3.0
    recorder = ContactRecorder(simulator)
    for _ in range(50):
        simulator.step(np.zeros((1, 12)))
        recorder.record()
    np.testing.assert_array_equal(recorder.take_forces(), 0.0)
    assert recorder.contacts == ()


def test_a_single_contact_is_recorded_as_many_are():
    # Of one contact MuJoCo's arrays lie otherwise in memory.
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    simulator.data.qpos[2] = 0.35
    simulator.data.qpos[4] = simulator.data.qpos[5] = 0.15
    recorder = ContactRecorder(simulator)
    counts = set()
    for _ in range(200):
        simulator.step(np.zeros((1, 12)))
        recorder.record()
        counts.add(simulator.data.ncon)
        np.testing.assert_allclose(recorder.take_forces(), forces_on_feet(simulator), atol=1e-9)
    assert 1 in counts


def test_what_touches_again_soon_is_the_same_contact_and_later_a_new_one():
    simulator = TeamSimulator([GO1], [(1.0, 1.0, 0.0)], wall_ahead())
    recorder = ContactRecorder(simulator)

    def put(x, steps):
        for _ in range(steps):
            simulator.data.qpos[:3] = (x, 1.0, 0.35)
            simulator.data.qvel[:] = 0.0
            simulator.step(np.zeros((1, 12)))
            recorder.record()

    put(1.5, 5)
    put(1.75, 5)
    first = recorder.contacts
    assert first == (ContactEvent(pytest.approx(0.012), 0, "trunk", "obstacle"),)
    put(1.5, 45)
    put(1.75, 5)
    assert recorder.contacts == first
    put(1.5, 60)
    put(1.75, 5)
    assert len(recorder.contacts) == 2


def wall_ahead():
    grid = np.zeros((40, 40), bool)
    grid[:, 20:] = True
    return PhysicsGround.of_map(OccupancyMap(grid, 0.1))
