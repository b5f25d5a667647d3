"""Robots in physics that are handed over to leap, judged by the checker's strict criterion."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from cavalcade.checking.heights import Heights
from cavalcade.checking.physics.floor import floor_of
from cavalcade.checking.physics.leaps import Leap, judge_leap
from cavalcade.checking.physics.record import RobotRecord, Touch
from cavalcade.errors import InputError
from cavalcade.fleet import LeapingFleet, LeapRequest
from cavalcade.fleet.mujoco import PhysicsGround, PhysicsSettings
from cavalcade.fleet.mujoco.fleet import MujocoFleet
from cavalcade.lattice.ground import make_ground
from cavalcade.locomotion.leap import LeapManoeuvre
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap
from cavalcade.world.terrain import generate_terrain

GO1 = robot_model("go1")
CELL, MIDDLE = 0.05, 2.5


def fleet_on(terrain, starts, seed=0):
    empty = np.zeros(terrain.height.shape, dtype=bool)
    return MujocoFleet(
        [GO1] * len(starts),
        starts,
        ground=PhysicsGround.of_terrain(terrain),
        footing=make_ground(OccupancyMap(empty, CELL), terrain),
        origin=terrain.origin,
        physics=PhysicsSettings(variation=0.05, seed=seed),
        seed=seed,
    )


def request(y, near, far, rise):
    take_off = np.array([near - 0.3, y, 0.28, 0.0])
    landed = np.array([far + 0.5, y, 0.28 + rise, 0.0])
    return LeapRequest(take_off, landed, (0.3, 0.3 + far - near))


def wait(fleet, command=(0.0, 0.0, 0.0), patience=20.0):
    """Until nobody leaps any more, and 1.6 s longer, under one command for all."""
    end = fleet.time + patience
    commands = [command] * fleet.size
    while fleet.leaping.any() and fleet.time < end:
        fleet.send(commands)
        fleet.advance(0.05)
    for _ in range(32):
        fleet.send(np.zeros((fleet.size, 3)))
        fleet.advance(0.05)


def record_of(fleet, robot):
    kept = fleet.track()
    touches = [touch for touch in kept.contacts if touch.robot == robot]
    return RobotRecord(
        robot, kept.time, kept.base[:, robot], kept.joints[:, robot], kept.joint_rates[:, robot],
        kept.torques[:, robot], kept.foot_forces[:, robot],
        tuple(Touch(touch.time, touch.part, touch.other) for touch in touches),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "option", "half", "rise"),
    [
        ("gap", {"width": 0.3}, 0.15, 0.0),
        ("gap", {"width": 0.4}, 0.2, 0.0),
        ("step", {"height": 0.2}, 0.0, 0.2),
        ("step", {"height": -0.2}, 0.0, -0.2),
    ],
)
def test_robots_leap_as_the_strict_criterion_wants(kind, option, half, rise):
    terrain = generate_terrain(kind, (5.0, 2.0), 0, resolution=CELL, **option)
    near, far = MIDDLE - half, MIDDLE + half
    for seed in (1, 2):
        fleet = fleet_on(terrain, [[1.6, 1.05, 0.1]], seed)
        assert isinstance(fleet, LeapingFleet)
        fleet.leap(0, request(1.0, near, far, rise))
        assert fleet.leaping.all()
        # Commands to a robot that was handed over are of no effect.
        wait(fleet, (-0.5, 0.0, 1.0))
        assert not fleet.leaping.any()
        assert not fleet.leap_failed.any()
        floor = floor_of(Heights(terrain.height, CELL), np.array([[1.0, 1.0], [4.0, 1.0]]))
        leap = Leap((far, 1.0), 0.0, 0.0, rise)
        verdict = judge_leap(record_of(fleet, 0), GO1.description, leap, floor)
        assert verdict.ok, verdict
        assert verdict.flight > 0.2


def test_the_others_do_what_they_are_told_meanwhile():
    terrain = generate_terrain("gap", (5.0, 4.0), 0, resolution=CELL, width=0.3)
    fleet = fleet_on(terrain, [[1.9, 1.0, 0.0], [4.0, 3.0, 0.0]])
    fleet.leap(0, request(1.0, MIDDLE - 0.15, MIDDLE + 0.15, 0.0))
    begin = fleet.true_poses()
    for _ in range(40):
        fleet.send([[0.0, 0.0, 0.0], [-0.3, 0.0, 0.0]])
        fleet.advance(0.05)
    assert fleet.true_poses()[1, 0] - begin[1, 0] == pytest.approx(-0.6, abs=0.12)
    wait(fleet)
    assert fleet.true_poses()[0, 0] > MIDDLE + 0.3
    # Given back, the robot obeys again.
    for _ in range(40):
        fleet.send([[0.3, 0.0, 0.0], [0.0, 0.0, 0.0]])
        fleet.advance(0.05)
    assert fleet.true_poses()[0, 0] > MIDDLE + 0.8


def test_a_robot_does_not_try_what_is_too_far():
    terrain = generate_terrain("gap", (5.0, 2.0), 0, resolution=CELL, width=1.0)
    fleet = fleet_on(terrain, [[1.5, 1.0, 0.0]])
    fleet.leap(0, request(1.0, MIDDLE - 0.5, MIDDLE + 0.5, 0.0))
    wait(fleet)
    assert fleet.leap_failed.all()
    assert not fleet.leaping.any()
    assert not fleet.falls
    assert fleet.true_poses()[0, 0] < MIDDLE - 0.6


def test_a_leap_that_misses_the_ground_has_failed():
    # Its ground is told to end where it does not: the robot lands in the pit.
    terrain = generate_terrain("gap", (5.0, 2.0), 0, resolution=CELL, width=0.9)
    fleet = fleet_on(terrain, [[1.6, 1.0, 0.0]])
    edge = MIDDLE - 0.45
    fleet.advance(0.3)
    fleet.control.leap(0, LeapManoeuvre((1.6, 1.0, 0.0, 0.0), (edge + 0.55, 1.0, 0.0, 0.0)))
    for _ in range(60):
        fleet.advance(0.05)
    assert fleet.control.leap_failed.all()


def test_robots_that_cannot_be_handed_over():
    terrain = generate_terrain("gap", (5.0, 2.0), 0, resolution=CELL, width=0.3)
    fleet = fleet_on(terrain, [[1.6, 1.0, 0.0]])
    asked = request(1.0, MIDDLE - 0.15, MIDDLE + 0.15, 0.0)
    with pytest.raises(InputError, match="robot"):
        fleet.leap(1, asked)
    fleet.leap(0, asked)
    with pytest.raises(InputError, match="leaping already"):
        fleet.leap(0, asked)
