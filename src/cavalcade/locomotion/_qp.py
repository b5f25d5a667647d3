"""Quadratic programmes over contact forces, compiled: one pyramid of friction for every foot.

    minimise ½ fᵀ H f + gᵀ f   where |f_x|, |f_y| ≤ mu f_z and 0 ≤ f_z ≤ most, for every foot

Relaxed ADMM (Boyd et al., "Distributed optimization and statistical learning via the alternating
direction method of multipliers", 2011) whose linear step is a product with one inverse.
"""

from __future__ import annotations

import numpy as np
from numba import njit

RELAXATION = 1.8


@njit(cache=True)
def pyramid(x, y, z, mu, most):
    """The point of a foot's pyramid of friction nearest to (x, y, z).

    At height z only the sides that are crossed push back, so the best height is the largest of
    those that each set of sides asks for by itself.
    """
    a, b = abs(x), abs(y)
    one = (z + mu * max(a, b)) / (1.0 + mu * mu)
    both = (z + mu * (a + b)) / (1.0 + 2.0 * mu * mu)
    z = min(max(z, one, both, 0.0), most)
    side = mu * z
    return min(max(x, -side), side), min(max(y, -side), side), z


@njit(cache=True, fastmath={"contract"})
def invert(matrix, n):
    """Turn the leading `(n, n)` block, symmetric positive definite, into its inverse in place.

    Gauss–Jordan without pivoting.
    """
    for p in range(n):
        pivot = 1.0 / matrix[p, p]
        for c in range(n):
            matrix[p, c] *= pivot
        matrix[p, p] = pivot
        for r in range(n):
            if r != p:
                factor = matrix[r, p]
                matrix[r, p] = 0.0
                for c in range(n):
                    matrix[r, c] -= factor * matrix[p, c]


@njit(cache=True, fastmath={"contract"})
def multiply(matrix, vector, out, n):
    """`out = matrix @ vector` for a symmetric `(n, n)` matrix; n is a multiple of 3."""
    for c in range(n):
        out[c] = 0.0
    for r in range(0, n, 3):
        v0, v1, v2 = vector[r], vector[r + 1], vector[r + 2]
        for c in range(n):
            out[c] += matrix[r, c] * v0 + matrix[r + 1, c] * v1 + matrix[r + 2, c] * v2


@njit(cache=True, fastmath={"contract"})
def solve_qp(hessian, gradient, mu, most, forces, rho, iterations, tolerance):
    """Solve the programme above.

    Args:
        hessian: `(n, n)`, symmetric positive definite, n = 3 for every foot; destroyed.
        gradient: `(n,)`.
        mu, most: Coefficient of friction; greatest normal force, N.
        forces: `(n,)` where to start, N; becomes the solution, which obeys the limits exactly.
        rho: Penalty; about ten times the least eigenvalue of H.
        iterations: At most so many.
        tolerance: Enough when forces change by less than this, N.

    Returns:
        The iterations done.
    """
    n = gradient.shape[0]
    if n == 0:
        return 0
    z, u, v, x, base = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for k in range(0, n, 3):
        z[k], z[k + 1], z[k + 2] = pyramid(forces[k], forces[k + 1], forces[k + 2], mu, most)
    # Multipliers start from none: those that would explain a start far from the solution are huge
    # beside rho, and take many iterations to forget.
    for k in range(n):
        u[k] = 0.0
        hessian[k, k] += rho
    invert(hessian, n)
    for k in range(n):
        v[k] = -gradient[k]
    multiply(hessian, v, base, n)
    done = 0
    for _ in range(iterations):
        done += 1
        for k in range(n):
            v[k] = rho * (z[k] - u[k])
        multiply(hessian, v, x, n)
        change = 0.0
        for k in range(0, n, 3):
            hx = RELAXATION * (x[k] + base[k]) + (1.0 - RELAXATION) * z[k]
            hy = RELAXATION * (x[k + 1] + base[k + 1]) + (1.0 - RELAXATION) * z[k + 1]
            hz = RELAXATION * (x[k + 2] + base[k + 2]) + (1.0 - RELAXATION) * z[k + 2]
            hx += u[k]
            hy += u[k + 1]
            hz += u[k + 2]
            px, py, pz = pyramid(hx, hy, hz, mu, most)
            u[k], u[k + 1], u[k + 2] = hx - px, hy - py, hz - pz
            change = max(change, abs(px - z[k]), abs(py - z[k + 1]), abs(pz - z[k + 2]))
            z[k], z[k + 1], z[k + 2] = px, py, pz
        if change < tolerance:
            break
    for k in range(n):
        forces[k] = z[k]
    return done
