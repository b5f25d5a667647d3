"""One step of a leap, compiled: its phases, from the crouch to standing again. World frame, SI."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.locomotion._centroid import centroid
from cavalcade.locomotion._control import FALL, stand
from cavalcade.locomotion._joints import go_limp, limit, push
from cavalcade.locomotion._kinematics import GRAVITY, turned_back
from cavalcade.locomotion._leap_horizon import foothold, solve_leap
from cavalcade.locomotion._leap_legs import fly
from cavalcade.locomotion._legs import look
from cavalcade.locomotion.leap_records import FLIGHT, LANDING, PUSH
from cavalcade.locomotion.records import FALLEN

SHORT, STRETCH = 0.02, 0.92
"""A push goes on while it would end so far short, m, and legs are shorter than that share of their
length."""

ASTRAY = 0.06
"""A leap has failed if a foot stands so much higher or lower than where it should land, m."""

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
        go_limp(qvel, torques)
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
            push(robot, body, leg, state.forces[leg], qpos, qvel, torques)
        else:
            fly(robot, state, leap, body, centre, velocity, leg, qpos, qvel, torques)
    limit(robot, torques)


@njit(cache=True)
def advance(robot, state, leap, body, centre, velocity, feet):
    """Go on to the next phase where its time has come; whether contacts changed."""
    t = state.time - leap.began
    if leap.phase < FLIGHT and t >= leap.lasts[leap.phase] - 1e-9:
        if leap.phase == PUSH and falls_short(robot, leap, body, centre, velocity):
            leap.lasts[PUSH] += leap.interval
            for a in range(3):
                leap.lift[a] += leap.interval * leap.lift_velocity[a]
            return True
        leap.began = state.time
        leap.phase += 1
        if leap.phase == FLIGHT:
            for leg in range(4):
                state.contact[leg] = 0
                for a in range(3):
                    leap.left[leg, a] = body.foot[leg, a]
            leap.lift[2] = centre[2]
        return True
    if leap.phase == FLIGHT:
        foresee(leap, state, centre, velocity)
        if t > leap.lasts[FLIGHT] + LOST:
            leap.failed = 1
            state.mode = FALLEN
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
            # It comes to rest over its feet.
            for a in range(2):
                leap.rest[a] = 0.0
            for leg in range(4):
                x, y = foothold(leap, leg)
                leap.rest[0] += 0.25 * x
                leap.rest[1] += 0.25 * y
            leap.pitches[2] = body.angles[1]
        if leap.phase == LANDING and state.time - leap.began > leap.lasts[LANDING]:
            settle(robot, state, leap, body)
        return changed
    return False


@njit(cache=True)
def falls_short(robot, leap, body, centre, velocity):
    """Whether a flight from now would end too early, and legs are not stretched yet."""
    root = velocity[2] * velocity[2] + 2.0 * GRAVITY * (centre[2] - leap.down[2])
    flight = (velocity[2] + math.sqrt(max(root, 0.0))) / GRAVITY
    short = 0.0
    for a in range(2):
        short += leap.along[a] * (leap.down[a] - centre[a] - velocity[a] * flight)
    if short < SHORT:
        return False
    most = STRETCH * (robot.thigh + robot.calf)
    arm, local = np.empty(3), np.empty(3)
    for leg in range(4):
        for a in range(3):
            arm[a] = body.foot[leg, a] - body.trunk[a]
        turned_back(body.matrix, arm, local)
        x = local[0] - robot.hip[leg, 0]
        y = local[1] - robot.hip[leg, 1] - robot.side[leg]
        z = local[2] - robot.hip[leg, 2]
        if x * x + y * y + z * z > most * most:
            return False
    return True


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
        if abs(body.foot[leg, 2] - leap.foothold[leg, 2]) > ASTRAY:
            leap.failed = 1
    mean = 0.25 * (body.foot[0, 2] + body.foot[1, 2] + body.foot[2, 2] + body.foot[3, 2])
    state.ground = mean - robot.foot_radius
    state.slope[:] = 0.0
    state.velocity[:] = 0.0
    state.idle = state.time
    stand(state, body)
