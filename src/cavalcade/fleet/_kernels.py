"""The ideal fleet's inner loop, compiled."""

from __future__ import annotations

from numba import njit

from cavalcade.robots.motion import advance


@njit(cache=True)
def advance_team(poses, velocities, commands, limits, dt, steps):
    """Move every robot by `steps` steps of `dt` seconds under held commands, in place.

    Args:
        poses: `(N, 3)` x, y, yaw in the map frame; changed.
        velocities: `(N, 3)` vx, vy, wz in the map frame; changed.
        commands: `(N, 3)` body-frame velocities.
        limits: `(N, 5)` as `cavalcade.robots.motion.limits_of` gives them.
    """
    for robot in range(poses.shape[0]):
        x, y, yaw = poses[robot, 0], poses[robot, 1], poses[robot, 2]
        vx, vy, wz = velocities[robot, 0], velocities[robot, 1], velocities[robot, 2]
        cx, cy, cw = commands[robot, 0], commands[robot, 1], commands[robot, 2]
        for _ in range(steps):
            x, y, yaw, vx, vy, wz = advance(x, y, yaw, vx, vy, wz, cx, cy, cw, dt, limits[robot])
        poses[robot, 0], poses[robot, 1], poses[robot, 2] = x, y, yaw
        velocities[robot, 0], velocities[robot, 1], velocities[robot, 2] = vx, vy, wz
