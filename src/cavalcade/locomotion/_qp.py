"""Quadratic programmes over contact forces, compiled: one pyramid of friction for every foot.

    minimise ½ fᵀ H f + gᵀ f   where |f_x|, |f_y| ≤ mu f_z and f_z ≤ most, for every foot

(f_z ≥ 0 follows.) The dual active set method of Goldfarb and Idnani, "A numerically stable dual
method for solving strictly convex quadratic programs", Mathematical Programming 27, 1983: from the
free minimum, the limit that is exceeded most is held, and held limits whose multiplier would
become negative are let go, until none is exceeded. The answer is exact, and a walk mostly needs few
limits: most of the time goes into one Cholesky factor of H.

Limits are numbered `5 foot + side`; sides: 0 and 1 for f_x, 2 and 3 for f_y (positive, negative),
4 for f_z. They read aᵀ f ≤ 0, or ≤ most for side 4.

With H = Rᵀ R, the rows aₖ of held limits become vectors R⁻ᵀ aₖ. They are kept as Q T, the columns
of Q orthonormal and T upper triangular, which stays exact over any number of changes.

    basis: `(., n)`, row i is column i of Q
    triangle: `(., .)`, row k is column k of T: R⁻ᵀ aₖ in terms of the basis

Columns are counted unsigned in the inner loops: only then does the compiler know that no index
means "from the end", and turns the loop into vector instructions.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import subroutine

EXCEEDED = 1e-7  # N: less is put right by the last projection
DEPENDENT = 1e-20  # of the square of a limit's vector: it follows from those that are held


@subroutine
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


@subroutine
def limit_row(limit, mu, row):
    """`row` becomes the limit's a; returns its first column that may differ from 0."""
    foot, side = 3 * (limit // 5), limit % 5
    row[:] = 0.0
    if side == 4:
        row[foot + 2] = 1.0
    else:
        row[foot + side // 2] = -1.0 if side % 2 == 1 else 1.0
        row[foot + 2] = -mu
    return foot


@subroutine(fastmath={"contract", "reassoc"})
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
    factor, scale = np.empty((n, n)), np.empty(n)
    factorise(hessian, factor, scale)
    for c in range(n):
        forces[c] = -gradient[c]
    forward(factor, scale, forces, 0)
    backward(factor, scale, forces)
    limit, excess = most_exceeded(forces, mu, most)
    if excess <= EXCEEDED or changes == 0:
        _within(forces, mu, most)
        return 0
    basis, triangle = np.empty((n, n)), np.empty((n, n))
    limits, multipliers = np.empty(n, np.int64), np.empty(n)
    vector, descent, shares, answer = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    held, done, multiplier = 0, 0, 0.0
    while done < changes:
        done += 1
        # How forces answer to this limit's multiplier while those held stay as they are.
        first = limit_row(limit, mu, vector)
        forward(factor, scale, vector, first)
        own = 0.0
        for c in range(n):
            own += vector[c] * vector[c]
        curvature = split(basis, held, vector, shares, answer)
        combine(triangle, held, shares, answer)
        free = curvature > DEPENDENT * own
        step, place = (excess / curvature if free else np.inf), -1
        for k in range(held):
            if answer[k] > 0.0 and multipliers[k] < step * answer[k]:
                step, place = multipliers[k] / answer[k], k
        if place < 0 and not free:
            break  # by rounding alone: forces of zero obey all limits
        for k in range(held):
            multipliers[k] -= step * answer[k]
        multiplier += step
        if free:
            for c in range(n):
                descent[c] = vector[c]
            backward(factor, scale, descent)
            for c in range(n):
                forces[c] -= step * descent[c]
        if place >= 0:
            release(basis, triangle, held, place)
            held -= 1
            for k in range(place, held):
                limits[k], multipliers[k] = limits[k + 1], multipliers[k + 1]
            excess -= step * curvature
            continue
        hold(basis, triangle, held, vector, shares, curvature)
        limits[held], multipliers[held] = limit, multiplier
        held += 1
        limit, excess = most_exceeded(forces, mu, most)
        multiplier = 0.0
        if excess <= EXCEEDED:
            break
    _within(forces, mu, most)
    return done


@subroutine
def _within(forces, mu, most):
    """Bring forces within all limits, without the last rounding error."""
    for k in range(0, forces.shape[0], 3):
        z = min(max(forces[k + 2], 0.0), most)
        side = mu * z
        forces[k] = min(max(forces[k], -side), side)
        forces[k + 1] = min(max(forces[k + 1], -side), side)
        forces[k + 2] = z


@subroutine(fastmath={"contract", "reassoc"})
def split(basis, held, vector, shares, more):
    """Take from `vector` what lies along the basis, which becomes `shares`.

    Returns the square of what is left; `more` is overwritten.
    """
    end = np.uint64(vector.shape[0])
    for k in range(held):
        shares[k] = 0.0
    # Twice is enough (Parlett, "The symmetric eigenvalue problem", 1980, section 6.9); once would
    # multiply what the basis lacks in being orthonormal with every vector.
    for _ in range(2):
        for k in range(held):
            share = 0.0
            for c in range(end):
                share += basis[k, c] * vector[c]
            more[k] = share
            shares[k] += share
        odd = held % 2
        if odd == 1:
            for c in range(end):
                vector[c] -= more[0] * basis[0, c]
        for k in range(odd, held, 2):
            a, b = more[k], more[k + 1]
            for c in range(end):
                vector[c] -= a * basis[k, c] + b * basis[k + 1, c]
    left = 0.0
    for c in range(end):
        left += vector[c] * vector[c]
    return left


@subroutine(fastmath={"contract", "reassoc"})
def combine(triangle, held, shares, answer):
    """`answer = T⁻¹ shares`: the combination of held limits that has these shares."""
    for k in range(held):
        answer[k] = shares[k]
    for k in range(held - 1, -1, -1):
        value = answer[k] / triangle[k, k]
        answer[k] = value
        for c in range(np.uint64(k)):
            answer[c] -= value * triangle[k, c]


@subroutine
def hold(basis, triangle, held, vector, shares, left):
    """Add a limit whose vector has these shares and, beside them, `vector` of square `left`."""
    length = math.sqrt(left)
    for c in range(vector.shape[0]):
        basis[held, c] = vector[c] / length
    for k in range(held):
        triangle[held, k] = shares[k]
    triangle[held, held] = length


@subroutine(fastmath={"contract"})
def release(basis, triangle, held, place):
    """Take out a limit; those after it move up by one."""
    end = np.uint64(basis.shape[1])
    for k in range(place, held - 1):
        for c in range(k + 2):
            triangle[k, c] = triangle[k + 1, c]
    for i in range(place, held - 1):
        length = math.hypot(triangle[i, i], triangle[i, i + 1])
        cosine, sine = triangle[i, i] / length, triangle[i, i + 1] / length
        for k in range(i, held - 1):
            a, b = triangle[k, i], triangle[k, i + 1]
            triangle[k, i] = cosine * a + sine * b
            triangle[k, i + 1] = cosine * b - sine * a
        for c in range(end):
            a, b = basis[i, c], basis[i + 1, c]
            basis[i, c] = cosine * a + sine * b
            basis[i + 1, c] = cosine * b - sine * a


@subroutine(fastmath={"contract", "reassoc"})
def factorise(matrix, factor, scale):
    """Set the upper triangle of `factor` to R with Rᵀ R = `matrix` (Cholesky), by three rows.

    Of the matrix, `(n, n)` and positive definite, n a multiple of 3, the upper triangle is read;
    `scale` `(n,)` becomes one over the diagonal of R.
    """
    n = matrix.shape[0]
    end = np.uint64(n)
    for r in range(n):
        for c in range(np.uint64(r), end):
            factor[r, c] = matrix[r, c]
    for p in range(0, n, 3):
        pivot = 1.0 / math.sqrt(factor[p, p])
        scale[p] = pivot
        for c in range(np.uint64(p), end):
            factor[p, c] *= pivot
        a = factor[p, p + 1]
        pivot = 1.0 / math.sqrt(factor[p + 1, p + 1] - a * a)
        scale[p + 1] = pivot
        for c in range(np.uint64(p + 1), end):
            factor[p + 1, c] = pivot * (factor[p + 1, c] - a * factor[p, c])
        a, b = factor[p, p + 2], factor[p + 1, p + 2]
        pivot = 1.0 / math.sqrt(factor[p + 2, p + 2] - a * a - b * b)
        scale[p + 2] = pivot
        for c in range(np.uint64(p + 2), end):
            factor[p + 2, c] = pivot * (factor[p + 2, c] - a * factor[p, c] - b * factor[p + 1, c])
        for r in range(p + 3, n, 3):
            a0, b0, c0 = factor[p, r], factor[p + 1, r], factor[p + 2, r]
            a1, b1, c1 = factor[p, r + 1], factor[p + 1, r + 1], factor[p + 2, r + 1]
            a2, b2, c2 = factor[p, r + 2], factor[p + 1, r + 2], factor[p + 2, r + 2]
            for c in range(np.uint64(r), end):
                x, y, z = factor[p, c], factor[p + 1, c], factor[p + 2, c]
                factor[r, c] -= a0 * x + b0 * y + c0 * z
                factor[r + 1, c] -= a1 * x + b1 * y + c1 * z
                factor[r + 2, c] -= a2 * x + b2 * y + c2 * z


@subroutine(fastmath={"contract", "reassoc"})
def forward(factor, scale, vector, first):
    """Turn `vector` into R⁻ᵀ vector; it is zero before `first`, a multiple of 3."""
    n = factor.shape[0]
    end = np.uint64(n)
    for p in range(first, n, 3):
        x = scale[p] * vector[p]
        y = scale[p + 1] * (vector[p + 1] - factor[p, p + 1] * x)
        z = scale[p + 2] * (vector[p + 2] - factor[p, p + 2] * x - factor[p + 1, p + 2] * y)
        vector[p], vector[p + 1], vector[p + 2] = x, y, z
        for c in range(np.uint64(p + 3), end):
            vector[c] -= x * factor[p, c] + y * factor[p + 1, c] + z * factor[p + 2, c]


@subroutine(fastmath={"contract", "reassoc"})
def backward(factor, scale, vector):
    """Turn `vector` into R⁻¹ vector."""
    n = factor.shape[0]
    end = np.uint64(n)
    for p in range(n - 3, -1, -3):
        x, y, z = 0.0, 0.0, 0.0
        for c in range(np.uint64(p + 3), end):
            x += factor[p, c] * vector[c]
            y += factor[p + 1, c] * vector[c]
            z += factor[p + 2, c] * vector[c]
        z = scale[p + 2] * (vector[p + 2] - z)
        y = scale[p + 1] * (vector[p + 1] - y - factor[p + 1, p + 2] * z)
        x = scale[p] * (vector[p] - x - factor[p, p + 1] * y - factor[p, p + 2] * z)
        vector[p], vector[p + 1], vector[p + 2] = x, y, z
