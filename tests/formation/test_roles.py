"""Who leads, and who takes which slot."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import Formation
from cavalcade.formation.roles import (
    assign_followers,
    assign_goals,
    choose_leader,
    follower_rings,
)
from cavalcade.geometry import rotation, wrap_angle

LEAD = 0.05

KINDS = {
    "line": Formation.line,
    "column": Formation.column,
    "wedge": Formation.wedge,
    "circle": Formation.circle,
}


class TestLeader:
    def test_the_fastest_leads(self):
        assert choose_leader(np.array([3.0, 2.0, 2.5]), -1, LEAD) == 1

    @pytest.mark.parametrize(
        ("challenger", "leader"), [(1.99, 0), (1.951, 0), (1.949, 1), (1.5, 1)]
    )
    def test_a_challenger_must_be_faster_by_d_switch(self, challenger, leader):
        assert choose_leader(np.array([2.0, challenger]), 0, LEAD) == leader

    def test_two_equals_do_not_take_turns(self):
        rng = np.random.default_rng(1)
        leader, changes = 0, 0
        for _ in range(200):
            eta = 5.0 + rng.uniform(-0.02, 0.02, 2)
            new = choose_leader(eta, leader, LEAD)
            changes += new != leader
            leader = new
        assert changes == 0

    def test_a_leader_without_a_way_is_replaced(self):
        assert choose_leader(np.array([np.inf, 9.0]), 0, LEAD) == 1

    def test_without_any_way_nobody_leads(self):
        assert choose_leader(np.full(3, np.inf), 1, LEAD) == -1

    def test_a_leader_that_is_not_there_is_replaced(self):
        assert choose_leader(np.array([4.0, 3.0]), 7, LEAD) == 1


class TestRings:
    @pytest.mark.parametrize("shape", [Formation.square(), Formation.triangle()])
    def test_where_the_order_is_clear_there_is_one_ring(self, shape):
        assert [len(ring) for ring in follower_rings(shape.slots)] == [shape.size - 1]

    def test_a_column_has_a_ring_per_robot(self):
        rings = follower_rings(Formation.column(6).slots)
        assert [ring.tolist() for ring in rings] == [[1], [2], [3], [4], [5]]

    def test_a_wedge_has_a_ring_per_row(self):
        rings = follower_rings(Formation.wedge(7).slots)
        assert [sorted(ring.tolist()) for ring in rings] == [[1, 2], [3, 4], [5, 6]]

    def test_a_line_has_a_ring_per_distance(self):
        rings = follower_rings(Formation.line(5).slots)
        assert [sorted(ring.tolist()) for ring in rings] == [[1, 2], [3, 4]]

    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("robots", [1, 2, 3, 8, 17, 32])
    def test_every_follower_slot_is_in_one_ring(self, kind, robots):
        rings = follower_rings(KINDS[kind](robots).slots)
        assert sorted(slot for ring in rings for slot in ring) == list(range(1, robots))


def angles(points, leader, heading, robots):
    """Angles around the leader, counted from straight behind it."""
    offset = points[robots] - points[leader]
    return wrap_angle(np.arctan2(offset[:, 1], offset[:, 0]) - heading - np.pi)


@st.composite
def teams(draw, least=1):
    kind, robots = draw(st.sampled_from(sorted(KINDS))), draw(st.integers(least, 32))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    points = rng.uniform(0.0, 5.0, (robots + 3, 2))
    active = np.sort(rng.choice(robots + 3, robots, replace=False))
    heading = draw(st.floats(-np.pi, np.pi))
    return KINDS[kind](robots), points, active, int(rng.choice(active)), heading


@settings(max_examples=80, deadline=None)
@given(teams())
def test_roles_are_a_bijection(team):
    shape, points, active, leader, heading = team
    roles = assign_followers(points, leader, heading, shape.slots, active)
    assert roles[leader] == 0
    assert sorted(roles[active]) == list(range(shape.size))
    assert (np.delete(roles, active) == -1).all()


@settings(max_examples=80, deadline=None)
@given(teams())
def test_within_a_ring_the_angular_order_is_kept(team):
    shape, points, active, leader, heading = team
    roles = assign_followers(points, leader, heading, shape.slots, active)
    for ring in follower_rings(shape.slots):
        robots = np.nonzero(np.isin(roles, ring))[0]
        robots = robots[np.argsort(angles(points, leader, heading, robots))]
        slots = angles(shape.slots, 0, 0.0, roles[robots])
        assert (np.diff(slots) >= -1e-9).all()


@settings(max_examples=60, deadline=None)
@given(teams())
def test_inner_rings_are_filled_by_nearer_robots(team):
    shape, points, active, leader, heading = team
    roles = assign_followers(points, leader, heading, shape.slots, active)
    away = np.hypot(*(points - points[leader]).T)
    reach = 0.0
    for ring in follower_rings(shape.slots):
        members = away[np.isin(roles, ring)]
        assert members.min() >= reach
        reach = members.max()


def mirror_slots(shape):
    """For each slot the one that it becomes when left and right are exchanged."""
    gap = np.hypot(*(shape.slots[:, None] * (1, -1) - shape.slots[None]).transpose(2, 0, 1))
    return gap.argmin(axis=1)


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([Formation.square(), Formation.triangle(), Formation.circle(7),
                     Formation.wedge(5), Formation.wedge(9), Formation.line(7)]),
    st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_mirrored_teams_get_mirrored_roles(shape, seed):
    rng = np.random.default_rng(seed)
    points, heading = rng.uniform(0.0, 4.0, (shape.size, 2)), rng.uniform(-3.0, 3.0)
    everyone = np.arange(shape.size)
    roles = assign_followers(points, 0, heading, shape.slots, everyone)
    mirrored = assign_followers(points * (1, -1), 0, -heading, shape.slots, everyone)
    np.testing.assert_array_equal(mirrored, mirror_slots(shape)[roles])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("robots", [1, 2, 5, 10, 12, 20, 32])
def test_who_stands_in_a_slot_keeps_it(kind, robots):
    """Whatever small noise does to places that are equal in angle or distance."""
    rng = np.random.default_rng(robots)
    shape = KINDS[kind](robots)
    order = rng.permutation(robots)
    for heading in (0.0, 2.0):
        points = shape.slots[order] @ rotation(heading).T + rng.normal(0.0, 0.003, (robots, 2))
        leader = int(np.argmin(order))
        roles = assign_followers(points, leader, heading, shape.slots, np.arange(robots))
        np.testing.assert_array_equal(roles, order)


def test_the_least_sum_of_squares_wins():
    rng = np.random.default_rng(2)
    for _ in range(20):
        points, goals = rng.uniform(0, 3, (5, 2)), rng.uniform(0, 3, (4, 2))
        active = np.array([0, 2, 3, 4])
        roles = assign_goals(points, goals, active)
        cost = {
            slots: sum(
                ((points[k] - goals[s]) ** 2).sum() for k, s in zip(active, slots, strict=True)
            )
            for slots in permutations(range(4))
        }
        assert cost[tuple(roles[active])] == pytest.approx(min(cost.values()))
        assert roles[1] == -1


def test_squares_spread_the_effort_where_plain_distances_do_not():
    """Three in a row move up by one each, rather than one of them by three."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    goals = np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    assert assign_goals(points, goals, np.arange(3)).tolist() == [0, 1, 2]
