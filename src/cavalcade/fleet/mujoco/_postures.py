"""How trunks stand: planar poses and motion, and whether robots have fallen, compiled."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel, subroutine


@subroutine
def angles_of(w, x, y, z):
    """Roll, pitch and yaw in rad of a unit quaternion: turned by yaw, then pitch, then roll."""
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(min(max(2.0 * (w * y - x * z), -1.0), 1.0))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw


@kernel
def planar_poses(qpos):
    """`(N, 3)` x, y in m and yaw in [-pi, pi] of states `(N, 19)` as MuJoCo has them."""
    poses = np.empty((qpos.shape[0], 3))
    for k in range(qpos.shape[0]):
        _, _, yaw = angles_of(qpos[k, 3], qpos[k, 4], qpos[k, 5], qpos[k, 6])
        poses[k, 0], poses[k, 1], poses[k, 2] = qpos[k, 0], qpos[k, 1], yaw
    return poses


@kernel
def planar_velocities(qpos, qvel):
    """`(N, 3)` m/s, m/s and rad/s about the vertical, map frame, of states as MuJoCo has them."""
    velocities = np.empty((qpos.shape[0], 3))
    for k in range(qpos.shape[0]):
        w, x, y, z = qpos[k, 3], qpos[k, 4], qpos[k, 5], qpos[k, 6]
        velocities[k, 0], velocities[k, 1] = qvel[k, 0], qvel[k, 1]
        velocities[k, 2] = (
            2.0 * (x * z - w * y) * qvel[k, 3]
            + 2.0 * (y * z + w * x) * qvel[k, 4]
            + (1.0 - 2.0 * (x * x + y * y)) * qvel[k, 5]
        )
    return velocities


@kernel
def find_falls(qpos, ground, lowest, most_tilt):
    """`(N,)` 0 for robots that stand, 1 for those that lean too much, 2 for those that are too low.

    `lowest` `(N,)` are the least heights of trunks over the `ground` `(N,)` below them, m;
    `most_tilt` is the largest magnitude of roll and pitch, rad.
    """
    falls = np.zeros(qpos.shape[0], np.int64)
    for k in range(qpos.shape[0]):
        roll, pitch, _ = angles_of(qpos[k, 3], qpos[k, 4], qpos[k, 5], qpos[k, 6])
        if max(abs(roll), abs(pitch)) > most_tilt:
            falls[k] = 1
        elif qpos[k, 2] - ground[k] < lowest[k]:
            falls[k] = 2
    return falls
