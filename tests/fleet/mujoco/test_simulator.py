"""Laws of mechanics that hold for simulated robots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco import PhysicsSettings, TeamSimulator
from cavalcade.robots import robot_model

pytest.importorskip("mujoco")

GO1, GO2 = robot_model("go1"), robot_model("go2")
G = 9.81


def weight(simulator):
    return G * simulator.model.body_mass[1:].sum()


@pytest.mark.parametrize("name", ["go1", "go2"])
def test_feet_that_stand_carry_the_weight_and_hardly_sink(name, hold):
    model = robot_model(name)
    simulator = TeamSimulator([model], [(0.0, 0.0, 0.5)])
    hold(simulator, 1500)
    total = []
    hold(simulator, 250, lambda: total.append(simulator.foot_forces.sum()))
    assert np.mean(total) == pytest.approx(G * model.description.mass, rel=1e-3)
    assert (simulator.foot_forces > 0.1 * G * model.description.mass).all()
    assert simulator.data.contact.dist.min() > -0.002
    assert np.abs(simulator.qvel).max() < 1e-3


def test_forces_on_feet_are_in_the_order_of_legs(hold):
    # Pushed down and turned, a robot's weight goes to the side that is said.
    for moment, loaded in (((6.0, 0.0, 0.0), (1, 3)), ((0.0, 2.0, 0.0), (0, 1))):
        simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
        hold(simulator, 500)
        before = simulator.foot_forces[0]
        # About +x the right side goes down, about +y the nose.
        simulator.data.xfrc_applied[simulator.team.trunks[0], 3:] = moment
        hold(simulator, 500)
        gained = simulator.foot_forces[0] - before
        assert set(np.argsort(gained)[2:]) == set(loaded)


def test_robots_start_where_they_are_said_to_and_in_their_order():
    poses = np.array([[0.0, 0.0, 0.3], [2.0, -1.0, -2.0], [4.0, 1.0, 3.0]])
    simulator = TeamSimulator([GO1, GO2, GO1], poses)
    np.testing.assert_allclose(simulator.qpos[:, :2], poses[:, :2])
    np.testing.assert_allclose(2.0 * np.arctan2(*simulator.qpos[:, [6, 3]].T), poses[:, 2])
    heights = [robot.description.stand_height for robot in (GO1, GO2, GO1)]
    np.testing.assert_allclose(simulator.qpos[:, 2], heights)
    np.testing.assert_array_equal(simulator.qvel, 0.0)
    assert simulator.time == 0.0
    masses = [simulator.model.body_subtreemass[body] for body in simulator.team.trunks]
    np.testing.assert_allclose(masses, [m.description.mass for m in (GO1, GO2, GO1)])


def test_momentum_of_a_flying_robot_changes_by_its_weight_alone():
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    simulator.data.qpos[2] = 3.0
    torques = np.random.default_rng(1).uniform(-20.0, 20.0, (100, 1, 12))
    before = momentum(simulator)
    for torque in torques:
        simulator.step(torque)
    gained = momentum(simulator) - before
    impulse = -weight(simulator) * simulator.time
    np.testing.assert_allclose(gained, [0.0, 0.0, impulse], atol=0.02 * abs(impulse))


def momentum(simulator):
    """`(3,)` of the first robot."""
    import mujoco

    mujoco.mj_forward(simulator.model, simulator.data)
    mujoco.mj_subtreeVel(simulator.model, simulator.data)
    trunk = simulator.team.trunks[0]
    return simulator.model.body_subtreemass[trunk] * simulator.data.subtree_linvel[trunk]


def test_a_push_gives_its_impulse_and_ends():
    simulator = TeamSimulator([GO1, GO1], [(0.0, 0.0, 0.0), (5.0, 0.0, 0.0)])
    simulator.data.qpos[[2, 21]] = 3.0
    before = momentum(simulator)
    simulator.push(0, (50.0, -30.0, 0.0), 0.1)
    for _ in range(150):
        simulator.step(np.zeros((2, 12)))
    gained = momentum(simulator) - before
    np.testing.assert_allclose(gained[:2], [5.0, -3.0], atol=0.05)
    np.testing.assert_allclose(simulator.qvel[1, :2], 0.0, atol=0.02)
    assert not simulator.data.xfrc_applied.any()


@pytest.mark.parametrize("duration", [1e-5, 0.003, 0.0051])
def test_a_push_of_no_whole_number_of_steps_gives_its_impulse_too(duration):
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    simulator.data.qpos[2] = 3.0
    before = momentum(simulator)
    simulator.push(0, (5.0 / duration, 0.0, 0.0), duration)
    for _ in range(5):
        simulator.step(np.zeros((1, 12)))
    assert (momentum(simulator) - before)[0] == pytest.approx(5.0, abs=0.05)


def test_what_goes_wrong_in_physics_is_seen_and_leaves_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    assert simulator.trouble is None
    simulator.data.qvel[0] = np.inf
    simulator.step(np.zeros((1, 12)))
    assert simulator.trouble == "BADQVEL"
    assert not list(tmp_path.iterdir())


def test_torques_are_cut_to_the_limits():
    simulator = TeamSimulator([GO1, GO2], [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
    simulator.step(np.full((2, 12), 1e3))
    limits = [model.description.torque_limits for model in (GO1, GO2)]
    np.testing.assert_array_equal(simulator.torques, limits)
    simulator.step(np.full((2, 12), -1e3))
    np.testing.assert_array_equal(simulator.torques, -np.array(limits))
    applied = simulator.data.qfrc_actuator[simulator.team.qvel[:, 6:]]
    np.testing.assert_allclose(applied, -np.array(limits))


def test_torques_that_are_no_numbers_are_none():
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    simulator.step(np.full((1, 12), np.nan))
    np.testing.assert_array_equal(simulator.torques, 0.0)


@pytest.mark.parametrize(("rate", "share"), [(0.0, 1.0), (10.0, 1 - 10 / 30.1), (40.0, 0.0)])
def test_with_torque_speed_limits_a_fast_motor_has_little_left_to_drive(rate, share):
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)], None, PhysicsSettings(torque_speed=True))
    simulator.data.qpos[2] = 3.0
    simulator.data.qvel[6] = rate
    simulator.step(np.full((1, 12), 100.0))
    assert simulator.torques[0, 0] == pytest.approx(23.7 * share)
    simulator.data.qvel[6] = rate
    simulator.step(np.full((1, 12), -100.0))
    assert simulator.torques[0, 0] == pytest.approx(-23.7)


def test_heavier_robots_weigh_more(hold):
    settings = PhysicsSettings(mass_scale=(1.0, 1.2))
    simulator = TeamSimulator([GO1, GO1], [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)], None, settings)
    hold(simulator, 1500)
    first, second = simulator.foot_forces.sum(axis=1)
    assert second == pytest.approx(1.2 * first, rel=0.01)


@pytest.mark.parametrize(("friction", "slides"), [(0.8, False), (0.2, True)])
def test_a_pushed_robot_slides_when_the_force_is_beyond_friction(friction, slides, hold):
    settings = PhysicsSettings(friction=friction)
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)], None, settings)
    hold(simulator, 750)
    start = simulator.qpos[0, 1]
    simulator.push(0, (0.0, 40.0, 0.0), 0.5)
    hold(simulator, 500)
    assert (abs(simulator.qpos[0, 1] - start) > 0.1) == slides


def test_feet_of_a_standing_robot_do_not_creep(hold):
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    hold(simulator, 1000)
    places = feet(simulator)
    hold(simulator, 1000)
    np.testing.assert_allclose(feet(simulator), places, atol=5e-4)


def feet(simulator):
    team = simulator.team
    return simulator.data.geom_xpos[(team.geom_part == 4) & (team.geom_leg >= 0)].copy()


def test_robots_meet_each_other_but_not_themselves(hold):
    apart = TeamSimulator([GO1, GO1], [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
    folded = apart.qpos[:, 7:]
    folded[:, 2::3] = -2.8  # calves along the thighs
    hold(apart, 300, wanted=folded)
    pairs = {tuple(sorted(pair)) for pair in owners(apart)}
    assert pairs == {(-1, 0), (-1, 1)}
    near = TeamSimulator([GO1, GO1], [(0.0, 0.0, 0.0), (0.5, 0.05, 0.0)])
    near.step(np.zeros((2, 12)))
    assert (0, 1) in {tuple(sorted(pair)) for pair in owners(near)}


def owners(simulator):
    """`(C, 2)` robots, or -1, of the shapes of each contact."""
    return simulator.team.geom_robot[simulator.data.contact.geom]


def test_more_robots_than_there_are_bits(hold):
    poses = [(1.0 * (k % 6), 1.0 * (k // 6), 0.0) for k in range(33)]
    simulator = TeamSimulator([GO1] * 33, poses)
    hold(simulator, 5)
    assert simulator.qpos.shape == (33, 19)
    assert set(map(tuple, owners(simulator))) <= {(-1, k) for k in range(33)}


def test_the_same_start_and_torques_give_the_same_state_to_the_last_bit():
    def run(settings):
        simulator = TeamSimulator([GO1, GO1], [(0, 0, 0), (0.8, 0.1, 1.0)], None, settings)
        torques = np.random.default_rng(5).uniform(-15.0, 15.0, (300, 2, 12))
        for torque in torques:
            simulator.step(torque)
        return simulator.state_bytes()

    settings = PhysicsSettings(variation=0.05, seed=2)
    assert run(settings) == run(settings)
    assert run(settings) != run(replace(settings, seed=3))


def test_what_is_read_does_not_change_afterwards():
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    read = simulator.qpos, simulator.qvel, simulator.foot_forces, simulator.torques
    copies = [array.copy() for array in read]
    for _ in range(20):
        simulator.step(np.ones((1, 12)))
    for array, copy in zip(read, copies, strict=True):
        np.testing.assert_array_equal(array, copy)
        assert array.flags.c_contiguous
        assert array.shape[0] == 1


def test_shapes_for_drawing_change_nothing_but_what_is_seen():
    plain = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    drawn = TeamSimulator([GO1], [(0.0, 0.0, 0.0)], None, PhysicsSettings(looks=True))
    assert drawn.model.ngeom == plain.model.ngeom + len(GO1.description.looks)
    for simulator in (plain, drawn):
        for _ in range(50):
            simulator.step(np.ones((1, 12)))
    np.testing.assert_allclose(drawn.qpos, plain.qpos, atol=1e-12)


@pytest.mark.parametrize(
    ("models", "poses", "said"),
    [
        (["go1"], [(0.0, 0.0)], "shape"),
        (["go1"], [(0.0, 0.0, np.nan)], "finite"),
        (["go1", "go1"], [(0.0, 0.0, 0.0)], "shape"),
        ([], np.zeros((0, 3)), "one finite pose"),
        (["spirit"], [(0.0, 0.0, 0.0)], "spirit has no description"),
    ],
)
def test_what_cannot_be_simulated(models, poses, said):
    with pytest.raises(InputError, match=said):
        TeamSimulator([robot_model(name) for name in models], poses)


def test_calls_that_make_no_sense():
    simulator = TeamSimulator([GO1], [(0.0, 0.0, 0.0)])
    with pytest.raises(InputError, match="torques"):
        simulator.step(np.zeros(12))
    with pytest.raises(InputError, match="robot from 0 to 0"):
        simulator.push(1, (1.0, 0.0, 0.0), 0.1)
    with pytest.raises(InputError, match="force"):
        simulator.push(0, (1.0, 0.0), 0.1)
    with pytest.raises(InputError, match="duration"):
        simulator.push(0, (1.0, 0.0, 0.0), 0.0)
    with pytest.raises(InputError, match="0 movable"):
        simulator.place_obstacle(0, (0.0, 0.0))
