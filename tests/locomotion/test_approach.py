"""The way to a leap: breaks of the ground found squarely, and a pilot that places the feet."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.geometry import wrap_angle
from cavalcade.locomotion.approach import DONE, FAILED, LEAP, WAIT, WALK, LeapPilot
from cavalcade.locomotion.crossing import find_crossing
from cavalcade.locomotion.leap import LeapSettings

FRONT, SIDE = 0.19, 0.13
TAKE_OFF = np.array([0.0, 0.0, 0.28, 0.0])


def ground(turn=0.0, width=0.3, rise=0.0, at=0.3):
    """Heights of a break whose edges are turned, and which the x axis meets at `at`."""
    across = np.array([math.cos(turn), math.sin(turn)])

    def heights(points):
        past = (np.asarray(points) - (at, 0.0)) @ across
        return np.where(past < 0.0, 0.0, np.where(past < width, -1.0, rise))

    return heights


@pytest.mark.parametrize("turn", [-0.4, -0.1, 0.0, 0.25])
@pytest.mark.parametrize(("width", "rise"), [(0.3, 0.0), (0.0, 0.2), (0.0, -0.2), (0.2, 0.1)])
def test_a_break_is_found_as_it_lies(turn, width, rise):
    landed = np.array([1.0, 0.0, 0.28 + rise, 0.0])
    far = 0.3 + width / math.cos(turn)
    crossing = find_crossing(TAKE_OFF, landed, (0.3, far), ground(turn, width, rise))
    assert crossing.yaw == pytest.approx(turn, abs=0.05)
    assert crossing.gap == pytest.approx(width, abs=0.03)
    assert crossing.rise == pytest.approx(rise, abs=1e-9)
    # The level ground begins and ends where it says, or a little further from the break.
    past = float((crossing.start - (0.3, 0.0)) @ crossing.direction)
    assert -0.03 <= past <= 1e-9
    assert past + crossing.gap >= width - 1e-9


def test_edges_are_taken_as_they_are_where_heights_are_not_known():
    crossing = find_crossing(TAKE_OFF, np.array([0.0, 1.0, 0.48, 1.5]), (0.3, 0.5), None)
    np.testing.assert_allclose(crossing.direction, (0.0, 1.0), atol=1e-12)
    np.testing.assert_allclose(crossing.start, (0.0, 0.3), atol=1e-12)
    assert crossing.gap == pytest.approx(0.2)
    assert crossing.rise == pytest.approx(0.2)


class Walker:
    """A robot that obeys at once, stands when it is told nothing, and leaps in no time."""

    def __init__(self, pose, slip=0.0):
        self.pose, self.slip = np.array(pose, dtype=float), slip
        self.time, self.still = 0.0, 0.0
        self.orders = []

    def feet(self):
        x, y, yaw = self.pose
        c, s = math.cos(yaw), math.sin(yaw)
        places = [
            (FRONT + self.slip, SIDE),
            (FRONT + self.slip, -SIDE),
            (-FRONT, SIDE),
            (-FRONT, -SIDE),
        ]
        return np.array([(x + c * u - s * v, y + s * u + c * v, 0.02) for u, v in places])

    def drive(self, pilot, seconds, moves=True):
        """What the pilot orders last."""
        order = WALK
        for _ in range(round(seconds / 0.02)):
            order = pilot.step(self.time, self.pose, self.feet(), self.still > 0.2, False)
            self.orders.append(order)
            if order != WALK:
                break
            vx, vy, turn = pilot.velocity if moves else (0.0, 0.0, 0.0)
            c, s = math.cos(self.pose[2]), math.sin(self.pose[2])
            self.pose += 0.02 * np.array([c * vx - s * vy, s * vx + c * vy, turn])
            self.still = 0.0 if any(pilot.velocity) else self.still + 0.02
            self.time += 0.02
        return order


def pilot_for(turn=0.0, width=0.3, rise=0.0):
    landed = np.array([1.0, 0.0, 0.28 + rise, 0.0])
    edges = (0.3, 0.3 + width / math.cos(turn))
    return LeapPilot(TAKE_OFF, landed, edges, ground(turn, width, rise), FRONT)


@pytest.mark.parametrize("start", [(-0.6, 0.0, 0.0), (-0.4, 0.15, -0.5), (0.15, -0.1, 0.3)])
@pytest.mark.parametrize("slip", [0.0, 0.03, -0.03])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_robot_leaps_squarely_from_where_its_front_feet_are_before_the_edge(start, slip, turn):
    walker, pilot = Walker(start, slip), pilot_for(turn)
    assert walker.drive(pilot, 25.0) == LEAP
    across = np.array([math.cos(turn), math.sin(turn)])
    before = -((walker.feet()[:2, :2] - (0.3, 0.0)) @ across)
    assert before.min() >= 0.02
    assert before.max() <= LeapSettings().before + 0.09
    assert abs(float(wrap_angle(walker.pose[2] - turn))) < 0.1
    leap = pilot.manoeuvre
    assert leap is not None
    # Its edges are those of the ground, seen from where the robot stands.
    near = float(((0.3, 0.0) - walker.pose[:2]) @ across)
    assert leap.edges[0] == pytest.approx(near, abs=0.035)
    assert leap.edges[1] == pytest.approx(near + 0.3, abs=0.035)
    np.testing.assert_allclose(leap.direction, across, atol=0.05)


def test_the_head_of_a_robot_is_clear_of_a_step():
    walker, pilot = Walker((-0.6, 0.0, 0.0)), pilot_for(width=0.0, rise=0.2)
    assert walker.drive(pilot, 25.0) == LEAP
    settings = LeapSettings()
    wanted = settings.before + 0.2 * settings.head
    assert 0.3 - walker.feet()[0, 0] == pytest.approx(wanted, abs=0.07)


def test_after_its_leap_a_robot_is_given_back_when_it_stands():
    walker, pilot = Walker((-0.3, 0.0, 0.0)), pilot_for()
    walker.drive(pilot, 25.0)
    feet = walker.feet()
    assert pilot.leapt
    assert pilot.step(walker.time + 0.1, walker.pose, feet, False, True) == WAIT
    assert pilot.step(walker.time + 1.0, walker.pose, feet, True, False) == WALK
    assert pilot.step(walker.time + 1.5, walker.pose, feet, True, False) == DONE


def test_a_robot_that_does_not_get_there_gives_up():
    walker, pilot = Walker((-0.6, 0.0, 0.0)), pilot_for()
    assert walker.drive(pilot, 60.0, moves=False) == FAILED
    assert 20.0 < walker.time < 40.0


def test_where_the_ground_does_not_break_the_robot_walks():
    landed = np.array([0.8, 0.2, 0.28, 0.4])
    pilot = LeapPilot(TAKE_OFF, landed, None, None, FRONT)
    walker = Walker((-0.3, 0.0, 0.0))
    assert walker.drive(pilot, 25.0) == DONE
    assert not pilot.leapt
    np.testing.assert_allclose(walker.pose, landed[[0, 1, 3]], atol=0.04)
