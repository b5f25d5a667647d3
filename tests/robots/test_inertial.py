"""Adding up and mirroring masses, against clouds of points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cavalcade.robots.description import Inertial, combined

NUMBER = st.floats(-1.0, 1.0)


def of_points(masses, points):
    """The rigid body of point masses `(N,)` at `(N, 3)`."""
    mass = float(masses.sum())
    center = masses @ points / mass
    inertia = np.zeros((3, 3))
    for m, arm in zip(masses, points - center, strict=True):
        inertia += m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    moments = inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2]
    return Inertial(mass, tuple(center), (*moments, inertia[1, 2]))


def assert_same(one, other):
    assert one.mass == pytest.approx(other.mass)
    np.testing.assert_allclose(one.center, other.center, atol=1e-12)
    np.testing.assert_allclose(one.inertia, other.inertia, atol=1e-12)


@given(st.integers(0, 2**31), st.integers(2, 5))
def test_the_whole_is_the_body_of_all_points(seed, parts):
    random = np.random.default_rng(seed)
    masses, points = random.random((parts, 4)) + 0.1, random.standard_normal((parts, 4, 3))
    whole = combined([of_points(m, p) for m, p in zip(masses, points, strict=True)])
    assert_same(whole, of_points(masses.ravel(), points.reshape(-1, 3)))


@pytest.mark.parametrize("x", [False, True])
@pytest.mark.parametrize("y", [False, True])
def test_the_mirror_image_is_the_body_of_mirrored_points(x, y):
    random = np.random.default_rng(1)
    masses, points = random.random(5), random.standard_normal((5, 3))
    signs = (-1.0 if x else 1.0, -1.0 if y else 1.0, 1.0)
    mirrored = of_points(masses, points).mirrored(x, y)
    assert_same(mirrored, of_points(masses, points * signs))
    assert_same(mirrored.mirrored(x, y), of_points(masses, points))


@given(NUMBER, NUMBER, NUMBER)
def test_a_moved_frame_moves_the_centre_alone(x, y, z):
    random = np.random.default_rng(2)
    masses, points = random.random(4), random.standard_normal((4, 3))
    moved = of_points(masses, points).moved((x, y, z))
    assert_same(moved, of_points(masses, points + (x, y, z)))


@given(st.integers(0, 2**31))
def test_a_turned_body_is_the_body_of_turned_points(seed):
    random = np.random.default_rng(seed)
    masses, points = random.random(4) + 0.1, random.standard_normal((4, 3))
    turn = Rotation.from_rotvec(3.0 * random.standard_normal(3))
    assert_same(of_points(masses, points).turned(turn.as_matrix()),
                of_points(masses, turn.apply(points)))  # fmt: skip


def test_the_matrix_is_symmetric_and_in_the_order_said():
    body = Inertial(1.0, (0.0, 0.0, 0.0), (1.0, 2.0, 3.0, 0.1, 0.2, 0.3))
    np.testing.assert_array_equal(body.matrix, [[1.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 3.0]])
