"""The state of a body and its feet as the controller needs it, compiled. SI, world z up."""

from __future__ import annotations

import numpy as np
from numba import njit

from cavalcade.locomotion._kinematics import angles, cross, leg_forward, rotation, turned

BODY = np.dtype(
    [
        ("matrix", np.float64, (3, 3)),  # trunk to world
        ("angles", np.float64, (3,)),  # roll, pitch, yaw, rad
        ("trunk", np.float64, (3,)),  # origin of the trunk frame, m
        ("centre", np.float64, (3,)),  # of mass as if the robot stood, world, m
        ("velocity", np.float64, (3,)),  # of that, world, m/s
        ("spin", np.float64, (3,)),  # angular velocity, world, rad/s
        ("foot", np.float64, (4, 3)),  # feet's centres, world, m
        ("carried", np.float64, (4, 3)),  # feet's velocities if joints stood still, world, m/s
        ("jacobian", np.float64, (4, 3, 3)),  # of the feet by the joints, trunk frame
    ],
    align=True,
)
"""A body as measured now."""


@njit(cache=True)
def look(robot, qpos, qvel, body):
    """Fill `body`, a row of `BODY`, from MuJoCo's coordinates of one robot.

    Args:
        robot: A row of `ROBOT`.
        qpos: `(19,)` position, quaternion w, x, y, z, joints.
        qvel: `(18,)` velocity (world), angular velocity (body), joint rates.
        body: Overwritten.
    """
    matrix, spin = body.matrix, body.spin
    rotation(qpos[3:7], matrix)
    roll, pitch, yaw = angles(matrix)
    body.angles[0], body.angles[1], body.angles[2] = roll, pitch, yaw
    turned(matrix, qvel[3:6], spin)
    arm, moved, place = np.empty(3), np.empty(3), np.empty(3)
    turned(matrix, robot.centre, arm)
    cross(spin, arm, moved)
    for a in range(3):
        body.trunk[a] = qpos[a]
        body.centre[a] = qpos[a] + arm[a]
        body.velocity[a] = qvel[a] + moved[a]
    for leg in range(4):
        leg_forward(robot, leg, qpos[7 + 3 * leg : 10 + 3 * leg], place, body.jacobian[leg])
        turned(matrix, place, arm)
        cross(spin, arm, moved)
        for a in range(3):
            body.foot[leg, a] = qpos[a] + arm[a]
            body.carried[leg, a] = qvel[a] + moved[a]
