"""One step of a leap, compiled: its phases from the crouch to standing again, and legs in flight.

Below, `robot, state, leap, body` are rows of `ROBOT`, `STATE`, `LEAP` and `BODY`, of which the
last three change; `centroid` is the robot's `Centroid`. World frame, SI.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.geometry import GRAVITY
from cavalcade.kernels import subroutine
from cavalcade.locomotion._centroid import measure_centroid
from cavalcade.locomotion._horizon import solve_forces
from cavalcade.locomotion._joints import stance_torques, track_foot
from cavalcade.locomotion._kinematics import turned, turned_back
from cavalcade.locomotion._leap_horizon import foothold, leap_problem
from cavalcade.locomotion._swing import smooth
from cavalcade.locomotion._walk import stand
from cavalcade.locomotion.records import FALLEN, FLIGHT, LANDING, PUSH, FootTarget

SHORT, STRETCH = 0.02, 0.92
"""A push goes on while it would end so far short, m, and legs are shorter than that share of their
length."""

ASTRAY = 0.06
"""A leap has failed if a foot stands so much higher or lower than where it should land, m."""

LOST = 0.35  # a flight that lasts so much longer than planned has failed, s
FORWARD = (0.1, 0.75)  # feet go forward in this part of the flight

UP, DOWN = 0.3, (0.6, 0.9)
"""Feet are tucked until that share of the flight, and reach down in that part of it."""

BELOW, BESIDE = 0.11, 0.12
"""Feet stay at least so far below their hips, and at most so far beside their shoulders, m."""

SINK = 0.5  # a foot that meets no ground goes down with that speed, m/s


@subroutine
def step_leap(robot, state, leap, body, measured, torques):
    """Torques `(12,)`, overwritten, N m, for a robot that leaps, `Measured` now."""
    centroid = measure_centroid(robot, measured, body)
    if leap.began < 0.0:
        leap.began = state.time
        for a in range(3):
            leap.start[a] = centroid.centre[a]
    changed = advance(robot, state, leap, body, centroid, measured.feet)
    if leap.phase != FLIGHT and (changed or state.time - state.solved >= leap.interval - 1e-9):
        solve_forces(leap_problem(robot, leap, state, body, centroid), state)
        state.solved = state.time
    for leg in range(4):
        if state.contact[leg] == 1:
            stance_torques(robot, body, leg, state.forces[leg], measured, torques)
        else:
            flight_torques(robot, leap, body, centroid, leg, measured, torques)


@subroutine
def advance(robot, state, leap, body, centroid, feet):
    """Go on to the next phase where its time has come; whether contacts changed.

    `feet` `(4,)` are the normal forces on the feet, N.
    """
    t = state.time - leap.began
    # Crouch and push end by the clock, a push that falls short a little later.
    if leap.phase < FLIGHT and t >= leap.lasts[leap.phase] - 1e-9:
        if leap.phase == PUSH and falls_short(robot, leap, body, centroid):
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
            leap.lift[2] = centroid.centre[2]
        return True
    if leap.phase < FLIGHT:
        return False
    if leap.phase == FLIGHT:
        predict_touch_down(leap, state, centroid)
        if t > leap.lasts[FLIGHT] + LOST:
            leap.failed = 1
            state.mode = FALLEN
    # The first foot that touches ends the flight; each one stands from its own touch-down on.
    changed = False
    for leg in range(4):
        late = leap.phase == LANDING or t > 0.5 * leap.lasts[FLIGHT]
        if state.contact[leg] == 0 and late and feet[leg] > leap.touch:
            state.contact[leg] = 1
            changed = True
            for a in range(3):
                state.stood[leg, a] = body.foot[leg, a]
    if changed and leap.phase == FLIGHT:
        land(state, leap, body, centroid)
    if leap.phase == LANDING and state.time - leap.began > leap.lasts[LANDING]:
        settle(robot, state, leap, body)
    return changed


@subroutine
def land(state, leap, body, centroid):
    """Begin the landing: from the body's state now to rest over the footholds."""
    leap.phase, leap.began = LANDING, state.time
    for a in range(3):
        leap.down[a], leap.down_velocity[a] = centroid.centre[a], centroid.velocity[a]
    leap.rest[0] = leap.rest[1] = 0.0
    for leg in range(4):
        x, y = foothold(leap, leg)
        leap.rest[0] += 0.25 * x
        leap.rest[1] += 0.25 * y
    leap.pitches[2] = body.angles[1]


@subroutine
def time_to_fall(leap, centroid):
    """How long a free flight from now takes to the height of the touch-down, s."""
    speed = centroid.velocity[2]
    root = speed * speed + 2.0 * GRAVITY * (centroid.centre[2] - leap.down[2])
    return (speed + math.sqrt(max(root, 0.0))) / GRAVITY


@subroutine
def falls_short(robot, leap, body, centroid):
    """Whether a flight from now would end too early, and legs are not stretched yet."""
    flight = time_to_fall(leap, centroid)
    short = 0.0
    for a in range(2):
        short += leap.along[a] * (leap.down[a] - centroid.centre[a] - centroid.velocity[a] * flight)
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


@subroutine
def predict_touch_down(leap, state, centroid):
    """Set when the flight will end, and shift footholds to where they meet the body then."""
    left = time_to_fall(leap, centroid)
    if left > 0.02:
        leap.lasts[FLIGHT] = state.time - leap.began + left
        for a in range(2):
            leap.shift[a] = centroid.centre[a] + centroid.velocity[a] * left - leap.down[a]


@subroutine
def settle(robot, state, leap, body):
    """Stand where the robot has landed, once all feet do or have had their time."""
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


@subroutine
def flying_foot(leap, centroid, leg, t, place, rate):
    """Where a flying foot is to be at `t` s of the flight, and its velocity; `(3,)`, overwritten.

    It is tucked first, then goes forward, then down. `centroid` is the robot's `Centroid`.
    """
    lasts = leap.lasts[FLIGHT]
    goal, start = leap.foothold[leg], leap.left[leg]
    x, y = foothold(leap, leg)
    begin, end = FORWARD[0] * lasts, FORWARD[1] * lasts
    # Along the ground in one smooth motion; the foothold may still be shifted meanwhile.
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
    place[2] += centroid.centre[2]
    rate[2] += centroid.velocity[2]


@subroutine
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


@subroutine
def flight_torques(robot, leap, body, centroid, leg, measured, torques):
    """Torques of a leg in the air."""
    place, rate = np.empty(3), np.empty(3)
    t = measured.time - leap.began
    if leap.phase == LANDING:
        t += leap.lasts[FLIGHT]
    flying_foot(leap, centroid, leg, t, place, rate)
    keep_clear(robot, body, leg, place)
    target = FootTarget(place, rate, leap.stiffness, leap.joint_damping)
    track_foot(robot, body, leg, target, measured, torques)
