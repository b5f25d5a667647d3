"""Recordings of robots with goals of their own: their own limits and their own goals."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.checking.check import judge
from cavalcade.checking.tracks import Track
from cavalcade.scenario import parse_scenario


def moved(speed, *, yaw=0.0, turn=0.0, acceleration=1.0, dt=0.05):
    """A track along x: up to a speed, 2 s of it, down again and 1 s of rest."""
    ramp = abs(speed) / acceleration
    time = np.arange(0.0, 2.0 + 2.0 * ramp + 1.0 + dt / 2, dt)
    knots = (0.0, ramp, ramp + 2.0, 2.0 * ramp + 2.0)
    fine = np.arange(0.0, time[-1] + dt / 2, dt / 50)
    middle = (fine[1:] + fine[:-1]) / 2
    way = np.cumsum(np.interp(middle, knots, (0.0, speed, speed, 0.0))) * dt / 50
    x = 3.0 + np.concatenate(([0.0], way))[::50][: len(time)]
    angle = yaw + turn * np.minimum(time, 2.0)
    return Track(time, np.column_stack((x, np.full_like(x, 5.0), angle)))


def scenario(track, model="go1", goal=None, world=None):
    end = [float(value) for value in track.pose[-1]]
    return parse_scenario(
        {
            "version": 1,
            "name": "by-hand",
            "world": world or {"empty": {"size": [12, 10]}},
            "robots": [
                {
                    "model": model,
                    "start": [float(value) for value in track.pose[0]],
                    "goal": goal or end,
                }
            ],
            "task": {"goals": "individual"},
        }
    )


def kinds(track, success=True, **words):
    report = judge(scenario(track, **words), (track,), {"success": success})
    return {violation.kind for violation in report.violations}


@pytest.mark.parametrize(("speed", "found"), [(0.75, set()), (2.08, set()), (2.15, {"speed"})])
def test_legged_robots_walk_faster_than_in_formation(speed, found):
    assert kinds(moved(speed, acceleration=2.0)) == found


@pytest.mark.parametrize(("acceleration", "found"), [(2.45, set()), (2.6, {"acceleration"})])
def test_friction_on_level_ground(acceleration, found):
    assert kinds(moved(1.0, acceleration=acceleration)) == found


def test_a_leap_presses_harder_than_walking():
    world = {"generate": {"kind": "step", "size": [12, 10], "height": 0.0}}
    assert kinds(moved(1.0, acceleration=4.0), world=world) == set()


@pytest.mark.parametrize(("rate", "found"), [(1.25, set()), (1.3, {"yaw-rate"})])
def test_yaw_rate(rate, found):
    assert kinds(moved(0.01, turn=rate)) == found


@pytest.mark.parametrize(
    ("off", "found"),
    [((0.09, 0.0), set()), ((0.11, 0.0), {"arrival"}), ((0.0, 0.16), {"arrival"})],
)
def test_arrival_at_the_own_goal(off, found):
    track = moved(0.75)
    x, y, yaw = track.pose[-1]
    goal = [float(x + off[0]), float(y), float(yaw + off[1])]
    assert kinds(track, goal=goal) == found
    assert kinds(track, goal=goal, success=False) == set()


def test_a_robot_still_on_its_way_has_not_arrived():
    track = moved(0.75)
    late = track.time < 2.0
    assert kinds(Track(track.time[late], track.pose[late])) == {"arrival"}


def test_unicycles_do_not_slide():
    assert kinds(moved(0.45), model="unicycle") == set()
    assert kinds(moved(-0.45), model="unicycle") == set()
    assert kinds(moved(0.45, yaw=0.3), model="unicycle") == {"speed"}


def test_second_order_drives_have_accelerations():
    assert kinds(moved(0.45, acceleration=0.25), model="unicycle-2") == set()
    assert kinds(moved(0.45, acceleration=0.5), model="unicycle-2") == {"acceleration"}
    assert kinds(moved(0.45, acceleration=0.5), model="unicycle") == set()


def test_nobody_sees_how_an_integrator_is_turned():
    track = moved(0.45, turn=3.0)
    x, y, _ = track.pose[-1]
    goal = [float(x), float(y), 0.0]
    assert kinds(track, model="double-integrator", goal=goal) == set()


def test_discs_are_swept_as_discs():
    track = moved(0.45)
    # Beside the corner of the square around the disc of 0.8 m.
    world = {
        "empty": {"size": [12, 10]},
        "obstacles": [{"circle": {"center": [3.0 - 0.35, 5.35], "radius": 0.05}}],
    }
    assert kinds(track, model="unicycle-sphere", world=world) == set()
    world["obstacles"] = [{"circle": {"center": [3.0 - 0.28, 5.28], "radius": 0.05}}]
    assert kinds(track, model="unicycle-sphere", world=world) == {"robot-obstacle"}


@pytest.mark.parametrize("gap", [1e-5, 0.5e-3, 0.99e-3, 1e-3, 1.1e-3, 0.01])
@pytest.mark.parametrize("beside", ["start", "goal"])
def test_starts_and_goals_keep_what_planners_ask_for(gap, beside):
    """The checker took places that planners refuse."""
    track = moved(0.75)
    x = float(track.pose[0 if beside == "start" else -1][0])
    obstacle = {"box": {"center": [x, 5.14 + gap + 0.1], "size": [0.3, 0.2]}}
    world = {"empty": {"size": [12, 10]}, "obstacles": [obstacle]}
    kind = {"start": "start", "goal": "arrival"}[beside]
    assert kinds(track, world=world) == (set() if gap >= 1e-3 else {kind})
    assert kinds(track, world=world, success=False) <= {"start"}


def test_a_diagonal_gap_is_measured_between_the_corners():
    track, corner = moved(0.75), 0.8e-3
    box = {"center": [3.0 - 0.325 - corner - 0.1, 5.14 + corner + 0.1], "size": [0.2, 0.2]}
    world = {"empty": {"size": [12, 10]}, "obstacles": [{"box": box}]}
    assert kinds(track, world=world) == set()
