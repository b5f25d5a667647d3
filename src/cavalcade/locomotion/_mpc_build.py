"""The quadratic programme of predictive control in forces alone, compiled.

The states are eliminated. Forces are constant within a step and the linear model is integrated
exactly: a force of step j moves the position at the end of step k by dt_j / m (T_k - τ_j), where
T_k is the end of step k and τ_j the middle of step j. Products of two such terms, summed over k,
are polynomials in τ whose coefficients are sums of 1, T_k and T_k² from step j to the last one;
they are kept as j falls, and no sum over k is left for a pair of forces. Turning works alike: there
T_k is the 3 × 3 integral of the matrix that turns angular velocity into rates of roll, pitch, yaw.

`_mpc.solve_mpc` says what the arguments are. Columns are the axes of the standing feet, by step,
leg, axis. Inner loops count unsigned, as in `_qp_factor`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

GRAVITY = 9.81


@njit(cache=True)
def count_stance(contacts):
    """How many feet stand, over all steps."""
    count = 0
    for k in range(contacts.shape[0]):
        for leg in range(4):
            if contacts[k, leg]:
                count += 1
    return count


@njit(cache=True, fastmath={"contract", "reassoc"})
def build_qp(
    state,
    reference,
    contacts,
    levers,
    yaws,
    dts,
    inertia,
    mass,
    weights,
    force_weight,
    hessian,
    gradient,
):
    """Fill the `(n, n)` hessian, of which the upper triangle, and the `(n,)` gradient."""
    steps = contacts.shape[0]
    ends, middles = np.empty(steps), np.empty(steps)
    turns, mids = np.zeros((steps, 3, 3)), np.zeros((steps, 3, 3))
    first, arms = np.empty(steps + 1, np.int64), np.empty((3, gradient.shape[0]))
    errors = np.empty((steps, 12))
    fixed, linear = np.empty((steps, 3, 3)), np.empty((steps, 3, 3))
    _times(yaws, dts, ends, middles, turns, mids)
    _arms(contacts, levers, yaws, dts, inertia, first, arms)
    _drift(state, reference, weights, ends, turns, errors)
    _pull(errors, first, arms, ends, middles, turns, mids, dts, mass, gradient)
    _turning(weights, turns, mids, first, arms, fixed, linear, hessian)
    _moving(weights, first, ends, middles, dts, mass, hessian)
    for k in range(steps):
        feet = (first[k + 1] - first[k]) // 3
        for column in range(first[k], first[k + 1], 3):
            for a in range(3):
                hessian[column + a, column + a] += force_weight
            gradient[column + 2] -= force_weight * mass * GRAVITY / feet


@njit(cache=True)
def _times(yaws, dts, ends, middles, turns, mids):
    """Times of steps, and for turning the integrals to the ends and middles of steps."""
    end, along, across = 0.0, 0.0, 0.0
    for k in range(dts.shape[0]):
        half = 0.5 * dts[k]
        c, s = half * math.cos(yaws[k]), half * math.sin(yaws[k])
        middles[k] = end + half
        mids[k, 0, 0] = mids[k, 1, 1] = along + c
        mids[k, 0, 1], mids[k, 1, 0] = across + s, -across - s
        mids[k, 2, 2] = middles[k]
        end += dts[k]
        along += 2.0 * c
        across += 2.0 * s
        ends[k] = end
        turns[k, 0, 0] = turns[k, 1, 1] = along
        turns[k, 0, 1], turns[k, 1, 0] = across, -across
        turns[k, 2, 2] = end


@njit(cache=True)
def _arms(contacts, levers, yaws, dts, inertia, first, arms):
    """What forces do to the angular velocity: dt I⁻¹ [r]×, `(3, n)`; `first` column of a step."""
    a, b, c = inertia[0, 0], inertia[0, 1], inertia[0, 2]
    d, e, f = inertia[1, 1], inertia[1, 2], inertia[2, 2]
    p, q, r = d * f - e * e, c * e - b * f, b * e - c * d  # cofactors
    s, t, u = a * f - c * c, b * c - a * e, a * d - b * b
    det = a * p + b * q + c * r
    column = 0
    for k in range(contacts.shape[0]):
        first[k] = column
        co, si, scale = math.cos(yaws[k]), math.sin(yaws[k]), dts[k] / det
        # Rz I⁻¹ Rzᵀ
        xx = scale * (co * co * p - 2.0 * co * si * q + si * si * s)
        xy = scale * (co * si * (p - s) + (co * co - si * si) * q)
        yy = scale * (si * si * p + 2.0 * co * si * q + co * co * s)
        xz, yz, zz = scale * (co * r - si * t), scale * (si * r + co * t), scale * u
        for leg in range(4):
            if contacts[k, leg]:
                x, y, z = levers[k, leg, 0], levers[k, leg, 1], levers[k, leg, 2]
                arms[0, column], arms[0, column + 1] = xy * z - xz * y, xz * x - xx * z
                arms[1, column], arms[1, column + 1] = yy * z - yz * y, yz * x - xy * z
                arms[2, column], arms[2, column + 1] = yz * z - zz * y, zz * x - xz * z
                arms[0, column + 2] = xx * y - xy * x
                arms[1, column + 2] = xy * y - yy * x
                arms[2, column + 2] = xz * y - yz * x
                column += 3
    first[contacts.shape[0]] = column


@njit(cache=True)
def _drift(state, reference, weights, ends, turns, errors):
    """The weighted errors where no foot pushes."""
    for k in range(ends.shape[0]):
        t = ends[k]
        for a in range(3):
            angle = state[a]
            for b in range(3):
                angle += turns[k, a, b] * state[6 + b]
            pull = -GRAVITY if a == 2 else 0.0
            place = state[3 + a] + t * (state[9 + a] + 0.5 * pull * t)
            errors[k, a] = weights[a] * (angle - reference[k, a])
            errors[k, 3 + a] = weights[3 + a] * (place - reference[k, 3 + a])
            errors[k, 6 + a] = weights[6 + a] * (state[6 + a] - reference[k, 6 + a])
            errors[k, 9 + a] = weights[9 + a] * (state[9 + a] + pull * t - reference[k, 9 + a])


@njit(cache=True)
def _pull(errors, first, arms, ends, middles, turns, mids, dts, mass, gradient):
    """The gradient: what the errors of all later steps ask of a step's forces."""
    angle, angle1, spin = np.zeros(3), np.zeros(3), np.zeros(3)  # sums; 1: times the integral
    place, place1, speed = np.zeros(3), np.zeros(3), np.zeros(3)
    force, moment = np.empty(3), np.empty(3)
    for j in range(ends.shape[0] - 1, -1, -1):
        for a in range(3):
            angle[a] += errors[j, a]
            place[a] += errors[j, 3 + a]
            spin[a] += errors[j, 6 + a]
            speed[a] += errors[j, 9 + a]
            place1[a] += ends[j] * errors[j, 3 + a]
            for b in range(3):
                angle1[a] += turns[j, b, a] * errors[j, b]
        for a in range(3):
            force[a] = dts[j] / mass * (place1[a] - middles[j] * place[a] + speed[a])
            moment[a] = angle1[a] + spin[a]
            for b in range(3):
                moment[a] -= mids[j, b, a] * angle[b]
        for column in range(first[j], first[j + 1], 3):
            for a in range(3):
                gradient[column + a] = force[a]
                for b in range(3):
                    gradient[column + a] += arms[b, column + a] * moment[b]


@njit(cache=True, fastmath={"contract", "reassoc"})
def _turning(weights, turns, mids, first, arms, fixed, linear, hessian):
    """The hessian's part of angles and angular velocities; overwrites the upper triangle.

    Σ (turn_k - mid_i)ᵀ W (turn_k - mid_j) = fixed_j + mid_iᵀ linear_j, k from j to the last step.
    """
    steps = turns.shape[0]
    once, twice = np.zeros((3, 3)), np.zeros((3, 3))  # Σ W turn, Σ turnᵀ W turn
    for j in range(steps - 1, -1, -1):
        count = float(steps - j)
        for a in range(3):
            for b in range(3):
                once[a, b] += weights[a] * turns[j, a, b]
                for c in range(3):
                    twice[a, b] += turns[j, c, a] * weights[c] * turns[j, c, b]
        for a in range(3):
            for b in range(3):
                linear[j, a, b] = count * weights[a] * mids[j, a, b] - once[a, b]
                fixed[j, a, b] = twice[a, b]
                for c in range(3):
                    fixed[j, a, b] -= once[c, a] * mids[j, c, b]
            fixed[j, a, a] += count * weights[6 + a]
    n = np.uint64(arms.shape[1])
    wide = np.empty((3, arms.shape[1]))
    for i in range(steps):
        if first[i] == first[i + 1]:
            continue
        for j in range(i, steps):
            begin, end = np.uint64(first[j]), np.uint64(first[j + 1])
            for a in range(3):
                x, y, z = fixed[j, a, 0], fixed[j, a, 1], fixed[j, a, 2]
                for b in range(3):
                    x += mids[i, b, a] * linear[j, b, 0]
                    y += mids[i, b, a] * linear[j, b, 1]
                    z += mids[i, b, a] * linear[j, b, 2]
                for c in range(begin, end):
                    wide[a, c] = x * arms[0, c] + y * arms[1, c] + z * arms[2, c]
        for r in range(first[i], first[i + 1]):
            x, y, z = arms[0, r], arms[1, r], arms[2, r]
            for c in range(np.uint64(first[i]), n):
                hessian[r, c] = x * wide[0, c] + y * wide[1, c] + z * wide[2, c]


@njit(cache=True)
def _moving(weights, first, ends, middles, dts, mass, hessian):
    """Add the hessian's part of places and velocities: pairs of feet along the same axis."""
    steps = ends.shape[0]
    count, once, twice = 0.0, 0.0, 0.0  # Σ 1, T, T²
    for j in range(steps - 1, -1, -1):
        count += 1.0
        once += ends[j]
        twice += ends[j] * ends[j]
        for i in range(j + 1):
            scale = dts[i] * dts[j] / (mass * mass)
            reach = twice - (middles[i] + middles[j]) * once + middles[i] * middles[j] * count
            x = scale * (weights[3] * reach + weights[9] * count)
            y = scale * (weights[4] * reach + weights[10] * count)
            z = scale * (weights[5] * reach + weights[11] * count)
            for row in range(first[i], first[i + 1], 3):
                for column in range(first[j], first[j + 1], 3):
                    hessian[row, column] += x
                    hessian[row + 1, column + 1] += y
                    hessian[row + 2, column + 2] += z
