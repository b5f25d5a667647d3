"""How a trunk stands: its planar pose and motion, and whether the robot has fallen."""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array

MOST_TILT = 1.0
"""A robot whose trunk has rolled or pitched by more has fallen, rad."""

LEAST_HEIGHT = 0.4
"""A robot whose trunk is lower has fallen; of its standing height."""


def planar_poses(qpos: Array) -> Array:
    """`(N, 3)` x, y in m and yaw in [-pi, pi] of states `(N, 7 or more)` as MuJoCo has them."""
    _, _, yaw = roll_pitch_yaw(qpos[:, 3:7])
    return np.column_stack((qpos[:, :2], yaw))


def planar_velocities(qpos: Array, qvel: Array) -> Array:
    """`(N, 3)` m/s, m/s and rad/s about the vertical, map frame."""
    w, x, y, z = qpos[:, 3:7].T
    vertical = np.stack(
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)), axis=1
    )
    return np.column_stack((qvel[:, :2], (vertical * qvel[:, 3:6]).sum(axis=1)))


def roll_pitch_yaw(quaternions: Array) -> tuple[Array, Array, Array]:
    """Angles `(N,)` in rad of unit quaternions `(N, 4)` w, x, y, z: yaw, then pitch, then roll."""
    w, x, y, z = quaternions.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw


def fallen(qpos: Array, ground: Array, standing: Array) -> list[str | None]:
    """Why each robot counts as fallen: `tilt`, `height` or None.

    Args:
        qpos: `(N, 7 or more)` as MuJoCo has them.
        ground: `(N,)` heights below the trunks, m.
        standing: `(N,)` heights of standing trunks over the ground, m.
    """
    roll, pitch, _ = roll_pitch_yaw(qpos[:, 3:7])
    tilted = np.maximum(np.abs(roll), np.abs(pitch)) > MOST_TILT
    low = qpos[:, 2] - ground < LEAST_HEIGHT * standing
    return ["tilt" if tilted[k] else "height" if low[k] else None for k in range(len(qpos))]
