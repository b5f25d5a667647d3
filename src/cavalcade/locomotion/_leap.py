"""One step of a leap, compiled: phases, flying legs and touch-down."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.locomotion._centroid import centroid
from cavalcade.locomotion._control import FALL, stand
from cavalcade.locomotion._joints import go_limp, limit, push, reach
from cavalcade.locomotion._kinematics import GRAVITY, turned, turned_back
from cavalcade.locomotion._leap_horizon import solve_leap
from cavalcade.locomotion._legs import look
from cavalcade.locomotion._swing import smooth
from cavalcade.locomotion.leap_records import FLIGHT, LANDING
from cavalcade.locomotion.records import FALLEN

FORWARD = (0.1, 0.75)
"""Feet go forward in this part of the flight."""

UP, DOWN = 0.3, (0.6, 0.9)
"""They are drawn up until then and reach down in that part."""

BELOW, BESIDE = 0.11, 0.12
"""Feet stay at least so far below their hips, and at most so far beside their shoulders, m."""

SINK = 0.5
"""A foot that meets no ground goes down with that speed, m/s."""

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
    stand(state, body)


@njit(cache=True)
def foot_way(leap, centre, velocity, leg, t, place, rate):
    """Where a flying foot is to be at `t` s of the flight, world, and how fast it moves there.

    It is drawn up first, then goes forward, then down.
    """
    lasts = leap.lasts[FLIGHT]
    goal, start = leap.foothold[leg], leap.left[leg]
    # The body comes down elsewhere: footholds come along, but not back over the edge.
    x, y = goal[0] + leap.shift[0], goal[1] + leap.shift[1]
    short = max(leap.bound - (x * leap.along[0] + y * leap.along[1]), 0.0)
    x, y = x + short * leap.along[0], y + short * leap.along[1]
    begin, end = FORWARD[0] * lasts, FORWARD[1] * lasts
    share, speed = smooth(min(max((t - begin) / (end - begin), 0.0), 1.0))
    speed /= end - begin
    place[0], place[1] = start[0] + share * (x - start[0]), start[1] + share * (y - start[1])
    rate[0], rate[1] = speed * (x - start[0]), speed * (y - start[1])
    # Heights are from the centre of mass.
    high, down, end = UP * lasts, DOWN[0] * lasts, DOWN[1] * lasts
    low = start[2] - leap.lift[2]
    landed = goal[2] - leap.down[2] - SINK * max(t - lasts, 0.0)
    if t < high:
        share, speed = smooth(t / high)
        place[2] = low - share * (leap.tuck + low)
        rate[2] = -speed / high * (leap.tuck + low)
    else:
        share, speed = smooth(min(max((t - down) / (end - down), 0.0), 1.0))
        place[2] = -leap.tuck + share * (landed + leap.tuck)
        rate[2] = speed / (end - down) * (landed + leap.tuck)
    place[2] += centre[2]
    rate[2] += velocity[2]


@njit(cache=True)
def keep_clear(robot, body, leg, place):
    """Move a foot's goal `(3,)` to where its leg can be whichever way the trunk is turned.

    Near the hip's own axis a small motion of the foot asks for a large one of the joints.
    """
    arm, local = np.empty(3), np.empty(3)
    for a in range(3):
        arm[a] = place[a] - body.trunk[a]
    turned_back(body.matrix, arm, local)
    hip = robot.hip[leg]
    aside = hip[1] + robot.side[leg]
    local[1] = min(max(local[1], aside - BESIDE), aside + BESIDE)
    local[2] = min(local[2], hip[2] - BELOW)
    turned(body.matrix, local, arm)
    for a in range(3):
        place[a] = body.trunk[a] + arm[a]


@njit(cache=True)
def fly(robot, state, leap, body, centre, velocity, leg, qpos, qvel, torques):
    """Torques of a leg in the air."""
    place, rate = np.empty(3), np.empty(3)
    t = state.time - leap.began
    if leap.phase == LANDING:
        t += leap.lasts[FLIGHT]
    foot_way(leap, centre, velocity, leg, t, place, rate)
    keep_clear(robot, body, leg, place)
    reach(robot, body, leg, place, rate, leap.stiffness, leap.joint_damping, qpos, qvel, torques)
