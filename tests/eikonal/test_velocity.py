"""Distances to surfaces and velocity maps."""

from __future__ import annotations

import numpy as np
import pytest

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


def test_velocity_has_no_crawling_cells():
    # Less than a millimetre from the inflated obstacle is in it.
    speed = velocity_map(0.3 + np.linspace(0.0, 0.01, 200)[None], 0.3, 1.5)
    assert ((speed == 0.0) | (speed >= 1e-3 / 1.5)).all()
    assert 10 < (speed == 0.0).sum() < 25
