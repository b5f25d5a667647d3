"""Torques of a leg's joints for what it is to do, compiled: push, move a foot, fold, go limp.

`robot` and `body` are rows of `ROBOT` and `BODY`, `measured` is what is `Measured` of one robot;
of `torques (12,)`, N m, those of the leg are overwritten.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import subroutine
from cavalcade.locomotion._kinematics import (
    leg_forward,
    leg_inverse,
    leg_weight,
    solve3,
    turned_back,
)

FASTEST = 25.0  # joints of a leg in the air are asked for at most that speed, rad/s
SLOW = 0.2  # around that speed dry friction takes over its full torque, rad/s

FOLD_STIFFNESS, FOLD_DAMPING = 120.0, 3.0
"""Of joints that fold or unfold legs, N m/rad and N m s/rad."""

LIMP = 1.0  # damping of joints of a robot that lies, N m s/rad


@subroutine
def stance_torques(robot, body, leg, force, measured, torques):
    """Let the ground push a foot with `force` `(3,)`, world frame, N.

    The joints also hold the leg's own weight and make up for their damping and friction.
    """
    back, weight = np.empty(3), np.empty(3)
    turned_back(body.matrix, force, back)
    leg_weight(robot, leg, measured.qpos[7 + 3 * leg : 10 + 3 * leg], body.matrix[2], weight)
    jacobian = body.jacobian[leg]
    for j in range(3):
        joint = 3 * leg + j
        torque = weight[j]
        for a in range(3):
            torque -= jacobian[a, j] * back[a]
        rate = measured.qvel[6 + joint]
        torque += robot.damping[joint] * rate + robot.friction[joint] * math.tanh(rate / SLOW)
        torques[joint] = torque


@subroutine
def track_foot(robot, body, leg, target, measured, torques):
    """Bring a foot to a `FootTarget` by PD control of joint angles and rates."""
    arm, rate = np.empty(3), np.empty(3)
    for a in range(3):
        arm[a] = target.place[a] - body.trunk[a]
        # What is left for the joints to do: the trunk moves, too.
        rate[a] = target.velocity[a] - body.carried[leg, a]
    wanted, back = np.empty(3), np.empty(3)
    turned_back(body.matrix, arm, wanted)
    turned_back(body.matrix, rate, back)
    joints, speeds, jacobian = np.empty(3), np.empty(3), np.empty((3, 3))
    leg_inverse(robot, leg, wanted, joints)
    leg_forward(robot, leg, joints, wanted, jacobian)
    solve3(jacobian, back, speeds)
    for j in range(3):
        joint = 3 * leg + j
        speed = min(max(speeds[j], -FASTEST), FASTEST)
        torques[joint] = target.stiffness * (
            joints[j] - measured.qpos[7 + joint]
        ) + target.damping * (speed - measured.qvel[6 + joint])


@subroutine
def add_leg_weight(robot, body, leg, measured, torques):
    """Add to a leg's torques those that hold its own weight."""
    weight = np.empty(3)
    leg_weight(robot, leg, measured.qpos[7 + 3 * leg : 10 + 3 * leg], body.matrix[2], weight)
    for j in range(3):
        torques[3 * leg + j] += weight[j]


@subroutine
def track_posture(start, goal, share, measured, torques):
    """Bring all joints `share` (0 to 1) of the way from angles `start` to `goal`, `(12,)`, rad."""
    for j in range(12):
        angle = start[j] + share * (goal[j] - start[j])
        torques[j] = FOLD_STIFFNESS * (angle - measured.qpos[7 + j])
        torques[j] -= FOLD_DAMPING * measured.qvel[6 + j]


@subroutine
def go_limp(measured, torques):
    """Only brake all joints."""
    for j in range(12):
        torques[j] = -LIMP * measured.qvel[6 + j]


@subroutine
def limit_torques(robot, torques):
    """Keep torques `(12,)` within the motors' limits."""
    for j in range(12):
        torques[j] = min(max(torques[j], -robot.torque[j]), robot.torque[j])
