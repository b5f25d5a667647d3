"""Obstacle avoidance against Algorithm 1 of the paper."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cavalcade.eikonal import surface_distance, velocity_map
from cavalcade.formation._shaping import avoid_obstacles, sobel

CELL, SAFE, W_MIN = 0.05, 0.50, 0.50


def slope(rows=24, cols=24):
    """W_B in front of a plain wall on the left: it rises by CELL / SAFE per column."""
    return np.broadcast_to(np.minimum((np.arange(cols) + 0.5) * CELL / SAFE, 1.0), (rows, cols))


def at(row, col):
    """A point in a cell, off its centre."""
    return np.array([(col + 0.3) * CELL, (row + 0.6) * CELL])


def avoid(velocity, point, speed):
    changed = np.array([velocity], dtype=float)
    avoid_obstacles(changed, np.array([point]), np.array(speed), CELL, SAFE, W_MIN)
    return changed[0]


def reference(velocity, point, speed):
    """Algorithm 1 line by line, with the Sobel operator as the textbooks have it."""
    kernel = np.array([[-1.0, 0.0, 1.0], [-2.0, 0.0, 2.0], [-1.0, 0.0, 1.0]]) / 8.0
    along = ndimage.correlate(speed, kernel, mode="constant")
    across = ndimage.correlate(speed, kernel.T, mode="constant")
    row, col = int(point[1] // CELL), int(point[0] // CELL)
    w = speed[row, col]
    gradient = np.array([along[row, col], across[row, col]])
    if w < 1.0 and gradient @ velocity < 0.0 and np.hypot(*gradient) > CELL / (2.0 * SAFE):
        projection = (gradient @ velocity) / (gradient @ gradient) * gradient
        alpha = np.interp(w, [W_MIN, 1.0], [1.0, 0.0])
        return velocity - alpha * projection
    return velocity


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_kernel_and_reference_agree(seed):
    rng = np.random.default_rng(seed)
    occupied = rng.random((20, 24)) < 0.02
    speed = velocity_map(surface_distance(occupied, CELL), 0.1, SAFE)
    points = rng.uniform(0.0, (24 * CELL, 20 * CELL), (12, 2))
    velocities = rng.normal(size=(12, 2))
    for point, velocity in zip(points, velocities, strict=True):
        np.testing.assert_allclose(
            avoid(velocity, point, speed), reference(velocity, point, speed), atol=1e-9
        )


def test_the_gradient_of_a_plain_slope_is_one_cell_over_the_safe_distance():
    speed, step = np.array(slope()), CELL / SAFE
    turned = np.ascontiguousarray(speed.T)
    np.testing.assert_allclose(sobel(speed, 12, 5), (step, 0.0), atol=1e-12)
    np.testing.assert_allclose(sobel(turned, 5, 12), (0.0, step), atol=1e-12)
    np.testing.assert_allclose(sobel(speed[:, ::-1].copy(), 12, 18), (-step, 0.0), atol=1e-12)
    np.testing.assert_allclose(sobel(turned[::-1].copy(), 18, 12), (0.0, -step), atol=1e-12)


def test_a_slanted_slope_has_the_same_gradient():
    u, v = np.meshgrid(np.arange(9.0), np.arange(9.0))
    speed = 0.5 + (np.cos(0.7) * u + np.sin(0.7) * v - 5.0) * CELL / SAFE / 2.0
    assert np.hypot(*sobel(speed, 4, 4)) == pytest.approx(CELL / SAFE / 2.0)


def test_figure_4():
    """Where W is 0.7 alpha is 0.6: of the speed towards the wall 40 % is left."""
    speed = np.array(slope())
    speed[:] = np.where(np.isclose(speed, 0.75), 0.70, speed)  # one column at W = 0.7
    column = int(np.argmax(np.isclose(speed[0], 0.70)))
    towards, beside = -0.30, 0.20
    changed = avoid((towards, beside), at(12, column), speed)
    # The neighbours on both sides decide the gradient; it still points along x.
    np.testing.assert_allclose(changed, (0.4 * towards, beside), atol=1e-12)


@pytest.mark.parametrize("w", [0.05, 0.25, 0.45])
def test_below_w_min_all_motion_towards_the_wall_goes(w):
    speed = np.array(slope())
    column = int(np.argmax(np.isclose(speed[0], w)))
    np.testing.assert_allclose(avoid((-0.3, 0.2), at(12, column), speed), (0.0, 0.2), atol=1e-12)


def test_motion_along_or_away_from_the_wall_stays():
    for velocity in ((0.3, 0.1), (0.0, 0.4), (0.0, 0.0)):
        np.testing.assert_array_equal(avoid(velocity, at(12, 4), slope()), velocity)


def test_where_w_is_1_nothing_changes():
    np.testing.assert_array_equal(avoid((-0.3, 0.2), at(12, 20), slope()), (-0.3, 0.2))


def test_in_the_middle_of_a_passage_the_velocity_stays():
    """A ridge of W: no single direction leads away from both walls."""
    passage = np.minimum(slope(cols=11), slope(cols=11)[:, ::-1])
    for velocity in ((0.5, 0.0), (-0.5, 0.1), (0.0, 0.5)):
        np.testing.assert_array_equal(avoid(velocity, at(12, 5), passage), velocity)


def test_on_a_saddle_the_velocity_stays():
    u, v = np.meshgrid(np.arange(-6, 7), np.arange(-6, 7))
    saddle = 0.6 + 0.005 * (u**2 - v**2)
    for velocity in ((0.5, 0.0), (0.0, 0.5), (-0.3, -0.3)):
        np.testing.assert_array_equal(avoid(velocity, at(6, 6), saddle), velocity)


@pytest.mark.parametrize(("share", "acts"), [(0.49, False), (0.51, True)])
def test_the_threshold_is_half_a_plain_slope(share, acts):
    speed = 0.3 + np.broadcast_to(np.arange(9.0) * share * CELL / SAFE, (9, 9))
    changed = avoid((-0.4, 0.0), at(4, 4), speed)
    assert bool(changed[0] > -0.4) is acts


def test_a_robot_off_the_map_is_left_alone():
    for point in ((-0.1, 0.4), (0.4, 9.0)):
        np.testing.assert_array_equal(avoid((-0.3, 0.2), point, slope()), (-0.3, 0.2))


def test_it_never_speeds_a_robot_up():
    rng = np.random.default_rng(5)
    speed = velocity_map(surface_distance(rng.random((24, 24)) < 0.03, CELL), 0.1, SAFE)
    for _ in range(200):
        velocity, point = rng.normal(size=2), rng.uniform(0.0, 24 * CELL, 2)
        assert np.hypot(*avoid(velocity, point, speed)) <= np.hypot(*velocity) + 1e-12
