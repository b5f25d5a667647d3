"""The question that predictive control gets, and laws of the forces it answers with."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.kernels import kernel
from cavalcade.locomotion._horizon import (
    STILL,
    approach,
    commanded_velocity,
    solve_forces,
    swing_share,
    walk_problem,
)
from cavalcade.locomotion._kinematics import measure_body
from cavalcade.locomotion.parameters import robot_parameters
from cavalcade.locomotion.records import BODY, STANDING, STATE, STEPS, TROTTING, Measured
from cavalcade.locomotion.settings import GaitSettings
from cavalcade.robots import robot_model

GO1 = robot_model("go1").description
PARAMETERS = robot_parameters(GO1)[()]
ACROSS = [1, 0, 3, 2]
WEIGHT = GO1.mass * 9.81

# A robot that is its own mirror image; Go1 itself carries some things on one side.
EVEN = robot_parameters(GO1)
EVEN["centre"][1] = 0.0
for _a, _b in ((0, 1), (1, 2)):
    EVEN["inertia"][_a, _b] = EVEN["inertia"][_b, _a] = 0.0
EVEN = EVEN[()]

speeds = st.tuples(st.floats(-1.0, 1.0), st.floats(-0.5, 0.5), st.floats(-1.5, 1.5))


def gait(**values):
    return GaitSettings(**values).row(GO1.mass, GO1.stand_height)[()]


def turn(yaw):
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@kernel
def solve_walk(parameters, values, body, state):
    solve_forces(walk_problem(parameters, values, body, state), state)


def walking(mode, time=0.1, velocity=(0.0, 0.0, 0.0), wanted=None, pose=(0.0, 0.0, 0.0),
            parameters=PARAMETERS, values=None):  # fmt: skip
    """A robot at its nominal height; feet are in the air by the trot's clock, which began at 0.

    Velocities are in the body's frame; `wanted` is what it gets to hear, the same by default.
    """
    values = gait() if values is None else values
    body, state = np.zeros(1, BODY)[0], np.zeros(1, STATE)[0]
    x, y, yaw = pose
    world = turn(yaw) @ [*velocity[:2], 0.0]
    qpos = np.array([x, y, GO1.stand_height, np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])
    qpos = np.concatenate([qpos, GO1.standing])
    qvel = np.concatenate([world, [0.0, 0.0, velocity[2]], np.zeros(12)])
    measure_body(parameters, Measured(time, qpos, qvel, np.zeros(4)), body)
    state["mode"], state["time"], state["heard"], state["idle"] = mode, time, time, time
    state["velocity"] = velocity
    state["wanted"] = velocity if wanted is None else wanted
    state["place"], state["yaw"] = body["centre"][:2], yaw
    state["stood"] = state["landing"] = body["foot"]
    for leg in range(4):
        swings = mode == TROTTING and swing_share(values, time, leg) < 1.0
        state["swinging"][leg], state["contact"][leg] = swings, not swings
    return body, state


def forces(mode, parameters=PARAMETERS, values=None, change=None, **options):
    values = gait() if values is None else values
    body, state = walking(mode, parameters=parameters, values=values, **options)
    if change is not None:
        change(body, state)
    solve_walk(parameters, values, body, state)
    return state["forces"].copy()


def question(values, body, state):
    """The problem by its fields' names, from the kernel run as Python."""
    rows = [np.array([row]).view(np.recarray)[0] for row in (PARAMETERS, values, body, state)]
    return walk_problem.py_func(*rows)._asdict()


@given(st.floats(0.2, 0.8), st.floats(0.2, 0.9), st.floats(0.0, 10.0))
@settings(deadline=None)
def test_feet_swing_in_their_part_of_the_cycle_and_pairs_half_a_cycle_apart(period, duty, clock):
    values = gait(period=period, duty=duty)
    shares = [swing_share(values, clock, leg) for leg in range(4)]
    assert shares[0] == shares[3]
    assert shares[1] == shares[2]
    assert shares[1] == pytest.approx(swing_share(values, clock + period / 2, 0), abs=1e-6) or (
        # At the very ends a rounding decides.
        min(abs(clock / period % 0.5 - e) for e in (0.0, 0.5, (1 - duty) % 0.5)) < 1e-6
    )
    phase = clock / period % 1.0
    expected = phase / (1.0 - duty) if phase < 1.0 - duty else 1.0
    assert shares[0] == pytest.approx(expected)


@pytest.mark.parametrize("duty", [0.3, 0.5, 0.7])
def test_a_foot_stands_for_its_share_of_the_time(duty):
    values, clocks = gait(duty=duty), np.linspace(0.0, 36.0, 100_000, endpoint=False)
    stands = np.mean([swing_share(values, clock, 2) >= 1.0 for clock in clocks])
    assert stands == pytest.approx(duty, abs=1e-3)


def test_a_command_holds_until_the_silence_and_tiny_ones_are_none():
    values = gait()
    _, state = walking(TROTTING, time=1.0, wanted=(0.3, -0.1, 0.2))
    state["heard"] = 0.5
    assert commanded_velocity(values, state) == (0.3, -0.1, 0.2)
    state["time"] = 1.0 + 1e-6
    assert commanded_velocity(values, state) == (0.0, 0.0, 0.0)
    for wanted, none in (
        ((0.9 * STILL, 0.0, 0.0), True),
        ((0.8 * STILL, 0.8 * STILL, 0.0), False),
        ((0.0, 0.0, 1.9 * STILL), True),
        ((0.0, 0.0, 2.1 * STILL), False),
    ):
        _, state = walking(TROTTING, wanted=wanted)
        assert (commanded_velocity(values, state) == (0.0, 0.0, 0.0)) == none


@given(speeds, speeds, st.floats(1e-3, 0.5))
@settings(deadline=None)
def test_commands_are_approached_straight_and_no_faster_than_allowed(now, wanted, passed):
    values, velocity = gait(), np.array(now)
    approach(values, velocity, *wanted, passed)
    step, all_the_way = velocity - now, np.array(wanted) - now
    length = np.hypot(*all_the_way[:2])
    reach = values["acceleration"] * passed
    assert np.hypot(*step[:2]) == pytest.approx(min(length, reach), abs=1e-12)
    assert step[0] * all_the_way[1] == pytest.approx(step[1] * all_the_way[0], abs=1e-12)
    limit = values["turning"] * passed
    assert step[2] == pytest.approx(np.clip(all_the_way[2], -limit, limit))


@given(speeds, speeds, st.floats(-3.0, 3.0))
@settings(deadline=None, max_examples=25)
def test_the_reference_is_the_command_as_it_will_be_approached(now, wanted, yaw):
    """Against the same motion in steps of 0.1 ms."""
    values = gait()
    body, state = walking(TROTTING, velocity=now, wanted=wanted, pose=(1.0, -2.0, yaw))
    asked = question(values, body, state)["reference"]
    goal = np.array(commanded_velocity(values, state))
    velocity, place, angle, dt = np.array(now), state["place"].copy(), yaw, 1e-4
    for k in range(STEPS):
        for _ in range(round(values["step"] / dt)):
            approach(values, velocity, *goal, dt)
            angle += velocity[2] * dt
            place = place + dt * (turn(angle) @ [*velocity[:2], 0.0])[:2]
        np.testing.assert_allclose(asked[k, 3:5], place, atol=2e-3)
        assert asked[k, 2] == pytest.approx(angle, abs=2e-3)
        np.testing.assert_allclose(
            asked[k, 9:11], (turn(asked[k, 2]) @ [*velocity[:2], 0.0])[:2], atol=1e-9
        )
        assert asked[k, 8] == pytest.approx(velocity[2], abs=1e-9)


@pytest.mark.parametrize("time", [0.0, 0.05, 0.1, 0.17, 0.2, 0.31])
def test_contacts_over_the_horizon_are_those_of_the_clock(time):
    values = gait()
    body, state = walking(TROTTING, time=time, velocity=(0.4, 0.0, 0.0))
    contacts = question(values, body, state)["contacts"]
    for k in range(1, STEPS):
        later = time + (k + 0.5) * values["step"]
        for leg in range(4):
            assert contacts[k, leg] == (swing_share(values, later, leg) >= 1.0)
    assert contacts[0].tolist() == state["contact"].tolist()


def test_a_foot_that_came_down_early_stands_until_its_next_swing():
    values = gait()
    body, state = walking(TROTTING, time=0.13)
    assert state["swinging"].tolist() == [1, 0, 0, 1]
    state["contact"][0] = 1
    contacts = question(values, body, state)["contacts"]
    phases = (0.13 + (np.arange(STEPS) + 0.5) * values["step"]) / values["period"]
    assert contacts[:, 0].tolist() == [int(p < 1.0 or p % 1.0 >= 0.5) for p in phases]


def test_levers_lead_to_the_feet_from_where_the_centre_of_mass_will_be():
    values, speed = gait(), 0.5
    body, state = walking(TROTTING, time=0.1, velocity=(speed, 0.0, 0.0))
    asked = question(values, body, state)
    middles = (np.arange(STEPS) + 0.5) * values["step"]
    centre = body["centre"] + np.outer(middles, [speed, 0.0, 0.0])
    for k, middle in enumerate(middles):
        for leg in range(4):
            foot = body["foot"][leg] - [0.0, 0.0, GO1.foot_radius]
            begun = (0.1 / values["period"] + values["offset"][leg]) % 1.0
            if begun + middle / values["period"] >= 1.0:
                # It has been put elsewhere: below the hip in the middle of the stance there.
                phase = (begun + middle / values["period"]) % 1.0
                until = (1.0 - 0.5 * values["duty"] - phase) * values["period"]
                foot = foot + [speed * (middle + until), 0.0, 0.0]
            np.testing.assert_allclose(asked["levers"][k, leg], foot - centre[k], atol=1e-9)


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_the_trunk_follows_a_slope(yaw):
    """Nose up where it rises ahead, left side up where it rises to the left."""
    values = gait()
    for ahead, left in ((0.2, 0.0), (0.0, 0.2)):
        body, state = walking(STANDING, pose=(0.0, 0.0, yaw))
        state["slope"] = (turn(yaw) @ [ahead, left, 0.0])[:2]
        reference = question(values, body, state)["reference"]
        np.testing.assert_allclose(reference[:, 0], math.atan(left), atol=1e-12)
        np.testing.assert_allclose(reference[:, 1], -math.atan(ahead), atol=1e-12)


def test_standing_forces_add_up_to_the_weight_and_do_not_turn_the_body():
    found = forces(STANDING)
    np.testing.assert_allclose(found.sum(axis=0), [0.0, 0.0, WEIGHT], atol=0.02 * WEIGHT)
    body, _ = walking(STANDING)
    moment = np.cross(body["foot"] - body["centre"], found).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=0.5)


@pytest.mark.parametrize("time", [0.05, 0.25])
def test_trotting_forces_come_from_the_feet_that_stand(time):
    found = forces(TROTTING, time=time, velocity=(0.5, 0.1, 0.3))
    _, state = walking(TROTTING, time=time)
    air = state["swinging"] == 1
    assert air.sum() == 2
    np.testing.assert_array_equal(found[air], 0.0)
    assert found[~air, 2].sum() == pytest.approx(WEIGHT, rel=0.3)
    values = gait()
    assert (np.abs(found[:, :2]) <= values["mu"] * found[:, 2:] + 1e-9).all()
    assert (found[:, 2] <= values["max_force"]).all()


@pytest.mark.parametrize("mode", [STANDING, TROTTING])
def test_a_mirrored_robot_is_asked_for_mirrored_forces(mode):
    """Half a cycle later the other pair swings."""
    velocity, mirror = np.array([0.4, 0.15, 0.5]), np.array([1.0, -1.0, 1.0])
    found = forces(mode, EVEN, time=0.05, velocity=velocity)
    other = forces(mode, EVEN, time=0.05 + gait()["period"] / 2, velocity=velocity * [1, -1, -1])
    np.testing.assert_allclose(other, found[ACROSS] * mirror, atol=1e-5)


@pytest.mark.parametrize("pose", [(0.0, 0.0, math.pi / 2), (0.0, 0.0, math.pi), (50.0, -7.0, 0.0)])
def test_forces_do_not_depend_on_where_in_the_world_a_robot_is(pose):
    """Turned by quarters: friction is counted on in pyramids along the world's axes."""
    found = forces(TROTTING, velocity=(0.4, 0.1, 0.3))
    other = forces(TROTTING, velocity=(0.4, 0.1, 0.3), pose=pose)
    np.testing.assert_allclose(other, found @ turn(pose[2]).T, atol=1e-5)


def test_a_robot_off_its_reference_is_brought_back():
    def low(body, state):
        body["centre"][2] -= 0.03

    def ahead(body, state):
        state["place"][0] += 0.05

    def rolled(body, state):
        body["angles"][0] = 0.1

    still = forces(STANDING)
    assert forces(STANDING, change=low)[:, 2].sum() > still[:, 2].sum() + 10.0
    assert forces(STANDING, change=ahead)[:, 0].sum() > 5.0
    found = forces(STANDING, change=rolled)
    assert found[[1, 3], 2].sum() > found[[0, 2], 2].sum() + 5.0  # leaning to the right
