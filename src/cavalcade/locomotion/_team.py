"""Every robot's step, whatever it is doing, compiled."""

from __future__ import annotations

from numba import njit

from cavalcade.locomotion._leap import step_leap
from cavalcade.locomotion._walk import step_walk
from cavalcade.locomotion.records import LEAPING, Measured


@njit(cache=True)
def step_team(team, footing, time, qpos, qvel, feet, torques):
    """Torques for all robots: `step_leap` for those that leap, `step_walk` for the others.

    Args:
        team: `(N,)` of `TEAM`; states, leaps and bodies change.
        footing: What feet stand on, a `Footing`.
        time, qpos, qvel, feet: As of `Measured`, with a first axis for the robots. They come one by
            one: every record that Python hands over costs 2 µs, which is much 500 times a second.
        torques: `(N, 12)`, overwritten, N m.
    """
    for n in range(team.shape[0]):
        own, measured = team[n], Measured(time, qpos[n], qvel[n], feet[n])
        if own.state.mode == LEAPING:
            step_leap(own.robot, own.state, own.leap, own.body, measured, torques[n])
        else:
            step_walk(own.robot, own.gait, own.state, own.body, footing, measured, torques[n])
