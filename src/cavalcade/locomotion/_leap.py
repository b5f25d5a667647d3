"""One step of a leap, compiled: phases, flying legs and touch-down."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.locomotion._centroid import centroid
from cavalcade.locomotion._control import FALL, limit, push, stand
from cavalcade.locomotion._kinematics import (
    GRAVITY,
    leg_forward,
    leg_inverse,
    solve3,
    turned_back,
)
from cavalcade.locomotion._leap_horizon import solve_leap
from cavalcade.locomotion._legs import look
from cavalcade.locomotion._swing import smooth
from cavalcade.locomotion.leap_records import FLIGHT, LANDING
from cavalcade.locomotion.records import FALLEN

LOST = 0.35
"""A flight that lasts so much longer than planned has failed, s."""


@njit(cache=True)
def leap_on(robot, state, leap, body, time, qpos, qvel, feet, torques):
    """Torques for one robot that leaps.

    Args:
        robot, state, leap: Rows of `ROBOT`, `STATE`, `LEAP`; the last two change.
        body: A row of `BODY`, overwritten.
        time: Now, s.
        qpos, qvel: `(19,)`, `(18,)` as MuJoCo has them.
        feet: `(4,)` normal forces on the feet, N.
        torques: `(12,)`, overwritten, N m.
    """
    state.time = time
    look(robot, qpos, qvel, body)
    centre, velocity, spin = np.empty(3), np.empty(3), np.empty(3)
    centroid(robot, qpos, qvel, body, centre, velocity, spin)
    if max(abs(body.angles[0]), abs(body.angles[1])) > FALL:
        state.mode = FALLEN
        leap.failed = 1
        for j in range(12):
            torques[j] = -1.0 * qvel[6 + j]
        return
    if leap.began < 0.0:
        leap.began = time
        for a in range(3):
            leap.start[a] = centre[a]
    changed = advance(robot, state, leap, body, centre, velocity, feet)
    if leap.phase != FLIGHT and (changed or time - state.solved >= leap.interval - 1e-9):
        solve_leap(robot, leap, state, body, centre, velocity, spin)
        state.solved = time
    for leg in range(4):
        if state.contact[leg] == 1:
            push(robot, state, body, leg, qpos, qvel, torques)
        else:
            fly(robot, state, leap, body, centre, velocity, leg, qpos, qvel, torques)
    limit(robot, torques)


@njit(cache=True)
def advance(robot, state, leap, body, centre, velocity, feet):
    """Go on to the next phase where its time has come; whether contacts changed."""
    t = state.time - leap.began
    if leap.phase < FLIGHT and t >= leap.lasts[leap.phase] - 1e-9:
        leap.began = state.time
        leap.phase += 1
        if leap.phase == FLIGHT:
            for leg in range(4):
                state.contact[leg] = 0
                for a in range(3):
                    leap.left[leg, a] = body.foot[leg, a] - centre[a]
        return True
    if leap.phase == FLIGHT:
        foresee(leap, state, centre, velocity)
        if t > leap.lasts[FLIGHT] + LOST:
            leap.failed = 1
    if leap.phase >= FLIGHT:
        changed = False
        for leg in range(4):
            late = leap.phase == LANDING or t > 0.5 * leap.lasts[FLIGHT]
            if state.contact[leg] == 0 and late and feet[leg] > leap.touch:
                state.contact[leg] = 1
                changed = True
                for a in range(3):
                    state.stood[leg, a] = body.foot[leg, a]
        if changed and leap.phase == FLIGHT:
            leap.phase, leap.began = LANDING, state.time
            for a in range(3):
                leap.down[a], leap.down_velocity[a] = centre[a], velocity[a]
                if a < 2:
                    leap.rest[a] += leap.shift[a]
            leap.pitches[2] = body.angles[1]
        if leap.phase == LANDING and state.time - leap.began > leap.lasts[LANDING]:
            settle(robot, state, leap, body)
        return changed
    return False


@njit(cache=True)
def foresee(leap, state, centre, velocity):
    """When the flight will end, and where footholds meet the body then."""
    t = state.time - leap.began
    drop = centre[2] - leap.down[2]
    root = velocity[2] * velocity[2] + 2.0 * GRAVITY * drop
    left = (velocity[2] + math.sqrt(max(root, 0.0))) / GRAVITY
    if left > 0.02:
        leap.lasts[FLIGHT] = t + left
        for a in range(2):
            leap.shift[a] = centre[a] + velocity[a] * left - leap.down[a]


@njit(cache=True)
def settle(robot, state, leap, body):
    """Stand where the robot has landed."""
    if min(state.contact[0], state.contact[1], state.contact[2], state.contact[3]) == 0:
        if state.time - leap.began > leap.lasts[LANDING] + LOST:
            leap.failed = 1
        else:
            return
    for leg in range(4):
        for a in range(3):
            state.stood[leg, a] = body.foot[leg, a]
    mean = 0.25 * (body.foot[0, 2] + body.foot[1, 2] + body.foot[2, 2] + body.foot[3, 2])
    state.ground = mean - robot.foot_radius
    state.slope[:] = 0.0
    state.velocity[:] = 0.0
    state.idle = state.time
    stand(robot, state, body)


@njit(cache=True)
def foot_way(robot, leap, state, centre, leg, t, place, velocity):
    """Where a flying foot is to be, from the centre of mass, and how fast it moves there."""
    lasts = leap.lasts[FLIGHT]
    goal = np.empty(3)
    for a in range(3):
        goal[a] = leap.foothold[leg, a] - leap.down[a]
    # The body comes down elsewhere: footholds come along, but not back over the edge.
    x, y = leap.foothold[leg, 0] + leap.shift[0], leap.foothold[leg, 1] + leap.shift[1]
    short = leap.bound - (x * leap.along[0] + y * leap.along[1])
    if short > 0.0:
        goal[0] += short * leap.along[0]
        goal[1] += short * leap.along[1]
    forth = min(t / (0.8 * lasts), 1.0)
    share, rate = smooth(forth)
    for a in range(2):
        place[a] = leap.left[leg, a] + share * (goal[a] - leap.left[leg, a])
        velocity[a] = rate * (goal[a] - leap.left[leg, a]) / (0.8 * lasts) if forth < 1.0 else 0.0
    high = 0.4 * lasts
    if t < high:
        share, rate = smooth(t / high)
        low, up, span = leap.left[leg, 2], -leap.tuck, high
    else:
        span = 0.5 * lasts
        s = min((t - high) / span, 1.0)
        share, rate = smooth(s)
        low, up = -leap.tuck, goal[2]
    place[2] = low + share * (up - low)
    velocity[2] = rate * (up - low) / span


@njit(cache=True)
def fly(robot, state, leap, body, centre, velocity, leg, qpos, qvel, torques):
    """Torques of a leg in the air."""
    place, rate = np.empty(3), np.empty(3)
    t = state.time - leap.began
    if leap.phase == LANDING:
        t += leap.lasts[FLIGHT]
    foot_way(robot, leap, state, centre, leg, t, place, rate)
    arm, wanted, back = np.empty(3), np.empty(3), np.empty(3)
    for a in range(3):
        arm[a] = place[a] + centre[a] - body.trunk[a]
        joint_part = 0.0
        for j in range(3):
            part = 0.0
            for b in range(3):
                part += body.matrix[a, b] * body.jacobian[leg, b, j]
            joint_part += part * qvel[6 + 3 * leg + j]
        # Against the trunk as it moves, less the centre of mass's own motion.
        rate[a] += velocity[a] - (body.foot_velocity[leg, a] - joint_part)
    turned_back(body.matrix, arm, wanted)
    joints, speeds = np.empty(3), np.empty(3)
    jacobian, reached, aimed = np.empty((3, 3)), np.empty(3), np.empty(12)
    leg_inverse(robot, leg, wanted, joints)
    turned_back(body.matrix, rate, back)
    for j in range(3):
        aimed[3 * leg + j] = joints[j]
    leg_forward(robot, leg, aimed, reached, jacobian)
    solve3(jacobian, back, speeds)
    for j in range(3):
        joint = 3 * leg + j
        speed = min(max(speeds[j], -25.0), 25.0)
        torques[joint] = leap.stiffness * (joints[j] - qpos[7 + joint]) + leap.joint_damping * (
            speed - qvel[6 + joint]
        )
