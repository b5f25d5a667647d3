"""Plans that keep all rules pass, wherever and however they lie."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st


@pytest.mark.parametrize("model", ["go1", "go2", "spirit"])
def test_walking_turning_and_waiting(maker, team, model):
    plan = maker((5.0, 5.0, -0.5)).wait(0.3).turn(0.5).walk(3.0).wait(0.5)
    report = team(plan, models=[model]).report()
    assert report.violations == ()
    assert report.figures.robots == 1
    assert report.figures.duration_s == pytest.approx(plan.time)
    assert report.figures.max_speed_ratio == pytest.approx(0.75 / 2.0)
    assert report.figures.min_belly_clearance_m == pytest.approx(0.3 - 0.025)


def test_leaping(leaper):
    report = leaper.report()
    assert report.violations == ()
    # From a crouch of 0.17 m, not from the height of walking.
    assert report.figures.min_belly_clearance_m < 0.17


def test_one_leap_may_follow_another(maker, team):
    plan = maker((5.0, 5.0, 0.0)).ramp(0.0, 0.75).leap().leap().ramp(0.75, 0.0)
    assert team(plan).report().ok


@pytest.mark.parametrize("dt", [0.005, 0.017, 0.03])
def test_at_any_sampling(maker, team, dt):
    plan = maker((5.0, 5.0, 0.0), dt=dt).walk(2.0, speed=1.9, acceleration=2.4)
    assert team(plan).report().ok


def test_a_robot_that_is_at_its_goal_already(maker, team):
    judged = team(maker((5.0, 5.0, 0.0)).wait(0.02))
    for name, array in judged.arrays.items():
        judged.arrays[name] = array[:1] if not name.startswith("foot") else array
    judged.arrays["footholds_0"] = np.array(
        [
            (0.0, 0.0, leg, 5.0 + a * 0.1881, 5.0 + b * 0.04675, 0.0)
            for leg, (a, b) in enumerate([(1, 1), (1, -1), (-1, 1), (-1, -1)])
        ]
    )
    judged.summary |= {"duration_s": [0.0], "makespan_s": 0.0, "path_length_m": [0.0]}
    report = judged.report()
    assert report.violations == ()
    assert report.figures.duration_s == 0.0


def turned(judged, robots, yaw, shift):
    """The same problem and its plan, turned about the middle of the ground and shifted."""
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s], [s, c]])

    def moved(points):
        return (points - 20.0) @ turn.T + 20.0 + shift

    for k in range(robots):
        arrays = judged.arrays
        arrays[f"position_{k}"][:, :2] = moved(arrays[f"position_{k}"][:, :2])
        arrays[f"velocity_{k}"][:, :2] = arrays[f"velocity_{k}"][:, :2] @ turn.T
        arrays[f"yaw_{k}"] += yaw
        arrays[f"footholds_{k}"][:, 3:5] = moved(arrays[f"footholds_{k}"][:, 3:5])
        robot = judged.words["robots"][k]
        for key in ("start", "goal"):
            x, y, angle = robot[key]
            robot[key] = [*map(float, moved(np.array([x, y]))), angle + yaw]
    for obstacle in judged.words["world"]["obstacles"]:
        box = obstacle["box"]
        box["center"] = list(map(float, moved(np.array(box["center"]))))
        box["yaw"] = yaw
    return judged


@settings(max_examples=25, deadline=None)
@given(
    yaw=st.floats(-math.pi, math.pi),
    x=st.floats(-5.0, 5.0),
    y=st.floats(-5.0, 5.0),
    first=st.floats(0.1, 3.0),
    gap=st.floats(1e-4, 0.5),
)
def test_a_sound_plan_stays_sound_under_rigid_motion(whole_team, yaw, x, y, first, gap):
    judged = whole_team(first, gap)
    assert turned(judged, 2, yaw, np.array([x, y])).report().violations == ()


@settings(max_examples=15, deadline=None)
@given(yaw=st.floats(-math.pi, math.pi), depth=st.floats(1e-3, 0.2))
def test_a_contact_stays_one_under_rigid_motion(whole_team, yaw, depth):
    judged = whole_team(1.0, -depth)
    kinds = {v.kind for v in turned(judged, 2, yaw, np.zeros(2)).report().violations}
    assert kinds == {"robot-obstacle"}


@pytest.fixture(scope="module")
def whole_team(module_maker, module_team):
    """A walker beside a box, `gap` m away, and a leaper far enough from both."""

    def make(first, gap):
        walker = module_maker((18.0, 20.0, -first)).turn(first).walk(3.0)
        leaper = module_maker((17.0, 23.0, 0.0)).ramp(0.0, 0.75).leap().ramp(0.75, 0.0)
        box = {"box": {"center": [20.0, 20.0 - 0.14 - gap - 0.1], "size": [0.4, 0.2]}}
        ground = {"empty": {"size": [40, 40]}}
        return module_team(walker, leaper, obstacles=[box], world=ground)

    return make
