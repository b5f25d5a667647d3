from __future__ import annotations

import numpy as np
import pytest

from cavalcade.campaign.avoidable import audit, way_open
from cavalcade.checking.report import Report, Violation
from cavalcade.formation.status import PlannerStatus
from cavalcade.running.frames import Recording
from cavalcade.scenario import build_world, parse_scenario, resolve_scenario

CROSSING = {"circle": {"center": [5.0, 0.4], "radius": 0.3}}


def scene(events=(), obstacles=(), speed=0.0, seconds=10.0, size=(10.0, 6.0)):
    """A robot at (5, 3) that looks along x, and one far away; both go along x."""
    said = {
        "version": 1,
        "name": "scene",
        "world": {"empty": {"size": list(size)}, "obstacles": list(obstacles)},
        "robots": [{"start": [5.0, 3.0, 0.0]}, {"start": [1.0, 5.0, 0.0]}],
        "task": {"formation": {"shape": "column", "spacing": 1.0}, "goals": [[5.0, 3.0, 0.0]]},
        "execution": {"events": list(events)},
    }
    scenario = resolve_scenario(parse_scenario(said))
    time = np.arange(0.0, seconds, 0.05)
    poses = np.tile(np.array(scenario.starts), (len(time), 1, 1))
    poses[:, :, 0] += speed * time[:, None]
    empty = np.zeros_like(poses)
    recording = Recording(time, poses, poses, empty, (), (), ())
    return scenario, build_world(scenario), recording


def verdict(made, time, obstacle, kind="robot-obstacle", robots=(0,)):
    found = Violation(kind, time, robots, "", 0.0, 0.0, obstacle)
    scenario, world, recording = made
    (collision,) = audit(scenario, world, recording, Report((found,), None))
    assert collision.violation is found
    return collision


@pytest.mark.parametrize("kind", ["robot-robot", "robot-map"])
def test_the_team_and_the_map_can_be_avoided(kind):
    assert verdict(scene(), 1.0, "", kind, (0, 1)).avoidable


def test_what_stands_can_be_avoided():
    made = scene(obstacles=[{"circle": {"center": [6.0, 3.0], "radius": 0.3}}], speed=0.2)
    found = verdict(made, 2.0, "world.obstacles[0]")
    assert found.avoidable
    assert found.why == "it stood"


@pytest.mark.parametrize(
    ("gap", "speed", "avoidable"),
    [(-0.3, 0.0, False), (0.05, 0.0, True), (0.1, 0.5, False), (0.3, 0.5, True)],
)
def test_what_appears_within_the_braking_distance_cannot(gap, speed, avoidable):
    front = 5.0 + speed * 2.0 + 0.325
    shape = {"circle": {"center": [front + gap + 0.3, 3.0], "radius": 0.3}}
    made = scene([{"at": 2.0, "add": shape}], speed=speed)
    assert verdict(made, 3.0, "event at 2 s").avoidable is avoidable


def test_what_appeared_long_ago_can():
    add = {"at": 2.0, "add": {"circle": {"center": [5.6, 3.0], "radius": 0.3}}}
    found = verdict(scene([add]), 6.0, "event at 2 s")
    assert found.avoidable
    assert found.why == "it stood"


def crossing(speed):
    return {"at": 1.0, "move": {**CROSSING, "to": [5.0, 5.6], "speed": speed}}


def test_a_slow_one_can_be_stepped_out_of_the_way_of():
    # It goes 1.86 m before it touches the robot's side.
    found = verdict(scene([crossing(0.25)], seconds=30.0), 1.0 + 2.16 / 0.25, "event at 1 s")
    assert found.avoidable
    assert found.why.startswith("it could have gone aside")


def test_a_fast_one_between_walls_cannot():
    walls = [{"box": {"center": [x, 3.0], "size": [0.2, 0.6]}} for x in (4.4, 5.6)]
    shut = [{"box": {"center": [5.0, 3.6], "size": [1.4, 0.2]}}]
    made = scene([crossing(2.0)], obstacles=walls + shut)
    found = verdict(made, 1.0 + 2.16 / 2.0, "event at 1 s")
    assert not found.avoidable
    assert "no way out" in found.why


def test_standing_still_would_have_done():
    # The robot drives on into the way of what passes ahead of its first place.
    move = {
        "at": 1.0,
        "move": {
            "circle": {"center": [7.0, 0.4], "radius": 0.3},
            "to": [7.0, 5.6],
            "speed": 0.5,
        },
    }
    found = verdict(scene([move], speed=0.3), 5.6, "event at 1 s")
    assert found.avoidable
    assert found.why == "it could have stood still"


def test_a_lost_robot_cannot_help_it():
    events = [{"at": 0.5, "lose": 0}, crossing(0.25), {"at": 9.5, "rejoin": 0}]
    made = scene(events, seconds=30.0)
    assert not verdict(made, 9.0, "event at 1 s").avoidable
    assert verdict(made, 9.6, "event at 1 s").avoidable


def test_nothing_to_audit():
    scenario, world, recording = scene()
    found = Violation("speed", 1.0, (0,), "", 1.0, 0.5)
    assert audit(scenario, world, recording, Report((found,), None)) == []


def test_a_way_is_left_or_not():
    def ended(obstacles, roles):
        scenario, world, recording = scene(obstacles=obstacles)
        status = PlannerStatus.__new__(PlannerStatus)
        values = {
            "goal": np.array([8.0, 3.0, 0.0]),
            "slots": np.array([[0.5, 0.0], [-0.5, 0.0]]),
            "roles": np.array(roles),
        }
        for key, value in values.items():
            object.__setattr__(status, key, value)
        last = Recording(
            recording.time,
            recording.poses,
            recording.poses,
            recording.commands,
            (status,),
            (),
            (),
        )
        return way_open(scenario, world, last)

    wall = [{"box": {"center": [6.5, 3.0], "size": [0.2, 6.0]}}]
    gate = [
        {"box": {"center": [2.0, 4.2], "size": [0.2, 2.4]}},
        {"box": {"center": [2.0, 1.2], "size": [0.2, 2.4]}},
    ]
    assert ended([], [0, 1])
    assert not ended(wall, [0, 1])
    assert ended(gate, [0, 1])
    # Robot 0 is lost and stands in its own way only.
    assert ended([], [-1, 0])
