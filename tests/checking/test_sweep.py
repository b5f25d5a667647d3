"""Adaptive halving against a dense look at the same motion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.checking.sweep import GAP_ERROR, TOUCH, closest_approach, first_contact


def flight(start, step, radius):
    """Distance of a point that moves evenly from the disc around the origin, and its reach."""
    start, step = np.array(start), np.array(step)

    def distance(rows, fraction):
        place = start + fraction[:, None] * step
        return np.maximum(np.hypot(place[:, 0], place[:, 1]) - radius, 0.0)

    return distance, np.array([np.hypot(*step)])


number = st.floats(-50.0, 50.0)


@settings(max_examples=200, deadline=None)
@given(start=st.tuples(number, number), step=st.tuples(number, number), radius=st.floats(1e-3, 1.0))
def test_contact_and_gap_are_those_of_the_exact_solution(start, step, radius):
    distance, reach = flight(start, step, radius)
    found = closest_approach(distance, reach, np.array([-1.0]), np.inf)
    square = max(float(np.dot(step, step)), 1e-300)
    nearest = np.clip(-np.dot(start, step) / square, 0.0, 1.0)
    exact = max(float(np.hypot(*(np.array(start) + nearest * np.array(step)))) - radius, 0.0)
    if len(found.contact):
        assert exact <= TOUCH
        first = first_contact(distance, float(reach[0]), 0, float(found.fraction[0]))
        assert 0.0 <= first <= found.fraction[0]
        assert distance(np.array([0]), np.array([first]))[0] <= 2 * TOUCH
    else:
        assert exact > 0.0
        assert exact - 1e-9 <= found.gap <= exact + GAP_ERROR


def test_first_contact_is_the_first():
    distance, reach = flight((-10.0, 0.0), (20.0, 0.0), 1.0)
    assert first_contact(distance, float(reach[0]), 0, 0.5) == pytest.approx(0.45, abs=1e-6)


def test_a_graze_far_shorter_than_the_interval():
    distance, reach = flight((-1e4, 0.0999999), (2e4, 0.0), 0.1)
    found = closest_approach(distance, reach, np.array([0.0]), np.inf)
    assert found.contact.tolist() == [0]


def test_what_is_surely_farther_than_the_known_gap_is_not_looked_at():
    def distance(rows, fraction):
        raise AssertionError("not needed")

    found = closest_approach(distance, np.array([1.0]), np.array([0.5]), 0.2)
    assert found.gap == 0.2


def test_no_candidates():
    distance, _ = flight((0.0, 0.0), (0.0, 0.0), 1.0)
    assert closest_approach(distance, np.empty(0), np.empty(0), 0.7).gap == 0.7
