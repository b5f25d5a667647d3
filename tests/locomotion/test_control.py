"""Robots under leg control in physics: how well they obey, and laws of how they move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.lattice.ground import make_ground
from cavalcade.locomotion.control import LegControl
from cavalcade.locomotion.records import LYING, SINKING, STANDING, TROTTING
from cavalcade.locomotion.settings import GaitSettings
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap
from cavalcade.world.terrain import Terrain

GO1 = robot_model("go1")
STILL = (0.0, 0.0, 0.0)
WEIGHT = GO1.description.mass * 9.81


def smoothed(values):
    """Means over one cycle of the gait."""
    n = round(GaitSettings().period / 0.002)
    return np.convolve(values, np.full(n, 1.0 / n), "valid")


def turn(yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])


def on(height, cell=0.02):
    """Ground of a height field for physics and for leg control."""
    from cavalcade.fleet.mujoco import PhysicsGround

    terrain = Terrain.from_heights(height, cell)
    free = OccupancyMap(np.zeros(height.shape, bool), cell, terrain.origin)
    return {"ground": PhysicsGround.of_terrain(terrain), "footing": make_ground(free, terrain)}


@pytest.mark.parametrize("name", ["go1", "go2"])
@pytest.mark.parametrize(
    ("command", "share", "rms"),
    [((0.5, 0.0, 0.0), 0.03, 0.04), ((-0.4, 0.0, 0.0), 0.03, 0.04), ((0.0, 0.2, 0.0), 0.1, 0.04),
     ((0.0, 0.0, 1.0), 0.1, 0.1), ((0.8, 0.0, 0.0), 0.03, 0.08)],
)  # fmt: skip
def test_steady_velocities_are_those_commanded(walkers, name, command, share, rms):
    robots = walkers(name)
    robots.drive(command, 2.0)
    pose, velocity = robots.motion(command, 12 * GaitSettings().period)
    mean, wanted = velocity.mean(axis=0), np.array(command)
    mean[2] = (pose[-1, 2] - pose[0, 2]) / (len(pose) - 1) / 0.002
    axis = int(np.argmax(np.abs(wanted)))
    assert mean[axis] == pytest.approx(wanted[axis], rel=share)
    np.testing.assert_allclose(np.delete(mean, axis), 0.0, atol=0.02)
    assert np.sqrt(((velocity[:, axis] - wanted[axis]) ** 2).mean()) < rms


def test_a_standing_robot_stays_and_its_feet_carry_its_weight(walkers):
    robots = walkers()
    robots.drive(STILL, 1.0)
    before, carried = robots.simulator.qpos, []
    robots.drive(STILL, 2.0, lambda: carried.append(robots.simulator.foot_forces[0]))
    assert np.mean(carried, axis=0).sum() == pytest.approx(WEIGHT, rel=0.005)
    assert np.mean(carried, axis=0).min() > 0.2 * WEIGHT
    np.testing.assert_allclose(robots.simulator.qpos[0, :7], before[0, :7], atol=2e-3)
    assert robots.simulator.qpos[0, 2] == pytest.approx(GO1.description.stand_height, abs=2e-3)
    assert robots.control.modes.tolist() == [STANDING]


def test_walking_feet_carry_the_weight_on_average(walkers):
    robots, carried = walkers(), []
    robots.drive((0.4, 0.0, 0.3), 1.0)
    robots.drive(
        (0.4, 0.0, 0.3),
        5 * GaitSettings().period,
        lambda: carried.append(robots.simulator.foot_forces[0]),
    )
    assert np.mean(carried, axis=0).sum() == pytest.approx(WEIGHT, rel=0.03)


@pytest.mark.parametrize("pose", [(2.0, -1.0, 0.0), (0.0, 0.0, 2.0), (-30.0, 40.0, -0.7)])
def test_a_walk_does_not_depend_on_where_in_the_world_it_is(walkers, pose):
    command = (0.5, 0.1, 0.4)
    here, _ = walkers().motion(command, 2.0)
    there, _ = walkers(poses=[pose]).motion(command, 2.0)
    np.testing.assert_allclose(there[:, :2], pose[:2] + here[:, :2] @ turn(pose[2]).T, atol=1e-4)
    np.testing.assert_allclose(there[:, 2], pose[2] + here[:, 2], atol=1e-4)


def test_a_mirrored_command_gives_a_mirrored_walk(walkers):
    """Nearly: one pair of feet is the first, and Go1 carries some things on one side."""
    command, mirror = np.array([0.4, 0.15, 0.5]), np.array([1.0, -1.0, -1.0])
    one, _ = walkers().motion(command, 4.0)
    other, _ = walkers().motion(command * mirror, 4.0)
    assert one[-1, 2] > 1.5
    np.testing.assert_allclose(other[-1] * mirror, one[-1], atol=0.03)


def test_the_same_commands_give_the_same_run_to_the_last_bit(walkers):
    runs = []
    for _ in range(2):
        robots = walkers("go1", "go2")
        robots.drive([[0.5, 0.0, 0.2], [0.2, 0.1, -0.3]], 1.0)
        robots.simulator.push(0, (100.0, 50.0, 0.0), 0.1)
        robots.drive(STILL, 1.0)
        runs.append(robots.simulator.state_bytes())
    assert runs[0] == runs[1]


def test_robots_of_a_team_walk_as_each_would_alone(walkers):
    command = (0.4, 0.1, 0.3)
    alone, _ = walkers().motion(command, 1.5)
    robots = walkers("go1", "go1", "go1")
    beside, _ = robots.motion(np.array([STILL, STILL, command]), 1.5, robot=2)
    np.testing.assert_allclose(beside - [0.0, 3.0, 0.0], alone, atol=1e-4)


@pytest.mark.parametrize("goal", [0.8, -0.3])
def test_speeds_are_approached_as_fast_as_the_settings_say(walkers, goal):
    gait = GaitSettings()
    robots = walkers()
    robots.drive((0.3, 0.0, 0.0), 2.0)
    _, velocity = robots.motion((goal, 0.0, 0.0), 2.0)
    times = 0.002 * np.arange(len(velocity))
    change = np.clip(gait.acceleration * times, 0.0, abs(goal - 0.3)) * np.sign(goal - 0.3)
    off = smoothed(velocity[:, 0] - 0.3 - change)
    assert np.abs(off).max() < 0.06
    assert np.abs(off[-200:]).max() < 0.02


def test_a_robot_stops_when_commands_fall_silent(walkers):
    robots = walkers()
    robots.drive((0.5, 0.0, 0.0), 2.0)
    pose, velocity = robots.motion(None, 2.5)
    speed = smoothed(velocity[:, 0])
    # Since the last command, which is 0.05 s old; at the middle of each mean.
    times = 0.05 + GaitSettings().period / 2 + 0.002 * np.arange(len(speed))
    np.testing.assert_allclose(speed[times < 0.45], 0.5, atol=0.03)
    assert np.abs(speed[times > 0.5 + 0.5 + 0.3]).max() < 0.03
    assert robots.control.modes.tolist() == [STANDING]
    # On with 0.5 m/s until 0.5 s after the last command, then 0.5² / 2 m.
    assert pose[-1, 0] - pose[0, 0] == pytest.approx(0.5 * 0.45 + 0.125, abs=0.03)


@pytest.mark.parametrize("command", [(0.015, 0.0, 0.0), (0.0, -0.015, 0.03)])
def test_next_to_no_command_leaves_a_robot_standing_upright(walkers, command):
    robots = walkers()
    robots.drive(command, 6.0)
    assert robots.control.modes.tolist() == [STANDING]
    np.testing.assert_allclose(robots.simulator.qpos[0, :2], 0.0, atol=5e-3)
    assert robots.simulator.foot_forces[0].min() > 0.2 * WEIGHT


@pytest.mark.parametrize("command", [STILL, (0.5, 0.0, 0.0)])
@pytest.mark.parametrize("direction", np.arange(4) * np.pi / 2 + 0.3)
def test_a_push_of_25_newton_seconds_is_survived(walkers, command, direction):
    robots = walkers()
    robots.drive(command, 1.1)
    robots.simulator.push(0, 250.0 * np.array([np.cos(direction), np.sin(direction), 0.0]), 0.1)
    seen = set()
    robots.drive(command, 3.0, lambda: seen.add(int(robots.control.modes[0])))
    assert not robots.control.fallen.any()
    assert TROTTING in seen  # one that stood has stepped
    assert robots.simulator.qpos[0, 2] == pytest.approx(GO1.description.stand_height, abs=0.02)
    assert robots.control.modes.tolist() == [STANDING if command == STILL else TROTTING]


def test_a_robot_that_falls_goes_limp_and_the_others_walk_on(walkers):
    robots = walkers("go1", "go1")
    command = (0.4, 0.0, 0.0)
    robots.drive(command, 1.0)
    robots.simulator.push(0, (0.0, -900.0, 0.0), 0.15)
    robots.drive(command, 2.0)
    assert robots.control.fallen.tolist() == [True, False]
    rates = robots.simulator.qvel[0, 6:]
    robots.step()
    np.testing.assert_allclose(robots.torques[0], -rates)
    robots.drive(command, 1.0)
    assert robots.control.fallen.tolist() == [True, False]
    assert robots.simulator.qpos[1, 0] > 1.2
    robots.control.begin(robots.simulator.time, robots.simulator.qpos)
    assert not robots.control.fallen.any()


def test_robots_lie_down_and_get_up_again(walkers):
    robots = walkers()
    robots.drive(STILL, 0.5)
    robots.control.lie_down(0, robots.simulator.qpos)
    assert robots.control.modes.tolist() == [SINKING]
    robots.drive((0.5, 0.0, 0.0), 1.5)
    assert robots.control.modes.tolist() == [LYING]
    assert robots.simulator.qpos[0, 2] < 0.12
    assert abs(robots.simulator.qpos[0, 0]) < 0.05
    robots.control.rise(0, robots.simulator.qpos)
    robots.drive(STILL, 1.5)
    assert robots.control.modes.tolist() == [STANDING]
    assert robots.simulator.qpos[0, 2] == pytest.approx(GO1.description.stand_height, abs=5e-3)
    before = robots.simulator.qpos[0, 0]
    robots.drive((0.4, 0.0, 0.0), 2.0)
    assert robots.simulator.qpos[0, 0] - before > 0.6


def test_torques_stay_within_the_motors_limits(walkers):
    robots, rng, largest = walkers("go1", "go2"), np.random.default_rng(0), []
    for _ in range(8):
        wild = rng.uniform(-1.0, 1.0, (2, 3)) * [1.5, 0.8, 3.0]
        robots.drive(wild, 0.5, lambda: largest.append(np.abs(robots.torques)))
    limits = [robot.torque_limits for robot in robots.simulator.descriptions]
    assert (np.max(largest, axis=0) <= limits).all()
    assert np.max(largest, axis=0).max() > 15.0


def test_feet_swing_in_their_half_of_the_cycle_and_stand_in_the_other(walkers):
    """By the forces on them alone, from when the trot begins."""
    robots, forces = walkers(), []
    robots.drive(STILL, 0.5)
    robots.drive(
        (0.3, 0.0, 0.2),
        10 * GaitSettings().period,
        lambda: forces.append(robots.simulator.foot_forces[0]),
    )
    phases = 0.002 * np.arange(len(forces)) / GaitSettings().period
    for leg, offset in enumerate((0.0, 0.5, 0.5, 0.0)):
        share = (phases + offset) % 1.0 / (1.0 - GaitSettings().duty)
        loads = np.array(forces)[:, leg]
        later = phases > 1.0
        assert loads[later & (share > 0.1) & (share < 0.85)].max() == 0.0
        assert loads[later & (share > 1.2) & (share < 1.9)].min() > 5.0


def test_feet_are_set_on_ground_that_carries(walkers):
    """Stripes without traversability are stepped over; who does not know of them treads on them."""
    shape, cell = (150, 300), 0.02
    stripes = np.ones(shape)
    stripes[:, np.arange(300) % 10 < 4] = 0.0  # 8 cm in 20
    treads = {}
    for known in (True, False):
        options = on(np.zeros(shape), cell)
        ground = options["footing"]
        if known:
            ground = ground._replace(traversability=stripes)
        robots = walkers(poses=[(0.8, 1.5, 0.1)], ground=options["ground"], footing=ground)
        robots.drive((0.5, 0.0, 0.0), 1.0)
        places = []
        robots.drive((0.5, 0.0, 0.0), 4.0, lambda r=robots, p=places: p.append(r.control.feet[0]))
        feet = np.unique(np.array(places).reshape(-1, 3), axis=0)
        # Feet come down a few millimetres from where they should: only what is well inside counts.
        depth = np.minimum(feet[:, 0] % 0.2, 0.08 - feet[:, 0] % 0.2)
        treads[known] = (depth > 0.015).mean()
        assert len(feet) > 30
        assert not robots.control.fallen.any()
    assert treads[True] == 0.0
    assert treads[False] > 0.1


def test_robots_that_start_on_high_ground_do_not_sink(walkers):
    robots = walkers(poses=[(1.0, 1.0, 0.0)], **on(np.full((100, 150), 0.4)))
    heights = []
    robots.drive(STILL, 0.5, lambda: heights.append(robots.simulator.qpos[0, 2] - 0.4))
    assert min(heights) > GO1.description.stand_height - 5e-3


@pytest.mark.parametrize("speed", [0.4, -0.4])
def test_robots_keep_their_height_and_lean_with_a_slope(walkers, speed):
    slope, cell = 0.25, 0.02
    x = (np.arange(300) + 0.5) * cell
    robots = walkers(poses=[(2.0 if speed > 0.0 else 4.5, 1.0, 0.0)],
                     **on(np.tile(slope * x, (100, 1))))  # fmt: skip
    robots.drive((speed, 0.0, 0.0), 2.0)
    seen = []
    robots.drive((speed, 0.0, 0.0), 3.0, lambda: seen.append(robots.simulator.qpos[0, :7]))
    x, z = np.array(seen)[:, [0, 2]].T
    assert (x[-1] - x[0]) / 3.0 == pytest.approx(speed, rel=0.03)
    assert np.mean(z - slope * x) == pytest.approx(GO1.description.stand_height, abs=6e-3)
    pitch = 2.0 * (np.array(seen)[:, 3] * np.array(seen)[:, 5])
    assert np.mean(np.arcsin(pitch)) == pytest.approx(-np.arctan(slope), abs=0.05)


@pytest.mark.parametrize("height", [0.05, -0.015])
def test_steps_that_legs_do_not_know_of_are_walked_over(walkers, height):
    """Higher ground is met early, which costs nothing; lower ground late, which does."""
    x, low, high = (np.arange(250) + 0.5) * 0.02, min(height, 0.0), max(height, 0.0)
    ground = on(np.tile(np.where(x > 1.5, high, -low), (100, 1)))["ground"]
    known = on(np.full((100, 250), -low))["footing"]
    robots = walkers(poses=[(0.8, 1.0, 0.0)], ground=ground, footing=known)
    robots.drive((0.4, 0.0, 0.0), 4.0)
    assert not robots.control.fallen.any()
    assert robots.simulator.qpos[0, 0] > 2.1
    assert robots.simulator.qpos[0, 2] - high == pytest.approx(0.28, abs=0.03)


@pytest.mark.parametrize(("share", "stands"), [(0.3, False), (0.55, False), (0.7, True)])
def test_a_foot_that_touches_early_stands_only_late_in_its_swing(share, stands):
    """It then pushes: torques of a standing leg instead of a swinging one's."""
    control, gait = LegControl([GO1]), GaitSettings()
    height = GO1.description.stand_height
    qpos = np.concatenate([[0.0, 0.0, height, 1.0, 0.0, 0.0, 0.0], GO1.description.standing])[None]
    still, loaded = np.zeros((1, 18)), np.full((1, 4), WEIGHT / 4)
    control.begin(0.0, qpos)
    control.step(0.0, qpos, still, loaded)  # stands from here on
    control.command([[0.3, 0.0, 0.0]], 0.0)
    swing = (1.0 - gait.duty) * gait.period
    end = 0.002 + share * swing
    air = loaded * [0.0, 1.0, 1.0, 0.0]
    for time in np.arange(0.002, end, 0.002):
        control.step(time, qpos, still, air)
    before = control.feet[0, 0].copy()
    moved = qpos + [0.03, *[0.0] * 18]  # the trunk and so all feet are ahead
    control.step(end, moved, still, loaded)
    assert (control.feet[0, 0] != before).any() == stands


def test_commands_and_states_of_the_wrong_kind_are_refused():
    control = LegControl([GO1])
    qpos, qvel, feet = np.zeros((1, 19)), np.zeros((1, 18)), np.zeros((1, 4))
    qpos[:, 3] = 1.0
    control.begin(0.0, qpos)
    for bad in ([0.1, 0.0, 0.0], [[0.1, 0.0]], [[np.nan, 0.0, 0.0]]):
        with pytest.raises(InputError, match=r"shape \(1, 3\)"):
            control.command(bad, 0.0)
    for states in ((qpos[:, :18], qvel, feet), (qpos, qpos, feet), (qpos[0], qvel[0], feet[0])):
        with pytest.raises(InputError, match="expected qpos, qvel, feet of shapes"):
            control.step(0.0, *states)
    for robot, move in ((1, control.rise), (-1, control.lie_down)):
        with pytest.raises(InputError, match="robot: expected a robot from 0 to 0"):
            move(robot, qpos)
    with pytest.raises(InputError, match="does not lie"):
        control.rise(0, qpos)
    with pytest.raises(InputError, match="must stand before it lies down"):
        control.lie_down(0, qpos)


def test_robots_and_grounds_of_the_wrong_kind_are_refused():
    with pytest.raises(InputError, match="no description of the legs of spirit"):
        LegControl([robot_model("spirit")])
    with pytest.raises(InputError, match="origin: expected finite x, y, yaw"):
        LegControl([GO1], origin=(0.0, 0.0))
    crooked = replace(GO1.description.legs[0], foot=(0.1, 0.0, -0.2))
    legs = (crooked, *GO1.description.legs[1:])
    with pytest.raises(InputError, match="leg FL to hang straight down"):
        LegControl([replace(GO1, description=replace(GO1.description, legs=legs))])
