"""Distances to surfaces and velocity maps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.eikonal import surface_distance, velocity_map


def slow_distance(occupied, cell):
    """From each centre to each occupied square, one after the other."""
    rows, cols = occupied.shape
    result = np.full((rows, cols), np.inf)
    for r, c in np.ndindex(rows, cols):
        for i, j in np.argwhere(occupied):
            away = np.hypot(max(abs(r - i) - 0.5, 0.0), max(abs(c - j) - 0.5, 0.0))
            result[r, c] = min(result[r, c], away * cell)
    return result


@pytest.mark.parametrize("shape", [(1, 1), (1, 17), (17, 1), (12, 19)])
@pytest.mark.parametrize("share", [0.0, 0.03, 0.3, 1.0])
def test_distance_equals_brute_force(shape, share):
    occupied = np.random.default_rng(shape[0]).random(shape) < share
    distance = surface_distance(occupied, 0.25, border=False)
    np.testing.assert_allclose(distance, slow_distance(occupied, 0.25), rtol=1e-12)


def test_border_counts_as_occupied():
    occupied = np.random.default_rng(5).random((9, 14)) < 0.05
    framed = np.pad(occupied, 1, constant_values=True)
    expected = slow_distance(framed, 0.1)[1:-1, 1:-1]
    np.testing.assert_allclose(surface_distance(occupied, 0.1), expected, rtol=1e-12)


def test_distance_changes_by_no_more_than_the_way():
    occupied = np.random.default_rng(6).random((40, 50)) < 0.02
    distance = surface_distance(occupied, 0.05)
    for axis in (0, 1):
        assert np.abs(np.diff(distance, axis=axis)).max() <= 0.05 + 1e-12


def test_distance_takes_any_memory_order():
    occupied = np.random.default_rng(7).random((30, 20)) < 0.05
    expected = surface_distance(occupied, 0.05)
    np.testing.assert_array_equal(surface_distance(np.asfortranarray(occupied), 0.05), expected)
    np.testing.assert_allclose(surface_distance(occupied.T, 0.05), expected.T, rtol=1e-12)


def test_velocity_rises_from_the_inflated_obstacle_to_one():
    distance = np.array([[0.0, 0.29, 0.3, 0.6, 1.05, 1.8, 5.0, np.inf]])
    np.testing.assert_allclose(
        velocity_map(distance, 0.3, 1.5), [[0.0, 0.0, 0.0, 0.2, 0.5, 1.0, 1.0, 1.0]]
    )


@pytest.mark.parametrize("safe", [0.05, 0.5, 1.5, 6.0])
def test_velocity_blocks_what_has_less_than_a_millimetre_of_room(safe):
    room = np.linspace(-0.002, 0.01, 241)[None]
    speed = velocity_map(0.3 + room, 0.3, safe)
    # Nobody crawls: the slowest cell has the pace of a whole millimetre.
    assert (speed[room < 0.999e-3] == 0.0).all()
    assert (speed[room > 1.001e-3] >= 0.999e-3 / safe).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 5.0), st.floats(0.01, 5.0))
def test_velocity_maps_of_all_safe_distances_block_the_same_cells(seed, one, other):
    """What one map calls free the other must not close: ways on both would disagree."""
    rng = np.random.default_rng(seed)
    distance = 0.3 + rng.uniform(-0.003, 0.003, (8, 8))
    a, b = velocity_map(distance, 0.3, one), velocity_map(distance, 0.3, other)
    np.testing.assert_array_equal(a == 0.0, b == 0.0)


def test_velocity_leaves_its_argument_alone():
    distance = np.array([[0.3005, 0.5, 2.0]])
    kept = distance.copy()
    velocity_map(distance, 0.3, 0.5)
    np.testing.assert_array_equal(distance, kept)
