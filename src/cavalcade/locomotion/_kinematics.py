"""Where trunk and feet are, how joints move them, which torques hold a leg's weight, compiled.

One leg is a hip joint about x, a thigh joint about y beside it and a calf joint about y; thigh and
calf hang downwards at zero. Trunk frame (x ahead, y left, z up), m, rad; a leg's joints are hip,
thigh, calf. `robot` is a row of `ROBOT`.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.geometry import GRAVITY
from cavalcade.kernels import subroutine

SINGULAR = 2e-4  # a Jacobian with a smaller determinant is not inverted but damped, m³
STRETCHED = 0.999  # legs are stretched at most to this share of their length


@subroutine
def rotation(quaternion, out):
    """The matrix `(3, 3)` of a unit quaternion w, x, y, z: body to world."""
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    out[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[0, 1] = 2.0 * (x * y - w * z)
    out[0, 2] = 2.0 * (x * z + w * y)
    out[1, 0] = 2.0 * (x * y + w * z)
    out[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[1, 2] = 2.0 * (y * z - w * x)
    out[2, 0] = 2.0 * (x * z - w * y)
    out[2, 1] = 2.0 * (y * z + w * x)
    out[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@subroutine
def angles(matrix):
    """Roll, pitch and yaw of a rotation: first about x, last about z, rad."""
    pitch = math.asin(min(max(-matrix[2, 0], -1.0), 1.0))
    return math.atan2(matrix[2, 1], matrix[2, 2]), pitch, math.atan2(matrix[1, 0], matrix[0, 0])


@subroutine
def measure_body(robot, measured, body):
    """Fill `body`, a row of `BODY`, from what is `Measured` of one robot."""
    qpos, qvel = measured.qpos, measured.qvel
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


@subroutine
def leg_forward(robot, leg, joints, place, jacobian):
    """Set `place` `(3,)` to a foot's centre, `jacobian` to its derivatives by `joints` `(3,)`."""
    q0, q1, q2 = joints[0], joints[1], joints[2]
    s0, c0, s1, c1 = math.sin(q0), math.cos(q0), math.sin(q1), math.cos(q1)
    s12, c12 = math.sin(q1 + q2), math.cos(q1 + q2)
    side, thigh, calf = robot.side[leg], robot.thigh, robot.calf
    x = -thigh * s1 - calf * s12
    z = -thigh * c1 - calf * c12
    place[0] = robot.hip[leg, 0] + x
    place[1] = robot.hip[leg, 1] + side * c0 - z * s0
    place[2] = robot.hip[leg, 2] + side * s0 + z * c0
    jacobian[0, 0] = 0.0
    jacobian[1, 0] = -side * s0 - z * c0
    jacobian[2, 0] = side * c0 - z * s0
    jacobian[0, 1], jacobian[1, 1], jacobian[2, 1] = z, x * s0, -x * c0
    jacobian[0, 2] = -calf * c12
    jacobian[1, 2] = -calf * s12 * s0
    jacobian[2, 2] = calf * s12 * c0


@subroutine
def leg_inverse(robot, leg, place, out):
    """Set `out` to the angles that bring a foot's centre to a place `(3,)`, knees backwards.

    Out of reach, the leg points there as long as it can be; angles stay within the joints' ranges.
    """
    x = place[0] - robot.hip[leg, 0]
    y = place[1] - robot.hip[leg, 1]
    z = place[2] - robot.hip[leg, 2]
    side, thigh, calf = robot.side[leg], robot.thigh, robot.calf
    # The hip turns the leg's plane; `down` is the foot's height in it, straight below the side.
    down = -math.sqrt(max(y * y + z * z - side * side, 1e-6))
    turn = math.atan2(z, y) - math.atan2(down, side)
    out[0] = wrapped(turn)
    # The knee by the law of cosines, then the thigh by the direction to the foot.
    length = min(max(x * x + down * down, (thigh - calf) ** 2), (STRETCHED * (thigh + calf)) ** 2)
    bend = (length - thigh * thigh - calf * calf) / (2.0 * thigh * calf)
    out[2] = -math.acos(min(max(bend, -1.0), 1.0))
    ahead, aside = thigh + calf * math.cos(out[2]), calf * math.sin(out[2])
    out[1] = math.atan2(-x, -down) - math.atan2(aside, ahead)
    for j in range(3):
        out[j] = min(max(out[j], robot.lowest[3 * leg + j]), robot.highest[3 * leg + j])


@subroutine
def leg_weight(robot, leg, joints, up, out):
    """Set `out` to the torques, N m, that hold the leg's links up at the angles `joints`.

    They are derivatives of the potential energy; `up` is the unit vector upwards, trunk frame.
    """
    q0, q1, q2 = joints[0], joints[1], joints[2]
    s0, c0, s1, c1 = math.sin(q0), math.cos(q0), math.sin(q1), math.cos(q1)
    s12, c12 = math.sin(q1 + q2), math.cos(q1 + q2)
    # Upwards in the frame that has turned with the hip.
    ux, uy, uz = up[0], c0 * up[1] + s0 * up[2], -s0 * up[1] + c0 * up[2]
    out[0] = out[1] = out[2] = 0.0
    for link in range(3):
        mass = robot.link_mass[leg, link] * GRAVITY
        link_centre = robot.link_centre[leg, link]
        x, y, z = link_centre[0], link_centre[1], link_centre[2]
        knee_x = knee_z = 0.0
        if link == 1:
            x, z = c1 * x + s1 * z, -s1 * x + c1 * z
        elif link == 2:
            knee_x, knee_z = c12 * x + s12 * z, -s12 * x + c12 * z
            x, z = knee_x - robot.thigh * s1, knee_z - robot.thigh * c1
        # Derivative of the height by the thigh's and the calf's angle, turning about y.
        if link > 0:
            out[1] += mass * (ux * z - uz * x)
        if link == 2:
            out[2] += mass * (ux * knee_z - uz * knee_x)
        reach = y + (robot.side[leg] if link > 0 else 0.0)
        out[0] += mass * (-uy * z + uz * reach)


@subroutine
def adjugate_times(matrix, right, out):
    """Set `out` to the adjugate of a `(3, 3)` matrix times a vector; returns the determinant.

    Their quotient is the solution of `matrix` `x` = `right` (Cramer's rule).
    """
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    g, h, i = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    x, y, z = right[0], right[1], right[2]
    out[0] = (e * i - f * h) * x + (c * h - b * i) * y + (b * f - c * e) * z
    out[1] = (f * g - d * i) * x + (a * i - c * g) * y + (c * d - a * f) * z
    out[2] = (d * h - e * g) * x + (b * g - a * h) * y + (a * e - b * d) * z
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


@subroutine
def solve3(matrix, right, out):
    """Solve `matrix` `out` = `right`, damped where the matrix is nearly singular."""
    determinant = adjugate_times(matrix, right, out)
    far = abs(determinant) > SINGULAR
    scale = 1.0 / determinant if far else determinant / (SINGULAR * SINGULAR)
    for k in range(3):
        out[k] *= scale


@subroutine
def cross(a, b, out):
    """Set `out` to the vector product a × b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@subroutine
def turned(matrix, vector, out):
    """Set `out` to `matrix` times `vector`, `(3,)`."""
    for i in range(3):
        out[i] = matrix[i, 0] * vector[0] + matrix[i, 1] * vector[1] + matrix[i, 2] * vector[2]


@subroutine
def turned_back(matrix, vector, out):
    """Set `out` to the transpose of `matrix` times `vector`, `(3,)`."""
    for i in range(3):
        out[i] = matrix[0, i] * vector[0] + matrix[1, i] * vector[1] + matrix[2, i] * vector[2]


@subroutine
def wrapped(angle):
    """Wrap an angle to [-π, π), rad."""
    return np.float64((angle + math.pi) % (2.0 * math.pi) - math.pi)
