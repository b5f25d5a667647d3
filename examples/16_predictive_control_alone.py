"""Predictive control alone: forces of four feet that bring a pushed body back to rest."""

from __future__ import annotations

import numpy as np

from cavalcade.locomotion import MpcProblem, solve_mpc

STEPS, HEIGHT = 10, 0.28
rest = np.zeros(12)  # roll, pitch, yaw, position, angular velocity, velocity
rest[5] = HEIGHT
pushed = rest.copy()
pushed[9] = 0.3  # m/s ahead
feet = np.array([[0.19, 0.13], [0.19, -0.13], [-0.19, 0.13], [-0.19, -0.13]])
levers = np.column_stack([feet, np.full(4, -HEIGHT)])

problem = MpcProblem(
    state=pushed,
    reference=np.tile(rest, (STEPS, 1)),
    contacts=np.ones((STEPS, 4), dtype=bool),
    levers=np.tile(levers, (STEPS, 1, 1)),
    yaws=np.zeros(STEPS),
    dts=np.full(STEPS, 0.04),
    inertia=np.diag([0.08, 0.26, 0.28]),
    mass=12.7,
    weights=np.array([2, 2, 2, 4, 4, 50, 0.02, 0.02, 0.15, 0.6, 0.6, 0.2]),
)
solution = solve_mpc(problem)
print("forces on the feet now, N, world frame:")
print(np.round(solution.forces[0], 1))
print(f"they brake with {-solution.forces[0, :, 0].sum():.0f} N")
