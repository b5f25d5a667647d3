"""Contact in plans: with obstacles, the border, each other, in flight and after parking."""

from __future__ import annotations

import numpy as np
import pytest

L, W = 0.65, 0.28


def kinds(report):
    return [violation.kind for violation in report.violations]


def meeting(maker, team, apart):
    """Two robots walk past each other, `apart` m between their sides."""
    one = maker((5.0, 5.0, 0.0)).walk(4.0)
    two = maker((9.0, 5.0 + W + apart, np.pi)).walk(4.0)
    return team(one, two)


@pytest.mark.parametrize("apart", [0.001, 0.1])
def test_passing_close_is_no_contact(maker, team, apart):
    report = meeting(maker, team, apart).report()
    assert report.ok
    assert report.figures.min_footprint_gap_m == pytest.approx(apart, abs=1e-4)


def test_contact_between_robots(maker, team):
    judged = meeting(maker, team, -0.01)
    (violation,) = judged.report().violations
    assert violation.kind == "robot-robot"
    assert violation.robots == (0, 1)
    half = judged.summary["duration_s"][0] / 2
    assert violation.time == pytest.approx(half - L / 2 / 0.75, abs=0.02)


def test_contact_between_two_samples_only(maker, team):
    # A long step is a fault of its own, but what happens in it is seen as well.
    judged = team(maker((5.0, 5.0, 0.0), dt=2.0).walk(6.0), obstacles=[])
    judged.words["world"]["obstacles"] = [{"circle": {"center": [8.1, 5.0], "radius": 0.01}}]
    found = judged.report().violations
    contact = next(v for v in found if v.kind == "robot-obstacle")
    assert not np.isclose(judged.arrays["t_0"], contact.time).any()


def test_running_into_an_obstacle(maker, team):
    box = {"box": {"center": [7.0, 5.0], "size": [0.2, 0.2]}}
    (violation,) = team(maker((5.0, 5.0, 0.0)).walk(4.0), obstacles=[box]).report().violations
    assert violation.kind == "robot-obstacle"
    assert violation.obstacle == "world.obstacles[0]"
    way = 2.0 - L / 2 - 0.1
    assert violation.time == pytest.approx(way / 0.75 + 0.75 / 2, abs=0.03)


def test_leaping_over_an_obstacle_is_contact_all_the_same(maker, team):
    box = {"box": {"center": [6.9, 5.0], "size": [0.02, 0.2]}}
    plan = maker((5.0, 5.0, 0.0)).ramp(0.0, 0.75).cruise(0.75, 0.6).leap()
    report = team(plan.cruise(0.75, 0.6).ramp(0.75, 0.0), obstacles=[box]).report()
    assert kinds(report) == ["robot-obstacle"]


def test_the_border(maker, team):
    plan = maker((5.0, 5.0, np.pi)).walk(4.8)
    (violation,) = team(plan).report().violations
    assert (violation.kind, violation.obstacle) == ("robot-map", "border")


def test_ground_that_begins_elsewhere(maker, team):
    plan = maker((0.0, 0.0, np.pi)).walk(2.0)
    ground = {"empty": {"size": [6, 6], "origin": [-3, -3]}}
    assert team(plan, world=ground).report().ok


def test_a_parked_robot_remains_in_the_way(maker, team):
    # The first is at its goal long before the second comes by.
    one = maker((5.0, 7.0, -np.pi / 2)).walk(2.0)
    two = maker((10.0, 5.0, np.pi)).wait(6.0).walk(8.0)
    (violation,) = team(one, two).report().violations
    assert violation.kind == "robot-robot"
    assert violation.time > one.time
    assert violation.robots == (0, 1)


def leap_across(maker, side):
    plan = maker((5.0, 5.0 + side, 0.0)).ramp(0.0, 0.75).cruise(0.75, 0.6).leap()
    return plan.cruise(0.75, 0.6).ramp(0.75, 0.0)


def test_a_flight_over_a_robot(maker, team):
    flight = leap_across(maker, 0.0)
    phase = flight.arrays()["phase_0"]
    x = flight.arrays()["position_0"][:, 0]
    # Beside the robot when it takes off, below it in the middle of its flight.
    middle = float(x[phase == 2].mean())
    crossing = maker((middle, 4.0, np.pi / 2)).ramp(0.0, 0.5, 2.4)
    time = float(flight.arrays()["t_0"][phase == 2].mean())
    crossing = maker((middle, 5.0 - 0.5 - L / 2, np.pi / 2)).wait(time - 1.0).walk(3.0)
    judged = team(flight, crossing)
    found = judged.report().violations
    assert {v.kind for v in found} <= {"flight-over-robot", "robot-robot"}
    assert found
    contact = found[0]
    flying = judged.arrays["t_0"][judged.arrays["phase_0"] == 2]
    named = flying[0] <= contact.time < flying[-1]
    assert named
    assert contact.kind == "flight-over-robot"
    assert contact.message.startswith("robot 0 flies over robot 1")


def test_a_flight_beside_a_robot(maker, team):
    standing = maker((7.0, 5.0 + W + 0.01, 0.0)).wait(0.3)
    assert team(leap_across(maker, 0.0), standing).report().ok


def test_an_unsolved_plan_may_hold_paths_that_meet(maker, team):
    judged = meeting(maker, team, -0.1)
    judged.summary = {"success": False}
    assert judged.report().ok


def test_an_unsolved_plan_may_lack_robots(maker, team):
    judged = meeting(maker, team, -0.1)
    judged.summary = {"success": False}
    judged.arrays = {k: v for k, v in judged.arrays.items() if not k.endswith("_0")}
    report = judged.report()
    assert report.ok
    assert report.figures.robots == 1


def test_an_unsolved_plan_may_be_empty(walker):
    walker.arrays, walker.summary = {}, {"success": False}
    report = walker.report()
    assert report.ok
    assert report.figures is None


def test_an_unsolved_plan_is_judged_robot_by_robot(maker, team):
    box = {"box": {"center": [7.0, 5.0], "size": [0.2, 0.2]}}
    judged = team(maker((5.0, 5.0, 0.0)).walk(4.0), obstacles=[box])
    judged.summary = {"success": False}
    assert kinds(judged.report()) == ["robot-obstacle"]


def test_many_robots_fast_enough(maker, team):
    """No figure of time is judged here, only that a crowd is judged rightly."""
    makers = [maker((2.0, 1.0 + 0.9 * k, 0.0), dt=0.03 - 1e-4 * k).walk(5.0) for k in range(20)]
    report = team(*makers).report()
    assert report.ok
    assert report.figures.robots == 20
