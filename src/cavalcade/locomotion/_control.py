"""One step of the controller for one robot, compiled: from measured state to joint torques."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.locomotion._horizon import approach, solve_walk, swing_share, wish
from cavalcade.locomotion._kinematics import (
    leg_forward,
    leg_inverse,
    leg_weight,
    solve3,
    turned_back,
    wrapped,
)
from cavalcade.locomotion._legs import look
from cavalcade.locomotion._swing import choose_foothold, swing_point
from cavalcade.locomotion.records import (
    FALLEN,
    LYING,
    RISING,
    SINKING,
    STANDING,
    TROTTING,
)

FALL = 1.0
"""A trunk that leans by more has fallen, rad."""

STILL = 0.02
"""Commands below are none, m/s; twice that in rad/s."""

CALM = 0.15
"""Pushed to more than that a robot begins to step, m/s; three times that in rad/s."""

FIXED = 0.8
"""From this share of a swing on, its foothold stays."""

LOST = 0.1
"""A foot that misses the ground goes down so far, m."""

SINK = 0.4
"""With that speed, m/s."""

POSTURE = 1.0
"""Rising and sinking take that long, s."""

FOLDED = (0.0, 1.25, -2.7)
"""Joints of a leg of a robot that lies, rad."""


@njit(cache=True)
def control(robot, gait, state, body, ground, frame, time, qpos, qvel, feet, torques):
    """Torques for one robot.

    Args:
        robot, gait, state, body: Rows of `ROBOT`, `GAIT`, `STATE`, `BODY`; the last two change.
        ground, frame: `Ground`, and the pose of its grid in the world `(3,)`.
        time: Now, s.
        qpos, qvel: `(19,)`, `(18,)` as MuJoCo has them.
        feet: `(4,)` normal forces on the feet, N.
        torques: `(12,)`, overwritten, N m.
    """
    passed = time - state.time
    state.time = time
    look(robot, qpos, qvel, body)
    if max(abs(body.angles[0]), abs(body.angles[1])) > FALL:
        state.mode = FALLEN
    if state.mode == FALLEN or state.mode == LYING:
        for j in range(12):
            torques[j] = -1.0 * qvel[6 + j]
        return
    if state.mode == RISING or state.mode == SINKING:
        posture(robot, gait, state, body, qpos, qvel, torques)
        if time - state.began >= POSTURE:
            if state.mode == SINKING:
                state.mode = LYING
            else:
                stand(robot, state, body)
        return
    follow(gait, state, body, passed)
    changed = step_gait(robot, gait, state, body, feet, ground, frame)
    sense_ground(robot, state, body)
    if changed or time - state.solved >= gait.interval - 1e-9:
        solve_walk(robot, gait, body, state)
        state.solved = time
    for leg in range(4):
        if state.contact[leg] == 1:
            push(robot, state, body, leg, qpos, qvel, torques)
        else:
            swing(robot, gait, state, body, leg, qpos, qvel, torques)
    limit(robot, torques)


@njit(cache=True)
def limit(robot, torques):
    """Keep torques within the motors' limits."""
    for j in range(12):
        torques[j] = min(max(torques[j], -robot.torque[j]), robot.torque[j])


@njit(cache=True)
def stand(robot, state, body):
    """Begin to stand where the robot is."""
    state.mode = STANDING
    state.began = state.time
    state.place[0], state.place[1] = body.centre[0], body.centre[1]
    state.yaw = body.angles[2]
    for leg in range(4):
        state.swinging[leg] = 0
        state.contact[leg] = 1
        for a in range(3):
            state.stood[leg, a] = body.foot[leg, a]
    state.solved = -1.0


@njit(cache=True)
def follow(gait, state, body, passed):
    """Let the followed velocity approach the commanded one, and carry the reference along."""
    vx, vy, wz = wish(gait, state)
    approach(gait, state.velocity, vx, vy, wz, passed)
    if math.hypot(vx, vy) > STILL or abs(wz) > 2.0 * STILL or disturbed(state, body):
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


@njit(cache=True)
def disturbed(state, body):
    """Whether a robot that wants to stand must step not to fall."""
    speed = math.hypot(body.velocity[0], body.velocity[1])
    own = math.hypot(state.velocity[0], state.velocity[1])
    return speed - own > CALM or abs(body.spin[2] - state.velocity[2]) > 3.0 * CALM


@njit(cache=True)
def step_gait(robot, gait, state, body, feet, ground, frame):
    """Set which feet swing and which stand; whether that changed."""
    if state.mode == STANDING:
        if state.idle < state.time:
            return False
        state.mode = TROTTING
        state.began = state.time
    clock = state.time - state.began
    # Without a wish for a whole cycle the feet are below the hips again; no foot lifts then.
    stopping = state.time - state.idle > 1.2 * gait.period
    if stopping and all_stand(state):
        stand(robot, state, body)
        return True
    changed = False
    for leg in range(4):
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
        touches = feet[leg] > gait.touch
        if state.contact[leg] == 0 and touches and (state.swinging[leg] == 0 or share > 0.6):
            changed = True
            state.contact[leg] = 1
            for a in range(3):
                state.stood[leg, a] = body.foot[leg, a]
        if state.swinging[leg] == 1 and state.contact[leg] == 0 and share < FIXED:
            left = (1.0 - share) * (1.0 - gait.duty) * gait.period
            choose_foothold(robot, gait, body, state, leg, left, ground, frame)
    return changed


@njit(cache=True)
def all_stand(state):
    """Whether no foot is in the air."""
    standing = 0
    for leg in range(4):
        if state.contact[leg] == 1 and state.swinging[leg] == 0:
            standing += 1
    return standing == 4


@njit(cache=True)
def sense_ground(robot, state, body):
    """Height and slope of the ground from where the feet stood last."""
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
        return
    slope_x = min(max((yy * xz - xy * yz) / determinant, -0.6), 0.6)
    slope_y = min(max((xx * yz - xy * xz) / determinant, -0.6), 0.6)
    height = mz - robot.foot_radius
    height += slope_x * (body.centre[0] - mx) + slope_y * (body.centre[1] - my)
    rate = 0.02
    state.slope[0] += rate * (slope_x - state.slope[0])
    state.slope[1] += rate * (slope_y - state.slope[1])
    state.ground += rate * (height - state.ground)


@njit(cache=True)
def push(robot, state, body, leg, qpos, qvel, torques):
    """Torques of a standing leg: the ground's force, the leg's own weight, the joints' losses."""
    force, up, weight = np.empty(3), np.empty(3), np.empty(3)
    turned_back(body.matrix, state.forces[leg], force)
    for a in range(3):
        up[a] = body.matrix[2, a]
    leg_weight(robot, leg, qpos[7:], up, weight)
    jacobian = body.jacobian[leg]
    for j in range(3):
        joint = 3 * leg + j
        torque = weight[j]
        for a in range(3):
            torque -= jacobian[a, j] * force[a]
        rate = qvel[6 + joint]
        torque += robot.damping[joint] * rate + robot.friction[joint] * math.tanh(rate / 0.2)
        torques[joint] = torque


@njit(cache=True)
def swing(robot, gait, state, body, leg, qpos, qvel, torques):
    """Torques of a swinging leg: joint angles and rates that bring the foot along its way."""
    place, velocity = np.empty(3), np.empty(3)
    lasts = (1.0 - gait.duty) * gait.period
    clock = state.time - state.began
    share = swing_share(gait, clock, leg) if state.swinging[leg] == 1 else 1.0
    swing_point(
        state.lifted[leg], state.landing[leg], state.apex[leg], share, lasts, place, velocity
    )
    if state.swinging[leg] == 0:
        down = min(SINK * (state.time - state.late[leg]), LOST)
        place[2] -= down
        velocity[2] = -SINK if down < LOST else 0.0
    arm, wanted, rate = np.empty(3), np.empty(3), np.empty(3)
    for a in range(3):
        arm[a] = place[a] - body.trunk[a]
        # Against the trunk as it moves: its own motion at the foot, without the joints'.
        joint_part = 0.0
        for j in range(3):
            part = 0.0
            for b in range(3):
                part += body.matrix[a, b] * body.jacobian[leg, b, j]
            joint_part += part * qvel[6 + 3 * leg + j]
        rate[a] = velocity[a] - (body.foot_velocity[leg, a] - joint_part)
    turned_back(body.matrix, arm, wanted)
    hold(robot, gait, leg, body, wanted, rate, qpos, qvel, torques)


@njit(cache=True)
def hold(robot, gait, leg, body, wanted, rate, qpos, qvel, torques):
    """Torques that bring a foot to a place of the trunk frame with a velocity (world frame)."""
    joints, back, speeds, up, weight = (
        np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3),
    )  # fmt: skip
    jacobian, reached = np.empty((3, 3)), np.empty(3)
    leg_inverse(robot, leg, wanted, joints)
    turned_back(body.matrix, rate, back)
    aimed = np.empty(12)
    for j in range(3):
        aimed[3 * leg + j] = joints[j]
    leg_forward(robot, leg, aimed, reached, jacobian)
    solve3(jacobian, back, speeds)
    for a in range(3):
        up[a] = body.matrix[2, a]
    leg_weight(robot, leg, qpos[7:], up, weight)
    for j in range(3):
        joint = 3 * leg + j
        speed = min(max(speeds[j], -25.0), 25.0)
        torques[joint] = (
            gait.stiffness * (joints[j] - qpos[7 + joint])
            + gait.joint_damping * (speed - qvel[6 + joint])
            + weight[j]
        )


@njit(cache=True)
def posture(robot, gait, state, body, qpos, qvel, torques):
    """Torques that fold or unfold the legs under a robot that lies down or gets up."""
    share = min((state.time - state.began) / POSTURE, 1.0)
    share = share * share * (3.0 - 2.0 * share)
    place, joints = np.empty(3), np.empty(3)
    for leg in range(4):
        place[0] = robot.hip[leg, 0]
        place[1] = robot.hip[leg, 1] + robot.side[leg]
        place[2] = robot.foot_radius - gait.height
        leg_inverse(robot, leg, place, joints)
        for j in range(3):
            joint = 3 * leg + j
            goal = joints[j] if state.mode == RISING else FOLDED[j]
            angle = state.fold[joint] + share * (goal - state.fold[joint])
            torques[joint] = 120.0 * (angle - qpos[7 + joint]) - 3.0 * qvel[6 + joint]
    limit(robot, torques)
