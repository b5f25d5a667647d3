"""Robots that walk, behind the interface of every fleet."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.fleet import CommandDelay, FallingFleet, Fleet, LocalisationNoise
from cavalcade.fleet.mujoco import PhysicsGround, PhysicsSettings
from cavalcade.fleet.mujoco.fleet import MujocoFleet
from cavalcade.fleet.mujoco.ground import blocks_of_shape, movable_spans
from cavalcade.fleet.mujoco.sensing import SensingErrors
from cavalcade.robots import robot_model
from cavalcade.scenario import Obstacle, ObstacleSpan, World
from cavalcade.world import Circle, OccupancyMap

pytest.importorskip("mujoco")

GO1 = robot_model("go1")
DT = 0.05
FORWARDS = (0.4, 0.0, 0.0)


def fleet_of(*poses: tuple[float, float, float], **options: Any) -> MujocoFleet:
    return MujocoFleet([GO1] * len(poses), poses, **options)


def drive(fleet: Fleet, command: Any, seconds: float) -> np.ndarray:
    """Poses `(K, N, 3)` under a command repeated for all robots; None commands nothing."""
    poses = []
    for _ in range(round(seconds / DT)):
        if command is not None:
            fleet.send(np.tile(np.array(command, dtype=float), (fleet.size, 1)))
        fleet.advance(DT)
        poses.append(fleet.true_poses())
    return np.array(poses)


def test_it_is_a_fleet_whose_robots_can_fall() -> None:
    fleet: Fleet = fleet_of((0.0, 0.0, 0.0))
    assert isinstance(fleet, FallingFleet)


def test_robots_stand_where_they_were_put() -> None:
    start = np.array([(1.0, 2.0, 0.5), (3.0, 4.0, -2.5)])
    fleet = fleet_of(*start)
    assert fleet.true_poses() == pytest.approx(start, abs=1e-9)
    drive(fleet, None, 1.0)
    assert fleet.true_poses() == pytest.approx(start, abs=0.01)
    assert np.abs(fleet.true_velocities()).max() < 0.01
    observation = fleet.observe()
    assert observation.poses == pytest.approx(fleet.true_poses(), abs=1e-12)
    assert observation.stamps == pytest.approx([1.0, 1.0])
    assert fleet.falls == ()


@pytest.mark.parametrize("command", [(0.4, 0.0, 0.0), (0.0, 0.2, 0.0), (0.2, 0.0, 0.6)])
def test_commands_are_followed_in_the_body_s_frame(command: tuple[float, ...]) -> None:
    fleet = fleet_of((0.0, 0.0, 1.0))
    drive(fleet, command, 2.0)
    before = fleet.true_poses()[0]
    track = drive(fleet, command, 2.0)[:, 0]
    track[:, 2] = np.unwrap(np.append(before[2], track[:, 2]))[1:]
    assert (track[-1, 2] - before[2]) / 2.0 == pytest.approx(command[2], abs=0.1)
    steps = np.diff(np.vstack([before, track]), axis=0)
    middle = track[:, 2] - 0.5 * steps[:, 2]
    along = np.cos(middle) * steps[:, 0] + np.sin(middle) * steps[:, 1]
    across = np.cos(middle) * steps[:, 1] - np.sin(middle) * steps[:, 0]
    assert along.sum() / 2.0 == pytest.approx(command[0], abs=0.05)
    assert across.sum() / 2.0 == pytest.approx(command[1], abs=0.05)


def test_true_velocities_are_those_of_the_poses() -> None:
    fleet = fleet_of((0.0, 0.0, 0.7))
    drive(fleet, (0.3, 0.1, 0.4), 1.0)
    before, speed = fleet.true_poses()[0], fleet.true_velocities()[0]
    fleet.advance(0.002)
    change = (fleet.true_poses()[0] - before) / 0.002
    assert change == pytest.approx(0.5 * (speed + fleet.true_velocities()[0]), abs=0.05)


def test_without_commands_a_robot_stops_after_half_a_second() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0))
    drive(fleet, FORWARDS, 2.0)
    drive(fleet, None, 0.4)
    assert fleet.true_velocities()[0, 0] == pytest.approx(0.4, abs=0.1)
    drive(fleet, None, 2.0)
    assert np.abs(fleet.true_velocities()).max() < 0.05


def test_a_silent_robot_stops_and_is_not_heard_of_until_revived() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    drive(fleet, FORWARDS, 1.0)
    known = fleet.observe().poses[0]
    fleet.silence(0)
    track = drive(fleet, FORWARDS, 2.0)
    observation = fleet.observe()
    assert np.array_equal(observation.poses[0], known)
    assert observation.stamps == pytest.approx([1.0, 3.0])
    assert track[-1, 0, 0] - known[0] < 0.3
    assert track[-1, 1, 0] - track[0, 1, 0] > 0.6
    fleet.revive(0)
    assert drive(fleet, FORWARDS, 1.0)[-1, 0, 0] - track[-1, 0, 0] > 0.1
    assert fleet.observe().stamps[0] == pytest.approx(4.0)


def test_a_disabled_robot_stops_but_is_seen() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0))
    drive(fleet, FORWARDS, 1.0)
    fleet.disable(0)
    drive(fleet, FORWARDS, 2.0)
    assert np.abs(fleet.true_velocities()[0]).max() < 0.05
    assert fleet.observe().stamps[0] == pytest.approx(3.0)
    assert fleet.observe().poses == pytest.approx(fleet.true_poses(), abs=1e-12)
    fleet.enable(0)
    drive(fleet, FORWARDS, 1.0)
    assert fleet.true_velocities()[0, 0] > 0.25


def test_a_delay_holds_commands_back() -> None:
    prompt, late = fleet_of((0.0, 0.0, 0.0)), fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(0.4))
    track = drive(prompt, FORWARDS, 2.0)[:, 0, 0]
    delayed = drive(late, FORWARDS, 2.4)[:, 0, 0]
    assert np.abs(delayed[:8]).max() < 0.01
    assert delayed[-1] == pytest.approx(track[-1], abs=0.03)


def test_lost_messages_never_arrive() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(drop=1.0))
    drive(fleet, FORWARDS, 1.0)
    assert np.abs(fleet.true_poses()).max() < 0.01
    assert fleet.observe().stamps[0] == 0.0


def test_some_messages_lost_are_no_reason_to_stop() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(drop=0.5), seed=1)
    drive(fleet, FORWARDS, 2.0)
    assert fleet.true_velocities()[0, 0] == pytest.approx(0.4, abs=0.1)


def test_noise_is_on_the_reports_only() -> None:
    noisy = fleet_of((1.0, 2.0, 0.0), noise=LocalisationNoise(0.05, 0.1), seed=3)
    still = fleet_of((1.0, 2.0, 0.0))
    off = []
    for _ in range(200):
        noisy.advance(0.01)
        off.append(noisy.observe().poses[0] - noisy.true_poses()[0])
    still.advance(2.0)
    assert np.array(off).std(axis=0) == pytest.approx([0.05, 0.05, 0.1], rel=0.25)
    assert noisy.simulator.state_bytes() == still.simulator.state_bytes()


def random_walk(seed: int, **options: Any) -> bytes:
    """The state after the same three seconds of changing commands."""
    fleet = fleet_of((0.0, 0.0, 0.0), (1.5, 0.0, 1.0), seed=seed, **options)
    random = np.random.default_rng(11)
    for _ in range(30):
        fleet.send(random.uniform((-0.3, -0.2, -0.8), (0.4, 0.2, 0.8), (2, 3)))
        fleet.advance(0.1)
    return fleet.simulator.state_bytes()


def test_same_seed_same_state_to_the_last_bit() -> None:
    def run(seed: int) -> bytes:
        return random_walk(
            seed,
            physics=PhysicsSettings(variation=0.05, seed=seed),
            sensing=SensingErrors(velocity=0.02, rate=0.02, delay=0.004),
            delay=CommandDelay(0.05, 0.02, 0.1),
        )

    assert run(1) == run(1)
    assert run(1) != run(2)


def test_masses_and_friction_vary_by_seed_alone() -> None:
    assert random_walk(1) == random_walk(2)
    drawn = [random_walk(1, physics=PhysicsSettings(variation=0.05, seed=k)) for k in (1, 2)]
    assert drawn[0] != drawn[1]
    assert random_walk(1) not in drawn


def test_how_time_is_cut_does_not_matter() -> None:
    whole, parts = fleet_of((0.0, 0.0, 0.0)), fleet_of((0.0, 0.0, 0.0))
    for fleet in (whole, parts):
        fleet.send([FORWARDS])
    whole.advance(0.5)
    for dt in (0.1, 0.05, 0.033, 0.017, 0.3):
        parts.advance(dt)
    assert parts.time == pytest.approx(whole.time)
    assert parts.simulator.state_bytes() == whole.simulator.state_bytes()


def test_odd_steps_add_up() -> None:
    """At 30 Hz a cycle is no whole number of steps: the clock is at most half a step off."""
    fleet = fleet_of((0.0, 0.0, 0.0))
    for k in range(1, 31):
        fleet.advance(1.0 / 30.0)
        assert fleet.time == pytest.approx(k / 30.0)
        assert abs(fleet.simulator.time - fleet.time) <= 0.001 + 1e-9


def test_what_legs_measure_may_be_noisy_and_late() -> None:
    errors = SensingErrors(0.002, 0.03, 0.005, 0.05, 0.003, 0.1, delay=0.004)
    fleet = fleet_of((0.0, 0.0, 0.0), sensing=errors, seed=2)
    drive(fleet, FORWARDS, 3.0)
    assert fleet.true_velocities()[0, 0] == pytest.approx(0.4, abs=0.15)
    assert fleet.falls == ()


def test_a_robot_that_is_thrown_over_has_fallen() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), (3.0, 0.0, 0.0))
    fleet.advance(0.5)
    fleet.simulator.push(1, (0.0, 1500.0, 0.0), 0.1)
    drive(fleet, None, 2.0)
    assert [fall.robot for fall in fleet.falls] == [1]
    (fall,) = fleet.falls
    assert fall.cause in ("tilt", "height", "trunk")
    assert 0.5 < fall.time < 2.0


def test_physics_that_is_unstable_is_no_motion() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0))
    fleet.simulator.data.qvel[0] = np.inf
    with pytest.raises(InputError, match=r"unstable \(BADQVEL\) by 0.02 s"):
        fleet.advance(DT)


def test_samples_tell_what_happened() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), (1.5, 0.0, 1.0), time=7.0)
    drive(fleet, FORWARDS, 2.01)
    kept = fleet.track()
    assert kept.time == pytest.approx(7.0 + 0.02 * np.arange(101))
    assert kept.base.shape == (101, 2, 7)
    assert kept.joints.shape == (101, 2, 12)
    weight = fleet.simulator.descriptions[0].mass * 9.81
    carried = kept.foot_forces[1:, :, :, 2].sum(axis=2).mean(axis=0)
    assert carried == pytest.approx([weight, weight], rel=0.02)
    assert np.all(kept.foot_forces[0] == 0.0)
    limits = fleet.simulator.descriptions[0].torque_limits
    assert np.all(np.abs(kept.torques) <= limits + 1e-9)
    assert np.abs(kept.torques[50:]).max(axis=(0, 1)).min() > 0.1
    last = np.hstack((kept.base[-1], kept.joints[-1]))
    assert np.abs(last - fleet.simulator.qpos).max() < 0.05
    assert kept.contacts == ()


def test_obstacles_come_move_and_go() -> None:
    """One appears beside the robot at 0.5 s, runs into it, and is gone at 4 s."""
    circle = Circle((0.0, 1.0), 0.2)
    obstacle = Obstacle.model_validate({"circle": {"center": [0.0, 1.0], "radius": 0.2}})
    span = ObstacleSpan(
        obstacle, 0.5, 4.0, time=(0.5, 1.0, 2.0), offset=((0.0, 0.0), (0.0, 0.0), (0.0, -0.7))
    )
    ground = PhysicsGround(movable=(blocks_of_shape(circle),))
    fleet = fleet_of((0.0, 0.0, 0.0), ground=ground, obstacles=[span])
    drive(fleet, (0.0, 0.0, 0.0), 1.0)
    assert fleet.track().contacts == ()
    drive(fleet, (0.0, 0.0, 0.0), 2.5)
    touched = fleet.track().contacts
    assert {contact.other for contact in touched} == {"obstacle"}
    assert 1.0 < touched[0].time < 2.1
    assert fleet.true_poses()[0, 1] < -0.03
    last = touched[-1].time
    drive(fleet, (0.0, 0.0, 0.0), 1.0)
    assert all(contact.time <= 4.02 for contact in fleet.track().contacts)
    assert last <= fleet.track().contacts[-1].time


def test_obstacles_put_down_on_the_way_are_as_if_known_from_the_start() -> None:
    """A box in the way comes at 1 s; one that was there from the start goes away at 2 s."""
    there = Obstacle.model_validate({"circle": {"center": [3.0, 3.0], "radius": 0.3}})
    box = Obstacle.model_validate({"box": {"center": [1.6, 1.0], "size": [0.2, 1.5]}})
    area = OccupancyMap.empty((6.0, 4.0), 0.1)
    first = World(area, area, (), (ObstacleSpan(there),))
    second = replace(first, spans=(ObstacleSpan(there), ObstacleSpan(box, 1.0, time=(1.0,))))
    third = replace(first, spans=(ObstacleSpan(there, 0.0, 2.0), second.spans[1]))
    starts = (0.6, 1.0, 0.0), (0.6, 2.5, 0.0)

    def of(world: World) -> MujocoFleet:
        ground, spans = PhysicsGround.of_world(world), movable_spans(world)
        return fleet_of(*starts, ground=ground, obstacles=spans)

    told, known = of(first), of(third)
    for fleet in (told, known):
        drive(fleet, FORWARDS, 1.0)
        if fleet is told:
            fleet.set_world(second)
        fleet.push(1, (0.0, 60.0, 0.0), 0.2)
        drive(fleet, FORWARDS, 1.0)
        if fleet is told:
            fleet.set_world(third)
        drive(fleet, FORWARDS, 1.5)
    assert told.simulator.state_bytes() == known.simulator.state_bytes()
    assert told.track().contacts == known.track().contacts
    (x, _, _), (free, _, _) = told.true_poses()
    assert x < 1.5 < free - 0.2  # one has run into the box


def test_a_contact_is_told_again_while_it_lasts() -> None:
    """Two robots that push against each other touch in most intervals between samples."""
    fleet = fleet_of((0.0, 0.0, 0.0), (0.8, 0.0, np.pi))
    drive(fleet, (0.3, 0.0, 0.0), 3.0)
    contacts = [c for c in fleet.track().contacts if c.other.startswith("robot")]
    assert {(c.robot, c.other) for c in contacts} == {(0, "robot 1"), (1, "robot 0")}
    times = [contact.time for contact in contacts]
    assert times == sorted(times)
    intervals = {int(time / 0.02 - 1e-6) for time in times}
    assert len(intervals) > 0.5 * (3.0 - times[0]) / 0.02


@pytest.mark.parametrize("poses", [[(0.0, 0.0)], [], [(0.0, 0.0, np.nan)], [(0.0, 0.0, 0.0)] * 2])
def test_malformed_starts_are_refused(poses: list[tuple[float, ...]]) -> None:
    with pytest.raises(InputError):
        MujocoFleet([GO1], poses)


def test_robots_without_legs_to_speak_of_are_refused() -> None:
    with pytest.raises(InputError, match="spirit"):
        MujocoFleet([robot_model("spirit")], [(0.0, 0.0, 0.0)])


@pytest.mark.parametrize("command", [[(0.0, 0.0)], [(np.nan, 0.0, 0.0)], [(np.inf, 0.0, 0.0)]])
def test_malformed_commands_are_refused_and_change_nothing(command: Any) -> None:
    fleet = fleet_of((0.0, 0.0, 0.0))
    with pytest.raises(InputError):
        fleet.send(command)
    drive(fleet, None, 0.5)
    assert np.abs(fleet.true_poses()).max() < 0.01


@pytest.mark.parametrize("dt", [0.0, -1.0, np.nan, np.inf])
def test_time_only_goes_forward(dt: float) -> None:
    with pytest.raises(InputError):
        fleet_of((0.0, 0.0, 0.0)).advance(dt)
