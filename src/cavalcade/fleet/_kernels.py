"""The ideal fleet's inner loop, compiled."""

from __future__ import annotations

from numba import njit

from cavalcade.robots.motion import MotionLimits, advance


@njit(cache=True)
def advance_team(poses, velocities, commands, limits, dt, steps):
    """Move every robot by `steps` steps of `dt` seconds under held commands, in place.

    Args:
        poses: `(N, 3)` x, y, yaw in the map frame; changed.
        velocities: `(N, 3)` vx, vy, wz in the map frame; changed.
        commands: `(N, 3)` body-frame velocities.
        limits: `(N, 5)` a row of `cavalcade.robots.motion.MotionLimits` per robot.
        dt, steps: Length of each step, s, and their number.
    """
    for robot in range(poses.shape[0]):
        pose, velocity, row = poses[robot], velocities[robot], limits[robot]
        state = (pose[0], pose[1], pose[2], velocity[0], velocity[1], velocity[2])
        command = (commands[robot, 0], commands[robot, 1], commands[robot, 2])
        own = MotionLimits(row[0], row[1], row[2], row[3], row[4])
        for _ in range(steps):
            state = advance(state, command, dt, own)
        pose[0], pose[1], pose[2], velocity[0], velocity[1], velocity[2] = state
