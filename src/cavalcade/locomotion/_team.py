"""Every robot's step, whatever it is doing, compiled."""

from __future__ import annotations

from numba import njit

from cavalcade.locomotion._leap import step_leap
from cavalcade.locomotion._walk import step_walk
from cavalcade.locomotion.records import LEAPING, Measured


@njit(cache=True)
def step_team(team, footing, measured, torques):
    """Torques for all robots: `step_leap` for those that leap, `step_walk` for the others.

    Args:
        team: The rows of all robots, a `Team`; states, leaps and bodies change.
        footing: What feet stand on, a `Footing`.
        measured: Of all robots, a `Measured`.
        torques: `(N, 12)`, overwritten, N m.
    """
    for n in range(team.robots.shape[0]):
        own = Measured(measured.time, measured.qpos[n], measured.qvel[n], measured.feet[n])
        robot, state, body = team.robots[n], team.states[n], team.bodies[n]
        if state.mode == LEAPING:
            step_leap(robot, state, team.leaps[n], body, own, torques[n])
        else:
            step_walk(robot, team.gaits[n], state, body, footing, own, torques[n])
