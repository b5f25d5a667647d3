"""Kernels of validity against the slow reference; random numbers; paths on the grid."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.kinodynamic._validity import (
    covered_slack,
    solid_free,
    solid_slack,
    state_problem,
    turn_on_spot,
    wrapped,
)
from cavalcade.kinodynamic.obstruction import grid_path
from cavalcade.kinodynamic.parameters import GROUND, OK, SOLID, make_body, make_space
from cavalcade.kinodynamic.random import normal, uniform
from cavalcade.lattice.surface import bilinear, surface
from cavalcade.robots import robot_model

SPIRIT = robot_model("spirit")
BODY = make_body(SPIRIT)
angle = st.floats(-math.pi, math.pi)


@settings(max_examples=300, deadline=None)
@given(st.floats(0.0, 9.0), st.floats(0.0, 4.0), angle, st.floats(0.05, 0.5), st.integers(0, 3))
def test_states_on_rough_ground(rough, reference_problem, x, y, yaw, clearance, phase):
    z = surface(rough, x, y)[0] + clearance
    c, s = math.cos(yaw), math.sin(yaw)
    state = np.array([x, y, z, 0.5 * c, 0.5 * s, 0.0])
    found = state_problem(make_space(rough, BODY), state, c, s, phase)
    pose = np.array([x, y, z, yaw])
    strict, loose = (reference_problem(rough, SPIRIT, pose, phase, e) for e in (-1e-9, 1e-9))
    if "solid" in (strict, loose):
        assert found == SOLID
    elif strict == loose:
        assert found == (OK if strict == "" else GROUND)


@settings(max_examples=300, deadline=None)
@given(st.floats(-0.5, 9.5), st.floats(-0.5, 4.5), angle)
def test_footprints_among_solids(cluttered, reference_solid, x, y, yaw):
    c, s = math.cos(yaw), math.sin(yaw)
    if solid_free(make_space(cluttered, BODY), x, y, c, s):
        assert not reference_solid(cluttered, SPIRIT, x, y, yaw)
    else:
        wider = BODY._replace(half_length=0.37, half_width=0.195)  # 2 cm: the reference has gaps
        touching = reference_solid(cluttered, _grown(SPIRIT, 0.05), x, y, yaw)
        assert touching
        assert not solid_free(make_space(cluttered, wider), x, y, c, s)


def _grown(model, by):
    from dataclasses import replace

    return replace(model, length=model.length + by, width=model.width + by)


@settings(max_examples=200, deadline=None)
@given(st.floats(0.0, 9.0), st.floats(0.0, 4.0), angle, angle, angle, st.floats(0.0, 1.0))
def test_nothing_is_met_within_the_slack(cluttered, x, y, yaw, way, other, part):
    """Wherever the body goes by less than that, it stays free."""
    c, s = math.cos(yaw), math.sin(yaw)
    space = make_space(cluttered, BODY)
    anywhere = solid_slack(space, x, y)
    if anywhere > 0.0:
        px, py = x + part * anywhere * math.cos(way), y + part * anywhere * math.sin(way)
        assert solid_free(space, px, py, math.cos(other), math.sin(other))
    ahead = covered_slack(space, x, y, c, s)
    if ahead > 0.0:
        px, py = x + part * ahead * math.cos(way), y + part * ahead * math.sin(way)
        assert solid_free(space, px, py, c, s)


def test_discs_and_speeds(make_flat):
    ground = make_flat()
    space = make_space(ground, BODY, np.array([[4.0, 2.0, 0.5]]))
    assert not solid_free(space, 4.4, 2.0, 1.0, 0.0)
    assert solid_free(space, 4.6, 2.0, 1.0, 0.0)
    assert solid_slack(space, 4.8, 2.0) == pytest.approx(0.3)
    for vx, verdict in ((1.99, OK), (2.01, 3)):
        state = np.array([4.0, 2.0, 0.3, vx, 0.0, 0.0])
        assert state_problem(make_space(ground, BODY), state, 1.0, 0.0, 0) == verdict


@settings(max_examples=100, deadline=None)
@given(st.floats(-1.0, 10.0), st.floats(-1.0, 5.0))
def test_bilinear_values_against_scipy(rough, x, y):
    from scipy.ndimage import map_coordinates

    at = [[y / rough.cell - 0.5], [x / rough.cell - 0.5]]
    expected = map_coordinates(rough.height, at, order=1, mode="nearest")[0]
    assert bilinear(rough.height, rough.cell, x, y) == pytest.approx(expected, abs=1e-9)


@given(st.floats(-20.0, 20.0))
def test_wrapped_angles(value):
    out = wrapped(value)
    assert -math.pi - 1e-9 <= out <= math.pi + 1e-9
    assert math.cos(out - value) == pytest.approx(1.0)


def test_turning_takes_the_long_way_where_the_short_one_is_blocked(make_flat):
    # The robot's front would sweep over the box on its left.
    state = np.array([4.0, 2.0, 0.3, 0.0, 0.0, 0.0])

    def turn(ground, yaw, wanted):
        return turn_on_spot(make_space(ground, BODY), state, yaw, wanted)

    ground = make_flat(boxes=((4.2, 2.25, 4.4, 2.45),))
    assert turn(make_flat(), -0.4, 1.6) == pytest.approx(2.0)
    around = turn(ground, -0.4, 1.6)
    assert math.isnan(around) or around == pytest.approx(2.0 - 2.0 * math.pi)
    shut = make_flat(boxes=((3.5, 2.2, 4.5, 2.5), (3.5, 1.5, 4.5, 1.8)))
    assert math.isnan(turn(shut, 0.0, 1.57))


def test_random_numbers_are_splitmix64():
    state = np.array([1234567], dtype=np.uint64)
    # The reference implementation's first outputs for this seed, over 2**64.
    first = [6457827717110365317, 3203168211198807973, 9817491932198370423]
    assert [uniform(state) for _ in first] == [(v >> 11) / 2**53 for v in first]
    draws = np.array([normal(state) for _ in range(20_000)])
    assert abs(draws.mean()) < 0.03
    assert abs(draws.std() - 1.0) < 0.03


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_paths_on_the_grid_are_shortest(seed):
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import shortest_path

    rng = np.random.default_rng(seed)
    rows, cols = rng.integers(1, 9, 2)
    passable = rng.random((rows, cols)) < 0.6
    start, goal = ((int(rng.integers(rows)), int(rng.integers(cols))) for _ in range(2))
    passable[start], passable[goal] = True, True
    links = np.zeros((rows * cols, rows * cols))
    for i, j in np.argwhere(passable):
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                a, b = i + di, j + dj
                if (di or dj) and 0 <= a < rows and 0 <= b < cols and passable[a, b]:
                    links[i * cols + j, a * cols + b] = 1.0
    least = shortest_path(csr_array(links), unweighted=True)
    expected = least[start[0] * cols + start[1], goal[0] * cols + goal[1]]
    path = grid_path(passable, start, goal)
    if len(path) == 0:
        assert math.isinf(expected)
        return
    assert tuple(path[0]) == start
    assert tuple(path[-1]) == goal
    assert passable[path[:, 0], path[:, 1]].all()
    steps = np.abs(np.diff(path, axis=0))
    assert steps.size == 0 or steps.max() == 1
    # Rings grow from both sides by turns, so that they meet at most one ring late.
    assert expected <= len(path) - 1 <= expected + 1


def test_a_model_without_legs_is_refused():
    from dataclasses import replace

    with pytest.raises(InputError, match="model: spirit has no legs"):
        make_body(replace(SPIRIT, legs=None))
