"""Swings and footholds: smooth, clear of the ground, on places that carry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.locomotion._kinematics import measure_body
from cavalcade.locomotion._swing import (
    LEANING,
    LEAST,
    SEARCH,
    SHIFT,
    SHIFTS,
    choose_foothold,
    place_foot,
    shank_clears,
    smooth,
    swing_point,
    to_ground,
)
from cavalcade.locomotion.parameters import robot_parameters
from cavalcade.locomotion.records import BODY, STATE, Footing, Measured
from cavalcade.locomotion.settings import GaitSettings
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

GO1 = robot_model("go1").description
PARAMETERS = robot_parameters(GO1)[()]
CELL = 0.05
FLAT = Footing.of(make_ground(OccupancyMap(np.zeros((1, 1), dtype=bool), 1.0)), (0.0, 0.0, 0.0))

metres = st.floats(-0.5, 0.5)
places = st.tuples(metres, metres, st.floats(-0.2, 0.2)).map(np.array)


def gait(**values):
    return GaitSettings(**values).row(GO1.mass, GO1.stand_height)[()]


def standing(pose=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)):
    """Body and state of a robot that stands or moves over flat ground; velocity in the world."""
    x, y, yaw = pose
    qpos = np.concatenate(
        [[x, y, GO1.stand_height, np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)], GO1.standing]
    )
    body, state = np.zeros(1, BODY)[0], np.zeros(1, STATE)[0]
    qvel = np.concatenate([velocity[:2], [0, 0, 0, velocity[2]], np.zeros(12)])
    measure_body(PARAMETERS, Measured(0.0, qpos, qvel, np.zeros(4)), body)
    state["lifted"] = body["foot"]
    return body, state


def field(seed, frame=(0.0, 0.0, 0.0), rows=40, cols=60):
    """Footing of random heights of which a third carries nothing."""
    rng = np.random.default_rng(seed)
    shape = (rows, cols)
    zero = np.zeros(shape)
    bad = rng.random(shape) < 0.33
    share = np.where(bad, rng.uniform(0.0, LEAST - 1e-6, shape), rng.uniform(LEAST, 1.0, shape))
    height = rng.uniform(0.0, 0.1, shape)
    solid = rng.random(shape) < 0.05
    return Footing.of(Ground(CELL, solid, zero, False, height, height, zero, zero, share), frame)


def point(lifted, landing, apex, share, lasts=0.2):
    place, velocity = np.empty(3), np.empty(3)
    swing_point(lifted, landing, apex, share, lasts, place, velocity)
    return place, velocity


@given(places, places, st.floats(0.0, 0.3))
@settings(deadline=None)
def test_swings_begin_end_and_turn_at_rest_where_they_should(lifted, landing, over):
    apex = max(lifted[2], landing[2]) + over
    for share, height, still in ((0.0, lifted[2], 3), (0.5, apex, 0), (1.0, landing[2], 3)):
        place, velocity = point(lifted, landing, apex, share)
        assert place[2] == pytest.approx(height, abs=1e-12)
        assert velocity[2] == pytest.approx(0.0, abs=1e-12)
        np.testing.assert_allclose(velocity[:still], 0.0, atol=1e-12)
    np.testing.assert_allclose(point(lifted, landing, apex, 0.0)[0], lifted, atol=1e-12)
    np.testing.assert_allclose(point(lifted, landing, apex, 1.0)[0], landing, atol=1e-12)


@given(places, places, st.floats(0.01, 0.99))
@settings(deadline=None)
def test_a_swings_velocity_is_its_derivative(lifted, landing, share):
    step, lasts = 1e-6, 0.2
    ahead, behind = (point(lifted, landing, 0.3, share + s * step)[0] for s in (1.0, -1.0))
    found = point(lifted, landing, 0.3, share, lasts)[1]
    np.testing.assert_allclose(found, (ahead - behind) / (2.0 * step * lasts), atol=1e-6)


def test_the_smooth_share_rises_from_0_to_1():
    values = np.array([smooth(t) for t in np.linspace(0.0, 1.0, 101)])
    assert (np.diff(values[:, 0]) > 0.0).all()
    assert values[0].tolist() == [0.0, 0.0]
    assert values[-1] == pytest.approx([1.0, 0.0])


@pytest.mark.parametrize("leg", range(4))
@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (3.0, -2.0, 2.5)])
def test_a_robot_that_stands_puts_its_feet_back_where_they_are(leg, pose):
    body, state = standing(pose)
    choose_foothold(PARAMETERS, gait(), body, state, leg, 0.1, FLAT)
    np.testing.assert_allclose(state["landing"][leg], body["foot"][leg], atol=1e-9)
    radius, clearance = GO1.foot_radius, gait()["clearance"]
    assert state["apex"][leg] == pytest.approx(radius + clearance, abs=1e-9)


@pytest.mark.parametrize("yaw", [0.0, 1.1])
def test_footholds_lead_by_the_way_until_the_middle_of_the_stance(yaw):
    """Raibert: so far ahead that the hip is above the foot in the middle of its stance."""
    speed, left, values = np.array([0.6, -0.2]), 0.07, gait()
    c, s = np.cos(yaw), np.sin(yaw)
    body, state = standing((1.0, 2.0, yaw), (*(np.array([[c, -s], [s, c]]) @ speed), 0.0))
    state["velocity"] = *speed, 0.0
    choose_foothold(PARAMETERS, values, body, state, 1, left, FLAT)
    lead = (state["landing"][1] - body["foot"][1])[:2]
    until = left + 0.5 * values["duty"] * values["period"]
    np.testing.assert_allclose(lead @ [[c, -s], [s, c]], until * speed, atol=1e-9)


def test_footholds_catch_a_body_that_is_faster_than_wanted():
    leads = []
    for capture in (0.0, 0.1):
        body, state = standing(velocity=(0.5, 0.3, 0.0))
        state["velocity"] = 0.2, 0.0, 0.0
        choose_foothold(PARAMETERS, gait(capture=capture), body, state, 0, 0.1, FLAT)
        leads.append(state["landing"][0].copy())
    np.testing.assert_allclose(leads[1] - leads[0], [0.03, 0.03, 0.0], atol=1e-9)


def test_footholds_turn_with_the_commanded_turn():
    """On the spot, each foot lands on the circle of the hips, turned on by what is to come."""
    values, left, rate = gait(), 0.1, 1.0
    body, state = standing()
    state["velocity"] = 0.0, 0.0, rate
    turn = rate * (left + 0.5 * values["duty"] * values["period"])
    c, s = np.cos(turn), np.sin(turn)
    for leg in range(4):
        choose_foothold(PARAMETERS, values, body, state, leg, left, FLAT)
        wanted = np.array([[c, -s], [s, c]]) @ body["foot"][leg, :2]
        np.testing.assert_allclose(state["landing"][leg, :2], wanted, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("frame", [(0.0, 0.0, 0.0), (5.0, -3.0, 0.8)])
def test_feet_land_on_the_nearest_ground_that_carries_and_swing_clear(seed, frame):
    ground, values = field(seed, frame), gait()
    c, s = np.cos(frame[2]), np.sin(frame[2])
    rng = np.random.default_rng(seed)
    moved = 0
    for _ in range(100):
        u, v = rng.uniform([0.3, 0.3], [2.7, 1.7])
        x, y = frame[0] + c * u - s * v, frame[1] + s * u + c * v
        _, state = standing()
        start = rng.normal(0.0, 0.1, 2)
        state["lifted"][0] = x + start[0], y + start[1], 0.1
        place_foot(PARAMETERS, values, state, 0, x, y, ground)
        a, b = to_ground(ground.frame, *state["landing"][0, :2])
        row, col = int(b / CELL), int(a / CELL)
        middles = np.argwhere(~ground.solid & (ground.traversability >= LEAST))[:, ::-1]
        away = np.hypot(*((middles + 0.5) * CELL - (u, v)).T).min()
        assert away < SEARCH, "a field on which every foot finds a place"
        assert not ground.solid[row, col]
        assert ground.traversability[row, col] >= LEAST
        shift = np.hypot(a - u, b - v)
        assert shift < 1e-9 or shift == pytest.approx(away, abs=1e-9)
        moved += shift > 1e-9
        assert state["apex"][0] >= max(0.1, state["landing"][0, 2]) + values["clearance"] - 1e-12
    assert 10 < moved < 90


def test_a_foot_with_no_good_place_near_goes_where_it_was_wanted():
    ground = field(0)
    ground = ground._replace(traversability=np.zeros_like(ground.traversability))
    _, state = standing()
    place_foot(PARAMETERS, gait(), state, 2, 1.013, 0.987, ground)
    np.testing.assert_array_equal(state["landing"][2, :2], [1.013, 0.987])


def test_a_swing_goes_over_what_stands_between():
    ground = field(0)
    height = np.zeros_like(ground.height)
    height[:, 20:24] = 0.15
    ground = ground._replace(height=height, solid=np.zeros_like(ground.solid),
                             traversability=np.ones_like(height))  # fmt: skip
    _, state = standing()
    state["lifted"][0] = 0.8, 1.0, GO1.foot_radius
    place_foot(PARAMETERS, gait(), state, 0, 1.4, 1.0, ground)
    wanted = 0.15 + GO1.foot_radius + gait()["clearance"]
    assert state["apex"][0] == pytest.approx(wanted)
    assert state["landing"][0, 2] == pytest.approx(GO1.foot_radius)


@pytest.mark.parametrize("yaw", [0.0, 0.7, np.pi])
def test_below_a_step_feet_keep_room_for_their_calves(yaw):
    """Going down, knees bend backwards: right below a riser the calf would lie on its edge."""
    ground = field(0, (0.0, 0.0, yaw))
    cells = (np.arange(ground.height.shape[1]) + 0.5) * CELL
    across = np.full_like(ground.height, 1.0) * (cells < 1.0)
    ground = ground._replace(height=0.08 * across, solid=np.zeros_like(ground.solid),
                             traversability=np.ones_like(ground.height))  # fmt: skip
    c, s = np.cos(yaw), np.sin(yaw)

    def clears(ahead):
        x, y = c * ahead - s * 1.0, s * ahead + c * 1.0
        return shank_clears(PARAMETERS, ground, x, y, c, s)

    assert not clears(1.0 + CELL)
    assert clears(1.0 + LEANING * 0.213 + 2.0 * CELL)
    assert clears(1.0 - CELL)
    assert clears(0.5)
    # The other way round the step is ahead, where no calf is.
    x, y = c * (1.0 + CELL) - s * 1.0, s * (1.0 + CELL) + c * 1.0
    assert shank_clears(PARAMETERS, ground, x, y, -c, -s)


def test_a_foothold_at_the_foot_of_a_step_is_moved_by_little_and_to_room():
    ground = field(0)
    cells = (np.arange(ground.height.shape[1]) + 0.5) * CELL
    height = 0.08 * (cells < 1.0) * np.ones_like(ground.height)
    ground = ground._replace(height=height, solid=np.zeros_like(ground.solid),
                             traversability=np.ones_like(height))  # fmt: skip
    moved = 0
    for x in np.linspace(0.6, 1.4, 41):
        body, state = standing((x, 1.0, 0.0))
        choose_foothold(PARAMETERS, gait(), body, state, 0, 0.0, FLAT)
        wanted = state["landing"][0, 0]
        choose_foothold(PARAMETERS, gait(), body, state, 0, 0.0, ground)
        shift = state["landing"][0, 0] - wanted
        assert abs(shift) <= SHIFT * SHIFTS + 1e-9
        free = shank_clears(PARAMETERS, ground, wanted, state["landing"][0, 1], 1.0, 0.0)
        assert free == (abs(shift) < 1e-9)
        if not free:
            moved += 1
            assert shank_clears(PARAMETERS, ground, *state["landing"][0, :2], 1.0, 0.0)
    assert moved >= 2
