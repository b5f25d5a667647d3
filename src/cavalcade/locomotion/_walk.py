"""One step of one robot that walks, stands, rises or lies down, compiled: its joint torques.

Below, `robot, gait, state, body` are rows of `ROBOT`, `GAIT`, `STATE` and `BODY`, of which the last
two change; `footing` is a `Footing`, and `measured` what is `Measured` of the robot.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import subroutine
from cavalcade.locomotion._horizon import (
    approach,
    commanded_velocity,
    solve_forces,
    swing_share,
    walk_problem,
)
from cavalcade.locomotion._joints import add_leg_weight, stance_torques, track_foot, track_posture
from cavalcade.locomotion._kinematics import leg_inverse, wrapped
from cavalcade.locomotion._swing import choose_foothold, swing_point
from cavalcade.locomotion.records import LYING, SINKING, STANDING, TROTTING, FootTarget

CALM = 0.15  # pushed to more than that a robot begins to step, m/s; three times that in rad/s
FIXED = 0.8  # from this share of a swing on, its foothold stays
LOST = 0.1  # a foot that misses the ground after its swing goes down by at most so much, m
SINK = 0.4  # speed at which such a foot goes down, m/s
EARLY = 0.6  # from this share of a swing on, a foot that touches stands

REST = 1.2
"""A robot that is to stand for so many cycles lifts no foot any more: all are below the hips."""

SENSING = 0.1  # time constant of the ground's estimated height and slope, s
STEEPEST = 0.6  # no slope is taken for steeper, m/m
POSTURE = 1.0  # rising and sinking take that long, s
FOLDED = (0.0, 1.25, -2.7)  # joints of a leg of a robot that lies, rad


@subroutine
def step_walk(own, footing, passed, measured, torques):
    """Torques `(12,)`, overwritten, N m, for a robot that trots or stands.

    `own` is its row of `TEAM`; `passed` the time since its last step, s.
    """
    robot, gait, state, body = own.robot, own.gait, own.state, own.body
    # Follow the command: reference, gait and ground first, then forces, then torques.
    follow(gait, state, body, passed)
    changed = step_gait(robot, gait, state, body, measured.feet, footing)
    # On a slope the ground below changes with every step; the estimate would lag behind.
    state.ground += passed * (state.slope[0] * body.velocity[0] + state.slope[1] * body.velocity[1])
    sense_ground(robot, state, body, min(passed / SENSING, 1.0))
    if changed or state.time - state.solved >= gait.interval - 1e-9:
        solve_forces(walk_problem(robot, gait, body, state), state)
        state.solved = state.time
    for leg in range(4):
        if state.contact[leg] == 1:
            stance_torques(robot, body, leg, state.forces[leg], measured, torques)
        else:
            swing_torques(robot, gait, state, body, leg, measured, torques)


@subroutine
def stand(state, body):
    """Begin to stand where the robot is, on all feet."""
    state.mode = STANDING
    state.began = state.time
    state.place[0], state.place[1] = body.centre[0], body.centre[1]
    state.yaw = body.angles[2]
    for leg in range(4):
        state.swinging[leg] = 0
        state.contact[leg] = 1
        for a in range(3):
            state.stood[leg, a] = body.foot[leg, a]
    state.solved = -math.inf


@subroutine
def follow(gait, state, body, passed):
    """Let the followed velocity approach the commanded one, and carry the reference along.

    The reference stays within a leash of the robot: one that is held back does not run after it.
    """
    vx, vy, wz = commanded_velocity(gait, state)
    approach(gait, state.velocity, vx, vy, wz, passed)
    if vx != 0.0 or vy != 0.0 or wz != 0.0 or disturbed(state, body):
        state.idle = state.time
    yaw = state.yaw + 0.5 * state.velocity[2] * passed
    c, s = math.cos(yaw), math.sin(yaw)
    x = state.place[0] + (c * state.velocity[0] - s * state.velocity[1]) * passed
    y = state.place[1] + (s * state.velocity[0] + c * state.velocity[1]) * passed
    dx, dy = x - body.centre[0], y - body.centre[1]
    length = math.hypot(dx, dy)
    share = 1.0 if length <= gait.leash else gait.leash / length
    state.place[0] = body.centre[0] + share * dx
    state.place[1] = body.centre[1] + share * dy
    off = wrapped(state.yaw + state.velocity[2] * passed - body.angles[2])
    measured = state.yaw + wrapped(body.angles[2] - state.yaw)
    state.yaw = measured + min(max(off, -gait.turn_leash), gait.turn_leash)


@subroutine
def disturbed(state, body):
    """Whether a robot that wants to stand must step not to fall."""
    speed = math.hypot(body.velocity[0], body.velocity[1])
    own = math.hypot(state.velocity[0], state.velocity[1])
    return speed - own > CALM or abs(body.spin[2] - state.velocity[2]) > 3.0 * CALM


@subroutine
def step_gait(robot, gait, state, body, feet, footing):
    """Set which feet swing and which stand by `feet` `(4,)`, N; whether that changed."""
    if state.mode == STANDING:
        if state.idle < state.time:
            return False
        state.mode = TROTTING
        state.began = state.time
    clock = state.time - state.began
    stopping = state.time - state.idle > REST * gait.period
    standing = 0
    for leg in range(4):
        standing += state.contact[leg] * (1 - state.swinging[leg])
    if stopping and standing == 4:
        stand(state, body)
        return True
    changed = False
    for leg in range(4):
        # By the gait's clock a swing begins or ends.
        share = swing_share(gait, clock, leg)
        if share < 1.0 and state.swinging[leg] == 0 and not stopping:
            changed = True
            state.swinging[leg], state.contact[leg] = 1, 0
            for a in range(3):
                state.lifted[leg, a] = body.foot[leg, a]
        elif share >= 1.0 and state.swinging[leg] == 1:
            changed = True
            state.swinging[leg] = 0
            state.late[leg] = state.time
        # By its force a foot has met the ground: after its swing, or early in its last part.
        touches = feet[leg] > gait.touch
        if state.contact[leg] == 0 and touches and (state.swinging[leg] == 0 or share > EARLY):
            changed = True
            state.contact[leg] = 1
            for a in range(3):
                state.stood[leg, a] = body.foot[leg, a]
        if state.swinging[leg] == 1 and state.contact[leg] == 0 and share < FIXED:
            left = (1.0 - share) * (1.0 - gait.duty) * gait.period
            choose_foothold(robot, gait, body, state, leg, left, footing)
    return changed


@subroutine
def sense_ground(robot, state, body, share):
    """Let height and slope of the ground come nearer, by a `share`, to where feet stood last.

    That is the plane with the least squares of vertical distances from the four places.
    """
    mx = my = mz = 0.0
    for leg in range(4):
        mx += 0.25 * state.stood[leg, 0]
        my += 0.25 * state.stood[leg, 1]
        mz += 0.25 * state.stood[leg, 2]
    xx = xy = yy = xz = yz = 0.0
    for leg in range(4):
        dx, dy = state.stood[leg, 0] - mx, state.stood[leg, 1] - my
        dz = state.stood[leg, 2] - mz
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
        xz += dx * dz
        yz += dy * dz
    determinant = xx * yy - xy * xy
    if determinant < 1e-5:
        return  # m⁴: feet nearly in a line say nothing of the slope across
    slope_x = min(max((yy * xz - xy * yz) / determinant, -STEEPEST), STEEPEST)
    slope_y = min(max((xx * yz - xy * xz) / determinant, -STEEPEST), STEEPEST)
    height = mz - robot.foot_radius
    height += slope_x * (body.centre[0] - mx) + slope_y * (body.centre[1] - my)
    state.slope[0] += share * (slope_x - state.slope[0])
    state.slope[1] += share * (slope_y - state.slope[1])
    state.ground += share * (height - state.ground)


@subroutine
def swing_torques(robot, gait, state, body, leg, measured, torques):
    """Torques of a leg in the air: along its swing, then down until it meets the ground."""
    place, velocity = np.empty(3), np.empty(3)
    lasts = (1.0 - gait.duty) * gait.period
    swinging = state.swinging[leg] == 1
    share = swing_share(gait, state.time - state.began, leg) if swinging else 1.0
    swing_point(
        state.lifted[leg], state.landing[leg], state.apex[leg], share, lasts, place, velocity
    )
    if not swinging:
        down = min(SINK * (state.time - state.late[leg]), LOST)
        place[2] -= down
        velocity[2] = -SINK if down < LOST else 0.0
    target = FootTarget(place, velocity, gait.stiffness, gait.joint_damping)
    track_foot(robot, body, leg, target, measured, torques)
    add_leg_weight(robot, body, leg, measured, torques)


@subroutine
def step_posture(robot, gait, state, body, measured, torques):
    """Torques `(12,)`, overwritten, N m, that fold or unfold the legs under a robot.

    It lies down or gets up; at the end of that it lies or stands.
    """
    share = min((state.time - state.began) / POSTURE, 1.0)
    share = share * share * (3.0 - 2.0 * share)
    place, goal = np.empty(3), np.empty(12)
    for leg in range(4):
        place[0] = robot.hip[leg, 0]
        place[1] = robot.hip[leg, 1] + robot.side[leg]
        place[2] = robot.foot_radius - gait.height
        leg_inverse(robot, leg, place, goal[3 * leg : 3 * leg + 3])
        if state.mode == SINKING:
            for j in range(3):
                goal[3 * leg + j] = FOLDED[j]
    track_posture(state.fold, goal, share, measured, torques)
    if state.time - state.began >= POSTURE:
        if state.mode == SINKING:
            state.mode = LYING
        else:
            stand(state, body)
            sense_ground(robot, state, body, 1.0)
