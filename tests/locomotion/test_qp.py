"""The solver for contact forces against DAQP, and against what makes a minimum a minimum."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from cavalcade.locomotion._qp import (
    backward,
    combine,
    factorise,
    forward,
    hold,
    release,
    solve_qp,
    split,
)

MU, MOST, MANY = 0.5, 150.0, 100_000


def drawn(rng, feet, wildness):
    """A programme whose free minimum leaves the limits the more, the greater `wildness`."""
    n = 3 * feet
    half = rng.normal(size=(n, n)) * np.geomspace(1.0, 0.02, n)
    hessian = half @ half.T + 1e-3 * np.eye(n)
    wanted = np.tile([0.0, 0.0, 60.0], feet) + wildness * rng.normal(size=n)
    return hessian, -hessian @ wanted


def rows(feet):
    """All limits as `A f <= b`: four sides and the top of every foot's pyramid."""
    one = np.array([[1, 0, -MU], [-1, 0, -MU], [0, 1, -MU], [0, -1, -MU], [0, 0, 1.0]])
    return np.kron(np.eye(feet), one), np.tile([0.0, 0.0, 0.0, 0.0, MOST], feet)


def solved(hessian, gradient, changes=MANY):
    forces = np.full(len(gradient), np.nan)
    done = solve_qp(hessian, gradient, MU, MOST, forces, changes)
    return forces, done


@pytest.mark.parametrize("feet", [1, 2, 7, 20, 40])
def test_factor_and_solution(feet):
    rng = np.random.default_rng(feet)
    hessian, _ = drawn(rng, feet, 0.0)
    n = 3 * feet
    below = np.tril(np.full((n, n), np.nan), -1)  # never read
    factor, scale = np.full((n, n), np.nan), np.empty(n)
    factorise(np.triu(hessian) + below, factor, scale)
    expected = np.linalg.cholesky(hessian).T
    np.testing.assert_allclose(np.triu(factor), expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(scale, 1.0 / np.diag(expected), rtol=1e-9)
    for first in {0, 3 * (feet // 2), n - 3}:
        vector = np.where(np.arange(n) >= first, rng.normal(size=n), 0.0)
        exact = np.linalg.solve(hessian, vector)
        forward(factor, scale, vector, first)
        backward(factor, scale, vector)
        np.testing.assert_allclose(vector, exact, rtol=1e-7, atol=1e-9 * np.abs(exact).max())


def test_the_basis_stays_exact_as_limits_come_and_go():
    rng = np.random.default_rng(6)
    n = 30
    basis, triangle = np.empty((n, n)), np.empty((n, n))
    shares, answer = np.empty(n), np.empty(n)
    vectors = []
    for turn in range(2000):
        held = len(vectors)
        if held == n or (held and rng.random() < 0.4):
            place = int(rng.integers(held))
            release(basis, triangle, held, place)
            del vectors[place]
            continue
        vector = rng.normal(size=n)
        if held and turn % 3 == 0:  # nearly a combination of those that are held
            vector = 1e-4 * vector + rng.normal(size=held) @ np.array(vectors)
        vector /= np.linalg.norm(vector)
        left = vector.copy()
        square = split(basis, held, left, shares, answer)
        combine(triangle, held, shares, answer)
        if held:
            known = np.array(vectors)
            np.testing.assert_allclose(answer[:held] @ known + left, vector, atol=1e-8)
            np.testing.assert_allclose(known @ left, 0.0, atol=1e-10)
        hold(basis, triangle, held, left, shares, square)
        vectors.append(vector)
        held += 1
        np.testing.assert_allclose(basis[:held] @ basis[:held].T, np.eye(held), atol=1e-11)
        np.testing.assert_allclose(
            np.tril(triangle[:held, :held]) @ basis[:held], vectors, atol=1e-11
        )


@pytest.mark.parametrize("wildness", [20.0, 80.0, 400.0])
def test_no_force_within_the_limits_is_better(wildness):
    """-(H f + g) is a sum of the outward normals of limits that are reached, none of them < 0."""
    rng = np.random.default_rng(round(wildness))
    reached_by_any = 0
    for feet in (1, 3, 10, 20):
        for _ in range(15):
            hessian, gradient = drawn(rng, feet, wildness)
            forces, _ = solved(hessian, gradient)
            matrix, most = rows(feet)
            slack = most - matrix @ forces
            assert slack.min() >= -1e-12 * MOST
            reached = slack < 1e-6
            reached_by_any += reached.sum()
            slope = hessian @ forces + gradient
            rest = np.linalg.norm(slope)
            if reached.any():
                _, rest = nnls(matrix[reached].T, -slope, maxiter=10_000)
            assert rest < 1e-8 * (np.linalg.norm(gradient) + 1.0)
    assert reached_by_any > 100


@pytest.mark.parametrize("wildness", [20.0, 80.0, 400.0])
def test_daqp_agrees(wildness):
    daqp = pytest.importorskip("daqp")
    rng = np.random.default_rng(1)
    for feet in (2, 10, 20, 40):
        for _ in range(15):
            hessian, gradient = drawn(rng, feet, wildness)
            matrix, most = rows(feet)
            other, _, flag, _ = daqp.solve(hessian, gradient, matrix, most)
            assert flag == 1
            forces, _ = solved(hessian, gradient)
            np.testing.assert_allclose(forces, other, atol=1e-5)


def test_a_free_minimum_within_the_limits_is_the_answer():
    rng = np.random.default_rng(2)
    wanted = np.tile([3.0, -4.0, 50.0], 6)
    hessian, _ = drawn(rng, 6, 0.0)
    forces, changes = solved(hessian, -hessian @ wanted)
    np.testing.assert_allclose(forces, wanted, rtol=1e-8)
    assert changes == 0


def test_feet_that_would_pull_do_not():
    forces, changes = solved(np.eye(12), np.tile([5.0, 5.0, 80.0], 4))
    np.testing.assert_allclose(forces, 0.0, atol=1e-12)
    assert changes > 0


def test_a_foot_is_pressed_no_harder_than_it_may():
    forces, _ = solved(np.eye(3), np.array([0.0, -400.0, -400.0]))
    np.testing.assert_allclose(forces, [0.0, MU * MOST, MOST])


def test_the_unit_of_cost_does_not_matter():
    rng = np.random.default_rng(3)
    hessian, gradient = drawn(rng, 12, 200.0)
    forces, _ = solved(hessian, gradient)
    for unit in (1e-6, 1e6):
        scaled, _ = solved(unit * hessian, unit * gradient)
        np.testing.assert_allclose(scaled, forces, atol=1e-6)


def test_the_order_of_feet_does_not_matter():
    rng = np.random.default_rng(4)
    hessian, gradient = drawn(rng, 12, 200.0)
    forces, _ = solved(hessian, gradient)
    order = (3 * rng.permutation(12)[:, None] + np.arange(3)).ravel()
    moved, _ = solved(np.ascontiguousarray(hessian[np.ix_(order, order)]), gradient[order])
    np.testing.assert_allclose(moved, forces[order], atol=1e-6)


def test_one_that_may_not_finish_stays_within_the_limits():
    rng = np.random.default_rng(5)
    hessian, gradient = drawn(rng, 12, 400.0)
    matrix, most = rows(12)
    _, needed = solved(hessian, gradient)
    assert needed > 10
    for changes in (0, 1, needed // 2):
        forces, done = solved(hessian, gradient, changes)
        assert done == changes
        assert (matrix @ forces <= most + 1e-12 * MOST).all()
