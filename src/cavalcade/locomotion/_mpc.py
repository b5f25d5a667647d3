"""Convex model predictive control of a legged body, compiled: forces that follow a reference.

One rigid body, linearised about its yaw, whose only inputs are the forces on the feet that stand:
Di Carlo, Wensing, Katz, Bledt, Kim, "Dynamic locomotion in the MIT Cheetah 3 through convex
model-predictive control", IROS 2018. `problem` is an `MpcProblem`; `mpc.solve_mpc` is the same for
callers from Python.

The quadratic programme is one in forces alone: the states are eliminated. Forces are constant
within a step and the linear model is integrated exactly: a force of step j moves the position at
the end of step k by dt_j / m (T_k - τ_j), where T_k is the end of step k and τ_j the middle of
step j. Products of two such terms, summed over k, are polynomials in τ whose coefficients are sums
of 1, T_k and T_k² from step j to the last one; they are kept as j falls, and no sum over k is left
for a pair of forces. Turning works alike: there T_k is the 3 × 3 integral of the matrix that turns
angular velocity into rates of roll, pitch, yaw.

Columns are the axes of the standing feet, by step, leg, axis. Inner loops count unsigned, as in
`_qp`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.geometry import GRAVITY, Array
from cavalcade.kernels import kernel, subroutine
from cavalcade.locomotion._qp import solve_qp


class _Steps(NamedTuple):
    """Something at the ends and at the middles of the H steps.

    Times are `(H,)`, s; turns are `(H, 3, 3)`, integrals up to then of the matrix that turns
    angular velocity into rates of roll, pitch, yaw.
    """

    ends: Array
    middles: Array


@kernel
def solve(problem, plan, changes):
    """Find the forces `(H, 4, 3)` that follow the reference best, N; they become `plan`.

    They are zero where a foot swings. The problem's arrays are C-contiguous. Returns how often the
    solver's active set changed: at most `changes` times for every standing foot.
    """
    contacts = problem.contacts
    n = 0
    for k in range(contacts.shape[0]):
        for leg in range(4):
            if contacts[k, leg]:
                n += 3
    hessian, gradient, forces = np.empty((n, n)), np.empty(n), np.empty(n)
    build_qp(problem, hessian, gradient)
    done = solve_qp(hessian, gradient, problem.mu, problem.max_force, forces, changes * n // 3)
    row = 0
    for k in range(contacts.shape[0]):
        for leg in range(4):
            stands = contacts[k, leg] != 0
            for a in range(3):
                plan[k, leg, a] = forces[row + a] if stands else 0.0
            if stands:
                row += 3
    return done


@subroutine(fastmath={"contract", "reassoc"})
def build_qp(problem, hessian, gradient):
    """Fill the `(n, n)` hessian, of which the upper triangle, and the `(n,)` gradient."""
    steps, dts, mass = problem.contacts.shape[0], problem.dts, problem.mass
    times = _Steps(np.empty(steps), np.empty(steps))
    turns = _Steps(np.zeros((steps, 3, 3)), np.zeros((steps, 3, 3)))
    first, spins = np.empty(steps + 1, np.int64), np.empty((3, gradient.shape[0]))
    errors = np.empty((steps, 12))
    _times(problem.yaws, dts, times, turns)
    _spins(problem.contacts, problem.levers, problem.yaws, dts, problem.inertia, first, spins)
    _free_errors(problem.state, problem.reference, problem.weights, times, turns, errors)
    _gradient(errors, first, spins, times, turns, dts, mass, gradient)
    _set_attitude(problem.weights, turns, first, spins, hessian)
    _add_position(problem.weights, first, times, dts, mass, hessian)
    # The forces' own weight, around an equal share of the robot's weight for every standing foot.
    force_weight = problem.force_weight
    for k in range(steps):
        feet = (first[k + 1] - first[k]) // 3
        for column in range(first[k], first[k + 1], 3):
            for a in range(3):
                hessian[column + a, column + a] += force_weight
            gradient[column + 2] -= force_weight * mass * GRAVITY / feet


@subroutine
def _times(yaws, dts, times, turns):
    """Fill times and turns of the steps."""
    ends, middles = times.ends, times.middles
    upto, mids = turns.ends, turns.middles
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
        upto[k, 0, 0] = upto[k, 1, 1] = along
        upto[k, 0, 1], upto[k, 1, 0] = across, -across
        upto[k, 2, 2] = end


@subroutine
def _spins(contacts, levers, yaws, dts, inertia, first, spins):
    """Fill what forces do to the angular velocity, dt I⁻¹ [r]×, and the first column of each step.

    `spins` is `(3, n)`, `first` `(H + 1,)`.
    """
    # The inverse inertia by its cofactors.
    a, b, c = inertia[0, 0], inertia[0, 1], inertia[0, 2]
    d, e, f = inertia[1, 1], inertia[1, 2], inertia[2, 2]
    p, q, r = d * f - e * e, c * e - b * f, b * e - c * d
    s, t, u = a * f - c * c, b * c - a * e, a * d - b * b
    det = a * p + b * q + c * r
    column = 0
    for k in range(contacts.shape[0]):
        first[k] = column
        co, si, scale = math.cos(yaws[k]), math.sin(yaws[k]), dts[k] / det
        # Turned to the world: Rz I⁻¹ Rzᵀ.
        xx = scale * (co * co * p - 2.0 * co * si * q + si * si * s)
        xy = scale * (co * si * (p - s) + (co * co - si * si) * q)
        yy = scale * (si * si * p + 2.0 * co * si * q + co * co * s)
        xz, yz, zz = scale * (co * r - si * t), scale * (si * r + co * t), scale * u
        for leg in range(4):
            if contacts[k, leg]:
                x, y, z = levers[k, leg, 0], levers[k, leg, 1], levers[k, leg, 2]
                spins[0, column], spins[0, column + 1] = xy * z - xz * y, xz * x - xx * z
                spins[1, column], spins[1, column + 1] = yy * z - yz * y, yz * x - xy * z
                spins[2, column], spins[2, column + 1] = yz * z - zz * y, zz * x - xz * z
                spins[0, column + 2] = xx * y - xy * x
                spins[1, column + 2] = xy * y - yy * x
                spins[2, column + 2] = xz * y - yz * x
                column += 3
    first[contacts.shape[0]] = column


@subroutine
def _free_errors(state, reference, weights, times, turns, errors):
    """Fill the weighted errors `(H, 12)` of the motion without any force on the feet."""
    for k in range(errors.shape[0]):
        t = times.ends[k]
        for a in range(3):
            angle = state[a]
            for b in range(3):
                angle += turns.ends[k, a, b] * state[6 + b]
            pull = -GRAVITY if a == 2 else 0.0
            place = state[3 + a] + t * (state[9 + a] + 0.5 * pull * t)
            errors[k, a] = weights[a] * (angle - reference[k, a])
            errors[k, 3 + a] = weights[3 + a] * (place - reference[k, 3 + a])
            errors[k, 6 + a] = weights[6 + a] * (state[6 + a] - reference[k, 6 + a])
            errors[k, 9 + a] = weights[9 + a] * (state[9 + a] + pull * t - reference[k, 9 + a])


@subroutine
def _gradient(errors, first, spins, times, turns, dts, mass, gradient):
    """Fill the gradient: what the errors of all later steps ask of a step's forces."""
    ends, middles, mids = times.ends, times.middles, turns.middles
    angle, angle1, spin = np.zeros(3), np.zeros(3), np.zeros(3)  # sums; 1: times the integral
    place, place1, speed = np.zeros(3), np.zeros(3), np.zeros(3)
    force, moment = np.empty(3), np.empty(3)
    for j in range(ends.shape[0] - 1, -1, -1):
        # Sums of errors from this step to the last one.
        for a in range(3):
            angle[a] += errors[j, a]
            place[a] += errors[j, 3 + a]
            spin[a] += errors[j, 6 + a]
            speed[a] += errors[j, 9 + a]
            place1[a] += ends[j] * errors[j, 3 + a]
            for b in range(3):
                angle1[a] += turns.ends[j, b, a] * errors[j, b]
        # What they ask of a force at the centre of mass, and of a moment about it.
        for a in range(3):
            force[a] = dts[j] / mass * (place1[a] - middles[j] * place[a] + speed[a])
            moment[a] = angle1[a] + spin[a]
            for b in range(3):
                moment[a] -= mids[j, b, a] * angle[b]
        for column in range(first[j], first[j + 1], 3):
            for a in range(3):
                gradient[column + a] = force[a]
                for b in range(3):
                    gradient[column + a] += spins[b, column + a] * moment[b]


@subroutine(fastmath={"contract", "reassoc"})
def _set_attitude(weights, turns, first, spins, hessian):
    """Set the hessian's upper triangle to the part of angles and angular velocities.

    Σ (turn_k - mid_i)ᵀ W (turn_k - mid_j) = fixed_j + mid_iᵀ linear_j, k from j to the last step.
    """
    upto, mids = turns.ends, turns.middles
    steps = upto.shape[0]
    fixed, linear = np.empty((steps, 3, 3)), np.empty((steps, 3, 3))
    once, twice = np.zeros((3, 3)), np.zeros((3, 3))  # Σ W turn, Σ turnᵀ W turn
    for j in range(steps - 1, -1, -1):
        count = float(steps - j)
        for a in range(3):
            for b in range(3):
                once[a, b] += weights[a] * upto[j, a, b]
                for c in range(3):
                    twice[a, b] += upto[j, c, a] * weights[c] * upto[j, c, b]
        for a in range(3):
            for b in range(3):
                linear[j, a, b] = count * weights[a] * mids[j, a, b] - once[a, b]
                fixed[j, a, b] = twice[a, b]
                for c in range(3):
                    fixed[j, a, b] -= once[c, a] * mids[j, c, b]
            fixed[j, a, a] += count * weights[6 + a]
    # Rows of step i: its matrix with every later step j, then the spins on both sides of it.
    n = np.uint64(spins.shape[1])
    wide = np.empty((3, spins.shape[1]))
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
                    wide[a, c] = x * spins[0, c] + y * spins[1, c] + z * spins[2, c]
        for r in range(first[i], first[i + 1]):
            x, y, z = spins[0, r], spins[1, r], spins[2, r]
            for c in range(np.uint64(first[i]), n):
                hessian[r, c] = x * wide[0, c] + y * wide[1, c] + z * wide[2, c]


@subroutine
def _add_position(weights, first, times, dts, mass, hessian):
    """Add the hessian's part of positions and velocities: pairs of feet along the same axis."""
    ends, middles = times.ends, times.middles
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
