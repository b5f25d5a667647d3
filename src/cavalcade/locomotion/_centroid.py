"""Where the mass of a robot really is and how it moves, its legs' motion included, compiled."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import subroutine
from cavalcade.locomotion._kinematics import adjugate_times, cross, turned
from cavalcade.locomotion.records import Centroid


@subroutine
def measure_centroid(robot, measured, body):
    """The `Centroid` of one robot as `Measured`, of which `body` is the row of `BODY`.

    The angular velocity is that of a body with the standing robot's inertia and the robot's
    angular momentum, in which links count as points where their joints move them.
    """
    qpos, qvel = measured.qpos, measured.qvel
    place, rate = np.empty((12, 3)), np.empty((12, 3))
    mean, speed = np.empty(3), np.zeros(3)
    own = robot.trunk_mass
    for a in range(3):
        mean[a] = own * robot.trunk_centre[a]
    # Sums over trunk and links of places and velocities by mass, trunk frame.
    for leg in range(4):
        _links(robot, leg, qpos[7:], qvel[6:], place, rate)
        for link in range(3):
            mass = robot.link_mass[leg, link]
            for a in range(3):
                mean[a] += mass * place[3 * leg + link, a]
                speed[a] += mass * rate[3 * leg + link, a]
    for a in range(3):
        mean[a] /= robot.mass
        speed[a] /= robot.mass
    # Momentum about the centre of mass by the joints' motion alone, trunk frame.
    momentum, arm, product = np.zeros(3), np.empty(3), np.empty(3)
    for leg in range(4):
        for link in range(3):
            k = 3 * leg + link
            for a in range(3):
                arm[a] = place[k, a] - mean[a]
            cross(arm, rate[k], product)
            for a in range(3):
                momentum[a] += robot.link_mass[leg, link] * product[a]
    extra = np.empty(3)
    determinant = adjugate_times(robot.inertia, momentum, extra)
    for a in range(3):
        extra[a] /= determinant
    # To the world: the trunk carries the centre of mass along and turns it, the joints move it.
    centre, velocity, spin = np.empty(3), np.empty(3), np.empty(3)
    turned(body.matrix, mean, centre)
    cross(body.spin, centre, velocity)
    turned(body.matrix, speed, arm)
    turned(body.matrix, extra, product)
    for a in range(3):
        centre[a] += qpos[a]
        velocity[a] += qvel[a] + arm[a]
        spin[a] = body.spin[a] + product[a]
    return Centroid(centre, velocity, spin)


@subroutine
def _links(robot, leg, joints, rates, place, rate):
    """Centres of a leg's links `(3 leg + link)` in the trunk frame, and how joints move them."""
    q0, q1, q2 = joints[3 * leg], joints[3 * leg + 1], joints[3 * leg + 2]
    w0, w1, w2 = rates[3 * leg], rates[3 * leg + 1], rates[3 * leg + 2]
    s0, c0, s1, c1 = math.sin(q0), math.cos(q0), math.sin(q1), math.cos(q1)
    s12, c12 = math.sin(q1 + q2), math.cos(q1 + q2)
    for link in range(3):
        link_centre = robot.link_centre[leg, link]
        x, y, z = link_centre[0], link_centre[1], link_centre[2]
        # In the plane that turns with the hip: u ahead, w up, and their rates by thigh and calf.
        u, w, du, dw = x, z, 0.0, 0.0
        if link == 1:
            u, w = c1 * x + s1 * z, -s1 * x + c1 * z
            du, dw = w1 * w, -w1 * u
        elif link == 2:
            u, w = c12 * x + s12 * z, -s12 * x + c12 * z
            du, dw = (w1 + w2) * w, -(w1 + w2) * u
            u, w = u - robot.thigh * s1, w - robot.thigh * c1
            du, dw = du - w1 * robot.thigh * c1, dw + w1 * robot.thigh * s1
        # The hip's joint turns that plane about the trunk's x.
        v = y + (robot.side[leg] if link > 0 else 0.0)
        k = 3 * leg + link
        place[k, 0] = robot.hip[leg, 0] + u
        place[k, 1] = robot.hip[leg, 1] + c0 * v - s0 * w
        place[k, 2] = robot.hip[leg, 2] + s0 * v + c0 * w
        rate[k, 0] = du
        rate[k, 1] = -w0 * (s0 * v + c0 * w) - s0 * dw
        rate[k, 2] = w0 * (c0 * v - s0 * w) + c0 * dw
