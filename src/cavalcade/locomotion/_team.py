"""Every robot's step, whatever it is doing, compiled."""

from __future__ import annotations

from cavalcade.kernels import kernel, subroutine
from cavalcade.locomotion._joints import go_limp, limit_torques
from cavalcade.locomotion._kinematics import measure_body
from cavalcade.locomotion._leap import step_leap
from cavalcade.locomotion._walk import step_posture, step_walk
from cavalcade.locomotion.records import FALLEN, LEAPING, LYING, RISING, SINKING, Measured

FALL = 1.0  # a trunk that leans by more has fallen, rad


@kernel
def step_team(team, footing, time, qpos, qvel, feet, torques):
    """Torques for all robots.

    Args:
        team: `(N,)` of `TEAM`; states, leaps and bodies change.
        footing: What feet stand on, a `Footing`.
        time, qpos, qvel, feet: As of `Measured`, with a first axis for the robots. They come one by
            one: every record that Python hands over costs 2 µs, which is much 500 times a second.
        torques: `(N, 12)`, overwritten, N m.
    """
    for n in range(team.shape[0]):
        step_robot(team[n], footing, Measured(time, qpos[n], qvel[n], feet[n]), torques[n])


@subroutine
def step_robot(own, footing, measured, torques):
    """Torques `(12,)`, overwritten, N m, of a robot, a row of `TEAM`, as it is `Measured` now."""
    state, body = own.state, own.body
    passed = measured.time - state.time
    state.time = measured.time
    measure_body(own.robot, measured, body)
    # Robots that have fallen or lie only brake; those between lying and standing fold their legs.
    if max(abs(body.angles[0]), abs(body.angles[1])) > FALL:
        if state.mode == LEAPING:
            leap = own.leap
            leap.failed = 1
        state.mode = FALLEN
    if state.mode == FALLEN or state.mode == LYING:
        go_limp(measured, torques)
        return
    if state.mode == LEAPING:
        step_leap(own.robot, state, own.leap, body, measured, torques)
    elif state.mode == RISING or state.mode == SINKING:
        step_posture(own.robot, own.gait, state, body, measured, torques)
    else:
        step_walk(own, footing, passed, measured, torques)
    limit_torques(own.robot, torques)
