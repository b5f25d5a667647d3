"""Convex model predictive control of a legged body, compiled: forces that follow a reference.

One rigid body, linearised about its yaw, whose only inputs are the forces on the feet that stand:
Di Carlo, Wensing, Katz, Bledt, Kim, "Dynamic locomotion in the MIT Cheetah 3 through convex
model-predictive control", IROS 2018. The states are eliminated. Forces are constant within a
step and the linear model is integrated exactly, so a force of step j moves the position at the end
of step k by dt_j / m (T_k - τ_j), where T_k is the end of step k and τ_j the middle of step j, and
every sum over steps is a difference of sums that are kept. Turning works alike with 3 × 3 matrices.

States are roll, pitch, yaw, x, y, z, angular velocity, velocity; world frame; SI.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.locomotion._qp import solve_qp

GRAVITY = 9.81
TOLERANCE = 1e-3


@njit(cache=True, fastmath={"contract"})
def count_stance(contacts):
    """How many feet stand over all steps."""
    count = 0
    for k in range(contacts.shape[0]):
        for leg in range(contacts.shape[1]):
            if contacts[k, leg]:
                count += 1
    return count


@njit(cache=True, fastmath={"contract"})
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
    """The programme in the forces of standing feet, ordered by step, leg, axis.

    Forces are drawn towards an equal share of the weight, so that standing needs no error.

    Args:
        state, ..., force_weight: As of `solve_mpc`.
        hessian, gradient: `(n, n)`, `(n,)`, n = 3 for every standing foot; overwritten.
    """
    steps = contacts.shape[0]
    inverse = np.linalg.inv(inertia)
    # Turning: angles' rate is S ω with S = [[c, s, 0], [-s, c, 0], [0, 0, 1]].
    turn = np.zeros((steps, 3, 3))  # ∫ S from now to the end of the step
    mid = np.zeros((steps, 3, 3))  # what a torque of the step misses of it
    spin = np.zeros((steps, 3, 3))  # dt times the inverse inertia in the world frame
    ends = np.empty(steps)
    mids = np.empty(steps)
    time = 0.0
    total = np.zeros((3, 3))
    for k in range(steps):
        c, s, dt = math.cos(yaws[k]), math.sin(yaws[k]), dts[k]
        mids[k] = time + 0.5 * dt
        time += dt
        ends[k] = time
        rate = np.zeros((3, 3))
        rate[0, 0], rate[0, 1], rate[1, 0], rate[1, 1], rate[2, 2] = c, s, -s, c, 1.0
        for i in range(3):
            for j in range(3):
                mid[k, i, j] = total[i, j] + 0.5 * dt * rate[i, j]
                total[i, j] += dt * rate[i, j]
                turn[k, i, j] = total[i, j]
        for i in range(3):
            for j in range(3):
                value = 0.0
                for a in range(3):
                    for b in range(3):
                        value += rate[a, i] * inverse[a, b] * rate[b, j]
                spin[k, i, j] = dt * value
    # What happens without any force, against the reference, weighted.
    error = np.empty((steps, 12))
    for k in range(steps):
        t = ends[k]
        for i in range(3):
            angle = state[i]
            for j in range(3):
                angle += turn[k, i, j] * state[6 + j]
            error[k, i] = weights[i] * (angle - reference[k, i])
            fall = -GRAVITY if i == 2 else 0.0
            place = state[3 + i] + t * state[9 + i] + 0.5 * fall * t * t
            error[k, 3 + i] = weights[3 + i] * (place - reference[k, 3 + i])
            error[k, 6 + i] = weights[6 + i] * (state[6 + i] - reference[k, 6 + i])
            speed = state[9 + i] + t * fall
            error[k, 9 + i] = weights[9 + i] * (speed - reference[k, 9 + i])
    # Arms: dt I⁻¹ [r]×, (H, 4, 3, 3).
    arms = np.empty((steps, 4, 3, 3))
    first = np.empty(steps + 1, np.int64)
    column = 0
    for k in range(steps):
        first[k] = column
        for leg in range(4):
            if contacts[k, leg]:
                x, y, z = levers[k, leg, 0], levers[k, leg, 1], levers[k, leg, 2]
                for i in range(3):
                    p, q, r = spin[k, i, 0], spin[k, i, 1], spin[k, i, 2]
                    arms[k, leg, i, 0] = q * z - r * y
                    arms[k, leg, i, 1] = r * x - p * z
                    arms[k, leg, i, 2] = p * y - q * x
                column += 3
    first[steps] = column
    # Sums from step j to the end, j falling.
    sum0, sum1, sum2 = 0.0, 0.0, 0.0
    turn1 = np.zeros((3, 3))  # Σ W turn
    turn2 = np.zeros((3, 3))  # Σ turnᵀ W turn
    pull = np.zeros(3)  # Σ W e of places
    pull1 = np.zeros(3)  # Σ T W e
    push = np.zeros(3)  # Σ W e of velocities
    twist = np.zeros(3)  # Σ W e of angles
    twist1 = np.zeros(3)  # Σ turnᵀ W e
    swirl = np.zeros(3)  # Σ W e of angular velocities
    middle = np.empty((3, 3))
    left = np.empty((3, 3))
    for j in range(steps - 1, -1, -1):
        t = ends[j]
        sum0 += 1.0
        sum1 += t
        sum2 += t * t
        for a in range(3):
            pull[a] += error[j, 3 + a]
            pull1[a] += t * error[j, 3 + a]
            push[a] += error[j, 9 + a]
            twist[a] += error[j, a]
            swirl[a] += error[j, 6 + a]
            for b in range(3):
                turn1[a, b] += weights[a] * turn[j, a, b]
                twist1[a] += turn[j, b, a] * error[j, b]
                for c in range(3):
                    turn2[a, b] += turn[j, c, a] * weights[c] * turn[j, c, b]
        if first[j] == first[j + 1]:
            continue
        scale = dts[j] / mass
        torque = np.empty(3)
        force = np.empty(3)
        for a in range(3):
            force[a] = scale * (pull1[a] - mids[j] * pull[a] + push[a])
            torque[a] = twist1[a] + swirl[a]
            for b in range(3):
                torque[a] -= mid[j, b, a] * twist[b]
        share = force_weight * mass * GRAVITY * 3.0 / (first[j + 1] - first[j])
        row = first[j]
        for leg in range(4):
            if contacts[j, leg]:
                arm = arms[j, leg]
                for a in range(3):
                    gradient[row + a] = (
                        force[a]
                        + arm[0, a] * torque[0]
                        + arm[1, a] * torque[1]
                        + arm[2, a] * torque[2]
                    )
                gradient[row + 2] -= share
                row += 3
        for i in range(j + 1):
            if first[i] == first[i + 1]:
                continue
            # Turning of step i with turning of step j: Σ (turn - mid_i)ᵀ W (turn - mid_j).
            for a in range(3):
                for b in range(3):
                    value = turn2[a, b]
                    for c in range(3):
                        value += (
                            mid[i, c, a] * (sum0 * weights[c] * mid[j, c, b] - turn1[c, b])
                            - turn1[c, a] * mid[j, c, b]
                        )
                    middle[a, b] = value
                middle[a, a] += sum0 * weights[6 + a]
            both = scale * dts[i] / mass
            moment = sum2 - (mids[i] + mids[j]) * sum1 + mids[i] * mids[j] * sum0
            mx = both * (weights[3] * moment + weights[9] * sum0)
            my = both * (weights[4] * moment + weights[10] * sum0)
            mz = both * (weights[5] * moment + weights[11] * sum0)
            row = first[i]
            for leg in range(4):
                if not contacts[i, leg]:
                    continue
                arm = arms[i, leg]
                for a in range(3):
                    for b in range(3):
                        left[a, b] = (
                            arm[0, a] * middle[0, b]
                            + arm[1, a] * middle[1, b]
                            + arm[2, a] * middle[2, b]
                        )
                column = first[j]
                for other in range(4):
                    if not contacts[j, other]:
                        continue
                    that = arms[j, other]
                    for a in range(3):
                        for b in range(3):
                            value = (
                                left[a, 0] * that[0, b]
                                + left[a, 1] * that[1, b]
                                + left[a, 2] * that[2, b]
                            )
                            hessian[row + a, column + b] = value
                    hessian[row, column] += mx
                    hessian[row + 1, column + 1] += my
                    hessian[row + 2, column + 2] += mz
                    column += 3
                row += 3
    for r in range(first[steps]):
        hessian[r, r] += force_weight
        for c in range(r):
            hessian[r, c] = hessian[c, r]


@njit(cache=True)
def solve_mpc(
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
    mu,
    max_force,
    warm,
    iterations,
):
    """The forces on the feet that follow a reference best.

    Args:
        state: `(12,)`.
        reference: `(H, 12)` states wanted at the ends of the steps.
        contacts: `(H, 4)` whether a foot stands in a step.
        levers: `(H, 4, 3)` from the centre of mass to the feet, world frame, m.
        yaws: `(H,)` the yaw about which a step is linearised, rad.
        dts: `(H,)` the steps' lengths, s.
        inertia: `(3, 3)` about the centre of mass, body frame, kg m².
        mass: kg.
        weights: `(12,)` of squared errors of the state.
        force_weight: Of squared forces, beyond an equal share of the weight, 1/N².
        mu: Friction: |f_x|, |f_y| ≤ mu f_z.
        max_force: Greatest normal force on a foot, N.
        warm: `(H, 4, 3)` forces to start from, N; becomes the solution.
        iterations: At most so many.

    Returns:
        `(H, 4, 3)` forces of the ground on the feet, world frame, N; zero where a foot swings.
    """
    n = 3 * count_stance(contacts)
    hessian, gradient, forces = np.empty((n, n)), np.empty(n), np.empty(n)
    build_qp(
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
    )
    row = 0
    for k in range(contacts.shape[0]):
        for leg in range(4):
            if contacts[k, leg]:
                for a in range(3):
                    forces[row + a] = warm[k, leg, a]
                row += 3
    solve_qp(hessian, gradient, mu, max_force, forces, 10.0 * force_weight, iterations, TOLERANCE)
    result = np.zeros((contacts.shape[0], 4, 3))
    row = 0
    for k in range(contacts.shape[0]):
        for leg in range(4):
            if contacts[k, leg]:
                for a in range(3):
                    result[k, leg, a] = forces[row + a]
                row += 3
    warm[:] = result
    return result
