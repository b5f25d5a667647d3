"""The problem of predictive control for a walk: reference, contacts, levers, compiled.

The reference is what the command will have been approached to, and levers are about the centre of
mass where it will be then. World frame, SI; `robot, gait, body, state` are rows of `ROBOT`,
`GAIT`, `BODY` and `STATE`.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import subroutine
from cavalcade.locomotion._kinematics import wrapped
from cavalcade.locomotion._mpc import solve
from cavalcade.locomotion.mpc import MpcProblem
from cavalcade.locomotion.records import CHANGES, STEPS, TROTTING

STILL = 0.02
"""Commands below are none, m/s; twice that in rad/s."""


@subroutine
def swing_share(gait, clock, leg):
    """How far a leg's swing has come at that time of the trot, from 0 to 1; 1 where it stands."""
    phase = gait_phase(gait, clock, leg)
    air = 1.0 - gait.duty
    return phase / air if phase < air else 1.0


@subroutine
def gait_phase(gait, clock, leg):
    """How much of a leg's cycle, a swing and a stance, is over at that time, from 0 to 1."""
    phase = clock / gait.period + gait.offset[leg]
    return phase - math.floor(phase)


@subroutine
def commanded_velocity(gait, state):
    """The velocity to follow, body frame: none after a silence, and none that is next to none.

    A robot that stands would lean after a reference that creeps away.
    """
    vx, vy, wz = state.wanted[0], state.wanted[1], state.wanted[2]
    small = math.hypot(vx, vy) <= STILL and abs(wz) <= 2.0 * STILL
    if small or state.time - state.heard > gait.silence:
        return 0.0, 0.0, 0.0
    return vx, vy, wz


@subroutine
def approach(gait, velocity, vx, vy, wz, passed):
    """Let a velocity `(3,)` in the body frame approach another one for `passed` s."""
    reach, turn = gait.acceleration * passed, gait.turning * passed
    dx, dy = vx - velocity[0], vy - velocity[1]
    length = math.hypot(dx, dy)
    share = 1.0 if length <= reach else reach / length
    velocity[0] += share * dx
    velocity[1] += share * dy
    velocity[2] += min(max(wz - velocity[2], -turn), turn)


@subroutine
def present_state(angles, centre, spin, velocity, yaw):
    """The state `(12,)` of an `MpcProblem`; `yaw`, unwrapped, replaces that of the angles."""
    state = np.empty(12)
    for a in range(3):
        state[a], state[3 + a], state[6 + a] = angles[a], centre[a], spin[a]
        state[9 + a] = velocity[a]
    state[2] = yaw
    return state


@subroutine
def solve_forces(problem, state):
    """Set `state.forces` to those of the solution's first step."""
    plan = np.empty((STEPS, 4, 3))
    solve(problem, plan, CHANGES)
    for leg in range(4):
        for a in range(3):
            state.forces[leg, a] = plan[0, leg, a]


@subroutine
def walk_problem(robot, gait, body, state):
    """The `MpcProblem` of a robot that trots or stands.

    Feet act on the centre of mass where that will be, not where it is: its motion over the
    horizon is some of a leg's length.
    """
    reference = np.zeros((STEPS, 12))
    contacts = np.zeros((STEPS, 4), np.int64)
    levers = np.zeros((STEPS, 4, 3))
    yaws = np.empty(STEPS)
    measured_yaw = state.yaw + wrapped(body.angles[2] - state.yaw)
    trots = state.mode == TROTTING
    clock = state.time - state.began
    height = state.ground + gait.height + robot.centre[2]
    x, y, at_x, at_y = state.place[0], state.place[1], body.centre[0], body.centre[1]
    velocity, half = state.velocity.copy(), 0.5 * gait.step
    goal_x, goal_y, goal_turn = commanded_velocity(gait, state)
    yaw = state.yaw
    for k in range(STEPS):
        # The command as it will be approached: up to the middle of the step, for yaw and levers ...
        middle = (k + 0.5) * gait.step
        rate = velocity[2]
        approach(gait, velocity, goal_x, goal_y, goal_turn, half)
        yaw += 0.5 * (rate + velocity[2]) * half
        c, s = math.cos(yaw), math.sin(yaw)
        vx, vy = c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]
        yaws[k] = measured_yaw + yaw - state.yaw
        half_x, half_y = at_x + half * vx, at_y + half * vy
        x, y = x + gait.step * vx, y + gait.step * vy
        at_x, at_y = at_x + gait.step * vx, at_y + gait.step * vy
        # ... and up to its end, for the reference.
        rate = velocity[2]
        approach(gait, velocity, goal_x, goal_y, goal_turn, half)
        yaw += 0.5 * (rate + velocity[2]) * half
        c, s = math.cos(yaw), math.sin(yaw)
        vx, vy = c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]
        moved_x, moved_y = at_x - body.centre[0], at_y - body.centre[1]
        climb = state.slope[0] * moved_x + state.slope[1] * moved_y
        # A trunk that follows the ground: its nose rises (negative pitch) uphill.
        reference[k, 0] = math.atan(-s * state.slope[0] + c * state.slope[1])
        reference[k, 1] = -math.atan(c * state.slope[0] + s * state.slope[1])
        reference[k, 2] = yaw
        reference[k, 3], reference[k, 4], reference[k, 5] = x, y, height + climb
        reference[k, 8] = velocity[2]
        reference[k, 9], reference[k, 10] = vx, vy
        reference[k, 11] = state.slope[0] * vx + state.slope[1] * vy
        # Feet that will have stepped stand below their hips, others where they are or will land.
        for leg in range(4):
            contacts[k, leg] = _stands(gait, state, clock, k, leg)
            if trots and middle >= (1.0 - gait_phase(gait, clock, leg)) * gait.period:
                # Time until the middle of the stance that it is in or comes to; may be negative.
                ahead = 1.0 - 0.5 * gait.duty - gait_phase(gait, clock + middle, leg)
                wait = ahead * gait.period
                px, py = _below_hip(robot, half_x + wait * vx, half_y + wait * vy, c, s, leg)
                rise_x, rise_y = px - body.centre[0], py - body.centre[1]
                pz = state.ground + state.slope[0] * rise_x + state.slope[1] * rise_y
            else:
                down = state.swinging[leg] == 0 or state.contact[leg] == 1
                place = state.stood[leg] if down else state.landing[leg]
                px, py, pz = place[0], place[1], place[2] - robot.foot_radius
            levers[k, leg, 0] = px - half_x
            levers[k, leg, 1] = py - half_y
            levers[k, leg, 2] = pz - (height + climb)
    return MpcProblem(
        present_state(body.angles, body.centre, body.spin, body.velocity, measured_yaw),
        reference,
        contacts,
        levers,
        yaws,
        np.full(STEPS, gait.step),
        robot.inertia,
        robot.mass,
        gait.weights,
        gait.force_weight,
        gait.mu,
        gait.max_force,
    )


@subroutine
def _stands(gait, state, clock, k, leg):
    """Whether a foot stands in step k of the horizon."""
    if k == 0:
        return state.contact[leg] == 1 or state.swinging[leg] == 0
    if state.mode != TROTTING:
        return True
    later = clock + (k + 0.5) * gait.step
    if swing_share(gait, later, leg) >= 1.0:
        return True
    # One that has come down early stays for the rest of its swing.
    early = state.contact[leg] == 1 and state.swinging[leg] == 1
    offset = gait.offset[leg]
    return early and math.floor(later / gait.period + offset) == math.floor(
        clock / gait.period + offset
    )


@subroutine
def _below_hip(robot, x, y, c, s, leg):
    """Where a foot stands under its hip when the centre of mass is at (x, y)."""
    ahead = robot.hip[leg, 0] - robot.centre[0]
    aside = robot.hip[leg, 1] + robot.side[leg] - robot.centre[1]
    return x + c * ahead - s * aside, y + s * ahead + c * aside
