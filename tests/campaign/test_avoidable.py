from __future__ import annotations

import numpy as np
import pytest

from cavalcade.campaign.avoidable import audit
from cavalcade.checking.report import Report, Violation
from cavalcade.recording.frames import Recording
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


def verdicts(made, times, obstacle, kind="robot-obstacle", robots=(0,)):
    found = tuple(Violation(kind, time, robots, "", 0.0, 0.0, obstacle) for time in times)
    scenario, world, recording = made
    collisions = audit(scenario, world, recording, Report(found, None))
    assert tuple(collision.violation for collision in collisions) == found
    return collisions


def verdict(made, time, obstacle, kind="robot-obstacle", robots=(0,)):
    (collision,) = verdicts(made, [time], obstacle, kind, robots)
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
    ("gap", "speed", "contact", "avoidable"),
    [
        (-0.3, 0.0, 2.0, False),
        (0.05, 0.0, 2.1, True),
        (0.1, 0.5, 2.2, False),
        (0.1, 0.5, 3.0, True),  # it would have stood long before
        (0.1, -0.5, 2.2, True),  # it drives away from it
        (0.3, 0.5, 2.6, True),
    ],
)
def test_what_appears_within_the_braking_distance_cannot(gap, speed, contact, avoidable):
    front = 5.0 + speed * 2.0 + scene()[0].models[0].length / 2.0
    shape = {"circle": {"center": [front + gap + 0.3, 3.0], "radius": 0.3}}
    made = scene([{"at": 2.0, "add": shape}], speed=speed)
    assert verdict(made, contact, "event at 2 s").avoidable is avoidable


@pytest.mark.parametrize(("aside", "avoidable"), [(0.0, False), (0.1, True)])
def test_what_appears_beside_the_way_can(aside, avoidable):
    # Its edge is as far from the robot's side, and half a braking distance ahead of its front.
    model = scene()[0].models[0]
    center = [6.0 + model.length / 2.0 + 0.15, 3.0 + model.width / 2.0 + 0.1 + aside]
    shape = {"box": {"center": center, "size": [0.2, 0.2]}}
    made = scene([{"at": 2.0, "add": shape}], speed=0.5)
    assert verdict(made, 2.3, "event at 2 s").avoidable is avoidable


def test_a_contact_that_goes_on_counts_once():
    # It appears in the robot, which stays there: all else is the same contact.
    inside = {"at": 2.0, "add": {"circle": {"center": [5.3, 3.0], "radius": 0.3}}}
    first, later = verdicts(scene([inside]), [2.0, 6.0], "event at 2 s")
    assert not first.avoidable
    assert not later.avoidable
    assert verdict(scene([inside]), 6.0, "event at 2 s").avoidable


@pytest.mark.parametrize(("away", "avoidable"), [(0.5, False), (1.5, True)])
def test_a_contact_after_a_while_is_another(away, avoidable):
    inside = {"at": 2.0, "add": {"circle": {"center": [5.5, 3.0], "radius": 0.3}}}
    scenario, world, recording = scene([inside])
    gone = (recording.time > 3.0) & (recording.time < 3.0 + away)
    recording.poses[gone, 0, 0] -= 1.0
    made = scenario, world, recording
    first, later = verdicts(made, [2.0, 3.0 + away], "event at 2 s")
    assert not first.avoidable
    assert later.avoidable is avoidable


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


def test_a_lost_robot_may_not_roll_into_what_stands():
    events = [{"at": 0.5, "lose": 0}, {"at": 1.0, "add": CROSSING}]
    walls = [{"circle": {"center": [6.0, 3.0], "radius": 0.3}}]
    made = scene(events, walls)
    found = verdict(made, 2.0, "world.obstacles[0]")
    assert found.avoidable
    assert "stood" in found.why
    assert not verdict(made, 2.0, "event at 1 s").avoidable
    # What appeared before the loss stands as well.
    before = scene([{"at": 0.2, "add": CROSSING}, {"at": 0.5, "lose": 0}])
    assert verdict(before, 2.0, "event at 0.2 s").avoidable


def test_who_is_close_to_something_may_get_away():
    # A wall along the robot's back; what comes from the side would let it go on ahead.
    back = 5.0 - scene()[0].models[0].length / 2.0
    wall = {"box": {"center": [back - 0.01 - 0.1, 3.0], "size": [0.2, 0.2]}}
    made = scene([crossing(0.25)], obstacles=[wall], seconds=30.0)
    assert verdict(made, 1.0 + 2.16 / 0.25, "event at 1 s").avoidable


def test_nothing_to_audit():
    scenario, world, recording = scene()
    found = Violation("speed", 1.0, (0,), "", 1.0, 0.5)
    assert audit(scenario, world, recording, Report((found,), None)) == []
