"""Quadratic programmes over contact forces, compiled: one pyramid of friction for every foot.

    minimise ½ fᵀ H f + gᵀ f   where |f_x|, |f_y| ≤ mu f_z and f_z ≤ most, for every foot

(f_z ≥ 0 follows.) The dual active set method of Goldfarb and Idnani, "A numerically stable dual
method for solving strictly convex quadratic programs", Mathematical Programming 27, 1983: from the
free minimum, the limit that is exceeded most is held, and held limits whose multiplier would
become negative are let go, until none is exceeded. The answer is exact, and a walk mostly needs few
limits: most of the time goes into one Cholesky factor of H. Limits concern one or two forces,
so products with them are look-ups.

Limits are numbered `5 foot + side`; sides: 0 and 1 for f_x, 2 and 3 for f_y (positive, negative),
4 for f_z. They read aᵀ f ≤ 0, or ≤ most for side 4.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cavalcade.locomotion._qp_factor import back_solve, factorise

EXCEEDED = 1e-7  # N: less is put right by the last projection
DEPENDENT = 1e-11  # of a limit's own curvature: it follows from those that are held


@njit(cache=True)
def along(limit, vector, mu):
    """Product of a limit's row with a vector."""
    foot, side = 3 * (limit // 5), limit % 5
    if side == 4:
        return vector[foot + 2]
    value = vector[foot + side // 2]
    return (-value if side % 2 == 1 else value) - mu * vector[foot + 2]


@njit(cache=True)
def most_exceeded(forces, mu, most):
    """The limit exceeded most and by how much, N; -1 and 0 where there is none."""
    limit, excess = -1, 0.0
    for k in range(0, forces.shape[0], 3):
        x, y, z = forces[k], forces[k + 1], forces[k + 2]
        side = mu * z
        foot = 5 * (k // 3)
        if abs(x) - side > excess:
            limit, excess = (foot if x > 0.0 else foot + 1), abs(x) - side
        if abs(y) - side > excess:
            limit, excess = (foot + 2 if y > 0.0 else foot + 3), abs(y) - side
        if z - most > excess:
            limit, excess = foot + 4, z - most
    return limit, excess


@njit(cache=True, fastmath={"contract", "reassoc"})
def descend(limit, factor, scale, mu, column):
    """`column` becomes H⁻¹ a: how forces answer to the limit's multiplier."""
    foot, side = 3 * (limit // 5), limit % 5
    column[:] = 0.0
    if side == 4:
        column[foot + 2] = 1.0
    else:
        column[foot + side // 2] = -1.0 if side % 2 == 1 else 1.0
        column[foot + 2] = -mu
    back_solve(factor, scale, column, foot)


@njit(cache=True, fastmath={"contract", "reassoc"})
def hold(inverse, held, answer, curvature):
    """Border the inverse of the held limits' curvature by one more limit.

    Args:
        inverse: `(., .)` whose leading `(held, held)` block is kept; becomes one larger.
        answer: `(held,)` how the held multipliers answer to the new one.
        curvature: What is left of the new limit's own curvature.
    """
    end = np.uint64(held)
    for r in range(held):
        share = answer[r] / curvature
        for c in range(end):
            inverse[r, c] += share * answer[c]
        inverse[r, held] = -share
    for c in range(held):
        inverse[held, c] = inverse[c, held]
    inverse[held, held] = 1.0 / curvature


@njit(cache=True, fastmath={"contract", "reassoc"})
def release(inverse, held, place, work):
    """Take a limit out of the inverse; the last one takes its place."""
    last = held - 1
    end = np.uint64(held)
    for r in range(held):
        work[r] = inverse[r, place]
    for r in range(held):
        share = work[r] / work[place]
        for c in range(end):
            inverse[r, c] -= share * work[c]
    for c in range(held):
        inverse[place, c] = inverse[last, c]
    for r in range(held):
        inverse[r, place] = inverse[r, last]


@njit(cache=True, fastmath={"contract", "reassoc"})
def solve_qp(hessian, gradient, mu, most, forces, changes):
    """Solve the programme above.

    Args:
        hessian: `(n, n)`, symmetric positive definite, n = 3 for every foot; only the upper
            triangle is read.
        gradient: `(n,)`.
        mu, most: Coefficient of friction, greater than 0; greatest normal force, N.
        forces: `(n,)`, becomes the solution, N; limits are obeyed exactly.
        changes: Hold and let go limits at most so many times; after that the forces are brought
            within the limits as they are, which is not the minimum.

    Returns:
        The changes made.
    """
    n = gradient.shape[0]
    end = np.uint64(n)
    factor, scale = np.empty((n, n)), np.empty(n)
    factorise(hessian, factor, scale)
    for c in range(n):
        forces[c] = -gradient[c]
    back_solve(factor, scale, forces, 0)
    limits, multipliers = np.empty(n + 1, np.int64), np.empty(n + 1)
    columns, inverse = np.empty((n + 1, n)), np.empty((n + 1, n + 1))
    cross, answer, column = np.empty(n + 1), np.empty(n + 1), np.empty(n)
    held, done = 0, 0
    while done < changes:
        limit, excess = most_exceeded(forces, mu, most)
        if excess <= EXCEEDED:
            break
        descend(limit, factor, scale, mu, column)
        own = along(limit, column, mu)
        for k in range(held):
            cross[k] = along(limits[k], column, mu)
        multiplier = 0.0
        while done < changes:
            done += 1
            curvature = own
            for r in range(held):
                total = 0.0
                for c in range(np.uint64(held)):
                    total += inverse[r, c] * cross[c]
                answer[r] = total
                curvature -= total * cross[r]
            free = curvature > DEPENDENT * own
            step = excess / curvature if free else np.inf
            place = -1
            for k in range(held):
                if answer[k] > 0.0 and multipliers[k] < step * answer[k]:
                    step, place = multipliers[k] / answer[k], k
            if place < 0 and not free:
                return _within(forces, mu, most, done)  # only by rounding: all limits allow 0
            for k in range(held):
                multipliers[k] -= step * answer[k]
            multiplier += step
            if free:
                excess -= step * curvature
                for c in range(end):
                    forces[c] -= step * column[c]
                for k in range(held):
                    share = step * answer[k]
                    for c in range(end):
                        forces[c] += share * columns[k, c]
            if place < 0:
                hold(inverse, held, answer, curvature)
                limits[held], multipliers[held] = limit, multiplier
                for c in range(n):
                    columns[held, c] = column[c]
                held += 1
                break
            release(inverse, held, place, answer)
            held -= 1
            limits[place], multipliers[place] = limits[held], multipliers[held]
            cross[place] = cross[held]
            for c in range(n):
                columns[place, c] = columns[held, c]
    return _within(forces, mu, most, done)


@njit(cache=True)
def _within(forces, mu, most, done):
    """Bring forces within all limits, without the last rounding error; returns `done`."""
    for k in range(0, forces.shape[0], 3):
        z = min(max(forces[k + 2], 0.0), most)
        side = mu * z
        forces[k] = min(max(forces[k], -side), side)
        forces[k + 1] = min(max(forces[k + 1], -side), side)
        forces[k + 2] = z
    return done
