"""Two robots in each other's way exchange their slots."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation.deadlock import PATIENCE, SlotExchange

MARGIN = 0.2  # s that an exchange must gain, or may cost


class Times:
    """A goal to which the times `(N, S)` of each robot to each slot are given outright."""

    def __init__(self, eta, points):
        self.eta, self.points = np.asarray(eta, dtype=float), points
        self.places = np.zeros((self.eta.shape[1], 2))

    def slot_field(self, slot, points_of_team):
        times, points = self.eta[:, slot], self.points

        class Field:
            def eta(self, point):
                return float(times[np.flatnonzero((points == point).all(axis=1))[0]])

            def nearest_reached(self, point, reach):
                return None

        return Field()


def row_of(robots):
    """Points 1 m apart: neighbours are near each other, others are not."""
    return np.column_stack([np.arange(robots, dtype=float), np.zeros(robots)])


def exchanged(eta, roles, rounds=1, points=None):
    """Roles after each round, from the given ones on; robots stand still."""
    eta = np.asarray(eta, dtype=float)
    points = row_of(len(eta)) if points is None else np.array(points)
    goal, active = Times(eta, points), np.arange(len(eta))
    exchange = SlotExchange(len(eta), np.array(roles))
    times = (k * (PATIENCE + 0.1) for k in range(rounds))
    return [exchange.assign(goal, points, active, time).tolist() for time in times]


@st.composite
def pairs(draw):
    time = st.floats(0.0, 20.0)
    return [[draw(time), draw(time)], [draw(time), draw(time)]]


class TestExchange:
    def test_it_begins_with_the_least_sum_of_squares(self):
        rng = np.random.default_rng(4)
        for robots in (1, 2, 3, 5):
            eta = rng.uniform(0.0, 9.0, (robots, robots))
            points = row_of(robots)
            roles = SlotExchange(robots).assign(Times(eta, points), points, np.arange(robots), 0.0)
            best = min(
                sum(eta[k, slot] ** 2 for k, slot in enumerate(order))
                for order in itertools.permutations(range(robots))
            )
            longest = max(eta[k, slot] for k, slot in enumerate(roles))
            found = sum(eta[k, slot] ** 2 for k, slot in enumerate(roles))
            # The first round may have exchanged already, for a shorter longest way.
            assert found == pytest.approx(best) or longest**2 < best
            assert sorted(roles) == list(range(robots))

    @settings(max_examples=200, deadline=None)
    @given(pairs(), st.booleans())
    def test_an_exchange_lowers_the_sum_of_squared_times(self, eta, near):
        """Wherever the two stand; so the longer way never gets longer for nothing."""
        (a, b), (c, d) = eta
        points = [(0.0, 0.0), (1.0 if near else 3.0, 0.0)]
        (roles,) = exchanged(eta, [0, 1], points=points)
        straight, crossed = a**2 + d**2, b**2 + c**2
        if roles == [1, 0]:
            assert crossed < straight
            assert min(crossed, straight) < straight - 0.05
        else:
            assert roles == [0, 1]
            assert crossed > 0.95 * straight - 0.11

    @settings(max_examples=200, deadline=None)
    @given(pairs(), st.booleans())
    def test_a_pair_exchanges_once_and_for_all(self, eta, near):
        points = [(0.0, 0.0), (1.0 if near else 3.0, 0.0)]
        says = exchanged(eta, [0, 1], 5, points)
        assert all(roles == says[0] for roles in says)

    @settings(max_examples=60, deadline=None)
    @given(st.integers(0, 2**32 - 1), st.integers(3, 6))
    def test_of_a_team_neither(self, seed, robots):
        rng = np.random.default_rng(seed)
        eta = rng.uniform(0.0, 15.0, (robots, robots))
        before = list(rng.permutation(robots))
        for roles in exchanged(eta, before, 8):
            assert sorted(roles) == list(range(robots))
            sums = [sum(eta[k, slot] ** 2 for k, slot in enumerate(r)) for r in (before, roles)]
            assert sums[1] <= sums[0] + 1e-9
            before = roles

    def test_a_team_that_stands_settles(self):
        points = np.array([[1.6, 1.5], [1.8, 0.3], [1.8, 1.0]])
        slots = np.array([[2.4, 1.0], [2.1, 0.0], [0.2, 0.5]])
        eta = 2.0 * np.hypot(*(points[:, None] - slots[None]).transpose(2, 0, 1))
        says = exchanged(eta, [0, 1, 2], 40, points)
        assert says[-1] == says[-2] == says[-3]

    def test_two_nose_to_nose_exchange(self):
        """Each stands on the other's way: neither need pass."""
        eta = [[2.0, 6.0], [6.0, 2.0]]
        assert exchanged(eta, [1, 0]) == [[0, 1]]
        assert exchanged(eta, [0, 1]) == [[0, 1]]

    def test_a_way_is_better_than_none(self):
        assert exchanged([[math.inf, 3.0], [4.0, 5.0]], [0, 1]) == [[1, 0]]
        assert exchanged([[math.inf] * 2] * 2, [0, 1]) == [[0, 1]]

    def test_a_pair_rests_after_an_exchange(self):
        """Even if the ways turn round at once."""
        points, active = row_of(2), np.arange(2)
        there, back = (Times(eta, points) for eta in ([[2, 6], [6, 2]], [[6, 2], [2, 6]]))
        exchange = SlotExchange(2)
        exchange.assign(there, points, active, 0.0)
        assert exchange.assign(back, points, active, 1.0).tolist() == [1, 0]
        assert exchange.assign(there, points, active, 1.5).tolist() == [1, 0]
        assert exchange.assign(there, points, active, 1.0 + PATIENCE - 0.1).tolist() == [1, 0]
        assert exchange.assign(there, points, active, 1.0 + PATIENCE).tolist() == [0, 1]

    def test_those_that_take_no_part_have_no_slot(self):
        points, active = row_of(3), np.array([0, 2])
        goal = Times([[1.0, 5.0], [0.0, 0.0], [5.0, 1.0]], points)
        assert SlotExchange(3).assign(goal, points, active, 0.0).tolist() == [0, -1, 1]

    def test_what_it_returns_is_the_callers(self):
        points, active = row_of(2), np.arange(2)
        goal, exchange = Times([[2, 6], [6, 2]], points), SlotExchange(2)
        exchange.assign(goal, points, active, 0.0)[:] = -1
        assert exchange.assign(goal, points, active, 0.1).tolist() == [0, 1]
