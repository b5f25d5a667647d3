"""Convex model predictive control of a legged body, compiled: forces that follow a reference.

One rigid body, linearised about its yaw, whose only inputs are the forces on the feet that stand:
Di Carlo, Wensing, Katz, Bledt, Kim, "Dynamic locomotion in the MIT Cheetah 3 through convex
model-predictive control", IROS 2018. The programme in forces alone is built by `_mpc_build`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cavalcade.locomotion._mpc_build import build_qp, count_stance
from cavalcade.locomotion._qp import solve_qp


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
    plan,
    changes,
):
    """The forces on the feet that follow a reference best.

    They minimise the weighted squares of the state's errors at the ends of all H steps and of
    the forces' differences from an equal share of the weight, so that standing at the reference
    costs nothing. The answer depends on the arguments alone, not on an earlier one.

    Args:
        state: `(12,)` roll, pitch, yaw, position of the centre of mass, angular velocity, velocity;
            world frame, SI.
        reference: `(H, 12)` states wanted at the ends of the steps.
        contacts: `(H, 4)` whether a foot stands in a step.
        levers: `(H, 4, 3)` from the centre of mass to the feet, world frame, m.
        yaws: `(H,)` the yaw about which a step is linearised, rad.
        dts: `(H,)` the steps' lengths, s.
        inertia: `(3, 3)` about the centre of mass, body frame, kg m².
        mass: kg.
        weights: `(12,)` of squared errors of the state.
        force_weight: Of squared forces, 1/N²; greater than 0.
        mu: Friction, greater than 0: |f_x|, |f_y| ≤ mu f_z.
        max_force: Greatest normal force on a foot, N.
        plan: `(H, 4, 3)`, becomes the answer.
        changes: Of the set of limits held by the solver, for every standing foot: at most so
            many; 30 are enough for the wildest questions, and mostly none is needed.

    Returns:
        `plan`: forces of the ground on the feet, world frame, N; zero where a foot swings.
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
    solve_qp(hessian, gradient, mu, max_force, forces, changes * n // 3)
    row = 0
    for k in range(contacts.shape[0]):
        for leg in range(4):
            stands = contacts[k, leg] != 0
            for a in range(3):
                plan[k, leg, a] = forces[row + a] if stands else 0.0
            if stands:
                row += 3
    return plan
