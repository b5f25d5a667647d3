"""CONNECT: ends, derivatives, time reversal, limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.kinodynamic._connect import (
    fastest,
    is_straight,
    make_walk,
    nominal_time,
    walk_problem,
    walk_state,
)
from cavalcade.kinodynamic._tree_extension import truncate
from cavalcade.kinodynamic.parameters import OK, SIZE, TIME, make_body, make_space
from cavalcade.lattice.surface import bilinear, surface
from cavalcade.robots import robot_model

BODY = make_body(robot_model("spirit"))
coordinate = st.floats(1.0, 7.0)
speed = st.floats(-1.5, 1.5)
state = st.tuples(coordinate, st.floats(1.0, 3.0), st.floats(0.15, 0.3), speed, speed, speed)


def _state(ground, values):
    out = np.array(values)
    out[2] += surface(ground, out[0], out[1])[0]
    return out


@settings(max_examples=60, deadline=None)
@given(state, state)
def test_it_has_both_states_at_its_ends_and_velocities_are_derivatives(rough, a, b):
    space = make_space(rough, BODY)
    walk, out = np.empty(SIZE), np.empty(6)
    s0, s1 = _state(rough, a), _state(rough, b)
    make_walk(space, s0, s1, walk)
    span = walk[TIME]
    if span < 0.01:
        return
    for t, expected in ((0.0, s0), (span, s1)):
        walk_state(space, walk, t, out)
        assert np.allclose(out, expected, atol=1e-7)
    before, after = np.empty(6), np.empty(6)
    for part in (0.21, 0.5, 0.83):
        h = 1e-5 * span
        walk_state(space, walk, part * span - h, before)
        walk_state(space, walk, part * span + h, after)
        walk_state(space, walk, part * span, out)
        slope = (after[:3] - before[:3]) / (2.0 * h)
        assert np.allclose(slope, out[3:], atol=2e-3 * (1.0 + np.abs(out[3:]).max()))
        assert math.hypot(out[3], out[4]) <= fastest(walk) + 1e-9


@settings(max_examples=60, deadline=None)
@given(state, state)
def test_reversed_in_time_it_is_the_same_way(rough, a, b):
    space = make_space(rough, BODY)
    walk, back, out, other = np.empty(SIZE), np.empty(SIZE), np.empty(6), np.empty(6)
    s0, s1 = _state(rough, a), _state(rough, b)
    make_walk(space, s0, s1, walk)
    if walk[TIME] < 0.01:
        return
    flip = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
    make_walk(space, s1 * flip, s0 * flip, back)
    assert back[TIME] == pytest.approx(walk[TIME])
    for part in (0.1, 0.5, 0.9):
        walk_state(space, walk, part * walk[TIME], out)
        walk_state(space, back, (1.0 - part) * walk[TIME], other)
        assert np.allclose(out, other * flip, atol=1e-7)


@settings(max_examples=60, deadline=None)
@given(state, state, st.floats(0.1, 0.9), st.booleans())
def test_a_part_of_it_is_a_connect_along_the_same_way(rough, a, b, part, backwards):
    space = make_space(rough, BODY)
    walk, out, other = np.empty(SIZE), np.empty(6), np.empty(6)
    make_walk(space, _state(rough, a), _state(rough, b), walk)
    piece = walk.copy()
    span = walk[TIME]
    if span < 0.01:
        return
    truncate(space, piece, backwards, part * span, np.empty(12))
    offset = (1.0 - part) * span if backwards else 0.0
    for share in (0.0, 0.4, 1.0):
        walk_state(space, piece, share * part * span, out)
        walk_state(space, walk, offset + share * part * span, other)
        assert np.allclose(out, other, atol=1e-6)


def test_nominal_time_is_the_papers():
    s0 = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.0])
    s1 = np.array([3.0, 4.0, 0.0, 0.3, 0.8, 0.0])
    assert nominal_time(s0, s1, 0.75) == pytest.approx(6.0 * 5.0 / (1.0 + 3.0))


def test_forces_stay_in_the_friction_cone(make_flat):
    space = make_space(make_flat(), BODY)
    walk = np.empty(SIZE)
    stop = np.array([2.0, 2.0, 0.3, 0.0, 0.0, 0.0])
    fast = np.array([2.3, 2.0, 0.3, 1.8, 0.0, 0.0])
    assert not make_walk(space, stop, fast, walk)
    near = np.array([2.02, 2.0, 0.3, 0.0, 0.0, 0.0])
    assert make_walk(space, stop, near, walk)
    assert 6.0 * 0.02 / walk[TIME] ** 2 <= BODY.mu * 9.81


@settings(max_examples=80, deadline=None)
@given(state, state)
def test_what_is_passed_over_is_free(cluttered, reference_solid, a, b):
    space = make_space(cluttered, BODY)
    model = robot_model("spirit")
    walk, out = np.empty(SIZE), np.empty(6)
    s0, s1 = (np.array([*v[:2], 0.3, *v[3:5], 0.0]) for v in (a, b))
    if not make_walk(space, s0, s1, walk):
        return
    found, _ = walk_problem(space, walk, False, np.empty(6))
    if found != OK:
        return
    count = math.ceil(walk[TIME] / 0.03)
    for k in range(count + 1):
        walk_state(space, walk, walk[TIME] * k / count, out)
        if math.hypot(out[3], out[4]) > 1e-3:
            yaw = math.atan2(out[4], out[3])
            assert not reference_solid(cluttered, model, out[0], out[1], yaw)


def test_both_directions_of_looking_agree(cluttered):
    space = make_space(cluttered, BODY)
    rng = np.random.default_rng(0)
    walk, scratch = np.empty(SIZE), np.empty(6)
    verdicts = []
    for _ in range(300):
        s0, s1 = np.zeros(6), np.zeros(6)
        s0[:3], s1[:3] = (*rng.uniform((1, 1), (7, 3)), 0.3), (*rng.uniform((1, 1), (7, 3)), 0.3)
        make_walk(space, s0, s1, walk)
        one = walk_problem(space, walk, False, scratch)
        two = walk_problem(space, walk, True, scratch)
        assert (one[0] == OK) == (two[0] == OK)
        assert is_straight(walk)
        verdicts.append(one[0])
    assert 30 < verdicts.count(OK) < 270


@settings(max_examples=60, deadline=None)
@given(st.floats(0.3, 8.7), st.floats(0.3, 3.7))
def test_the_surface_has_the_slope_it_says_and_is_near_bilinear_heights(rough, x, y):
    height, along_x, along_y = surface(rough, x, y)
    assert height == pytest.approx(bilinear(rough.smooth, rough.cell, x, y), abs=5e-3)
    h = 1e-6
    assert along_x == pytest.approx(
        (surface(rough, x + h, y)[0] - surface(rough, x - h, y)[0]) / (2 * h), abs=1e-5
    )
    assert along_y == pytest.approx(
        (surface(rough, x, y + h)[0] - surface(rough, x, y - h)[0]) / (2 * h), abs=1e-5
    )
