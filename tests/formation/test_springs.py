"""Springs and dampers against equations 3 to 5 of the paper, written out one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import LABORATORY_SPRINGS, SIMULATION_SPRINGS
from cavalcade.formation._shaping import SPRING, add_springs

PERIOD = 0.05
LAW = np.array([[4.5, 1.25, 0.40, 0.10, 0.04]])
PAIR = np.array([[0, 1]])


def spring_arrays(rest, laws):
    """Rest lengths `(C,)` and laws `(C, 5)` as the kernel takes them."""
    return np.array([(a, *law) for a, law in zip(rest, laws, strict=True)], dtype=SPRING)


def sprung(velocity, points, pairs, rest, laws, previous):
    """The kernel's lengths; velocities are changed in place."""
    return add_springs(velocity, points, pairs, spring_arrays(rest, laws), previous, PERIOD)


def reference(velocity, points, pairs, rest, laws, previous, period):
    """Equations 3, 4 and 5, in plain Python."""
    result = [list(v) for v in velocity]
    lengths = []
    for k, (a, b) in enumerate(pairs):
        if a < 0 or b < 0:
            lengths.append(math.nan)
            continue
        k_rep, k_att, dv_max_att, b_att, b_rep = laws[k]
        length = math.dist(points[a], points[b])
        lengths.append(length)
        if length == 0.0:
            continue
        if length < rest[k]:
            spring = -k_rep * (length - rest[k]) ** 2
        else:
            spring = min(k_att * (length - rest[k]) ** 2, dv_max_att)
        damper = 0.0
        if not math.isnan(previous[k]):
            rate = (length - previous[k]) / period
            damper = b_att * rate if rate < 0.0 else b_rep * rate
        for axis in (0, 1):
            unit = (points[b][axis] - points[a][axis]) / length
            result[a][axis] += (spring + damper) * unit
            result[b][axis] -= (spring + damper) * unit
    return np.array(result), np.array(lengths)


def pulled(length, rest=1.0, previous=math.nan, law=LAW):
    """Change of the first robot's speed towards the second."""
    velocity = np.zeros((2, 2))
    points = np.array([[0.0, 0.0], [length, 0.0]])
    sprung(velocity, points, PAIR, np.array([rest]), law, np.array([previous]))
    np.testing.assert_array_equal(velocity[1], -velocity[0])
    assert velocity[0, 1] == 0.0
    return velocity[0, 0]


@st.composite
def networks(draw):
    robots = draw(st.integers(2, 6))
    joints = draw(st.integers(0, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    pairs = np.array(
        [rng.choice(robots, 2, replace=False) for _ in range(joints)], dtype=np.int64
    ).reshape(-1, 2)
    pairs[rng.random(joints) < 0.2, rng.integers(2)] = -1
    previous = rng.uniform(0.0, 3.0, joints)
    previous[rng.random(joints) < 0.3] = np.nan
    return (
        rng.normal(size=(robots, 2)),
        rng.uniform(0.0, 3.0, (robots, 2)),
        pairs,
        rng.uniform(0.2, 2.0, joints),
        rng.uniform(0.0, 5.0, (joints, 5)),
        previous,
    )


@settings(max_examples=60, deadline=None)
@given(networks())
def test_kernel_and_reference_agree(network):
    velocity, *rest = network
    wanted, lengths = reference(velocity, *rest, PERIOD)
    found = velocity.copy()
    np.testing.assert_allclose(sprung(found, *rest), lengths, atol=1e-12)
    np.testing.assert_allclose(found, wanted, atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(networks())
def test_springs_never_move_the_team_as_a_whole(network):
    velocity, *rest = network
    found = velocity.copy()
    sprung(found, *rest)
    np.testing.assert_allclose(found.sum(axis=0), velocity.sum(axis=0), atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(networks())
def test_mirrored_springs_act_mirrored(network):
    velocity, points, *rest = network
    found, mirrored = velocity.copy(), velocity * (1, -1)
    sprung(found, points, *rest)
    sprung(mirrored, points * (1, -1), *rest)
    np.testing.assert_allclose(mirrored, found * (1, -1), atol=1e-12)


def test_at_rest_length_nothing_happens():
    assert pulled(1.0) == 0.0
    assert pulled(1.0, previous=1.0) == 0.0


@pytest.mark.parametrize(
    ("length", "change"),
    [(0.8, -4.5 * 0.04), (0.5, -4.5 * 0.25), (1.4, 1.25 * 0.16), (1.5657, 0.40), (3.0, 0.40)],
)
def test_the_papers_sides(length, change):
    assert pulled(length) == pytest.approx(change, abs=1e-4)


def test_the_papers_diagonals():
    law = SIMULATION_SPRINGS.diagonals
    laws = np.array([[law.k_rep, law.k_att, law.dv_max_att, law.b_att, law.b_rep]])
    assert pulled(1.0, rest=1.41, law=laws) == pytest.approx(-3.0 * 0.41**2)
    assert pulled(5.0, rest=1.41, law=laws) == pytest.approx(0.30)


def test_dampers_hold_back_both_ways_with_their_own_strength():
    # A damper opposes: approaching robots are pushed apart, departing ones drawn together.
    assert pulled(1.0, previous=1.02) == pytest.approx(0.10 * -0.4)
    assert pulled(1.0, previous=0.98) == pytest.approx(0.04 * 0.4)


def test_a_pair_that_has_just_been_formed_is_not_damped():
    assert pulled(0.8, previous=math.nan) == pytest.approx(-4.5 * 0.04)


def test_an_empty_slot_pulls_nobody():
    velocity = np.ones((2, 2))
    points = np.array([[0.0, 0.0], [5.0, 0.0]])
    lengths = sprung(velocity, points, np.array([[0, -1]]), np.ones(1), LAW, np.full(1, np.nan))
    assert np.isnan(lengths).all()
    assert (velocity == 1.0).all()


def test_two_robots_on_one_spot_are_left_alone():
    velocity = np.zeros((2, 2))
    sprung(velocity, np.ones((2, 2)), PAIR, np.ones(1), LAW, np.full(1, np.nan))
    assert (velocity == 0.0).all()


def test_the_laboratory_knows_one_law():
    assert LABORATORY_SPRINGS.sides == LABORATORY_SPRINGS.diagonals
