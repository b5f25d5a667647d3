"""Perfect holonomic robots, with imperfections that can be switched on one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.fleet.radio import CommandDelay, LocalisationNoise, RadioFleet, start_poses
from cavalcade.geometry import Array, wrap_angle
from cavalcade.kernels import kernel
from cavalcade.robots.model import RobotModel
from cavalcade.robots.motion import MotionLimits, advance, limits_of

LONGEST_STEP = 0.01
"""Longest internal time step, s."""


class IdealFleet(RadioFleet):
    """Robots that follow body velocities within their limits (see `cavalcade.robots.motion`).

    Args:
        models: One model per robot.
        poses: `(N, 3)` start poses x, y, yaw in the map frame, m and rad; the robots stand.
        noise: Errors of the reported poses.
        delay: Delay and loss of messages.
        seed: Of the noise, the jitter and the losses.
        time: The clock at the start, s.

    Raises:
        InputError: The numbers of models and poses differ, or a pose is not finite.
    """

    def __init__(
        self,
        models: Sequence[RobotModel],
        poses: ArrayLike,
        *,
        noise: LocalisationNoise | None = None,
        delay: CommandDelay | None = None,
        seed: int = 0,
        time: float = 0.0,
    ) -> None:
        self._poses = start_poses(poses, len(models))
        self._velocities = np.zeros_like(self._poses)
        self._limits = np.array([limits_of(model) for model in models])
        super().__init__(self._poses, float(time), noise, delay, seed)

    def true_poses(self) -> Array:
        """`(N, 3)` true poses now, yaw in [-pi, pi)."""
        poses = self._poses.copy()
        poses[:, 2] = wrap_angle(poses[:, 2])
        return poses

    def true_velocities(self) -> Array:
        """`(N, 3)` true velocities now, map frame: m/s, m/s, rad/s."""
        return self._velocities.copy()

    def _move(self, start: float, dt: float) -> Array:
        steps = max(1, math.ceil(dt / LONGEST_STEP - 1e-9))
        # Commands that are on their way arrive between steps.
        moves = [1] * steps if self._messages else [steps]
        for number, together in enumerate(moves):
            self._deliver(start + number * dt / steps)
            advance_team(
                self._poses, self._velocities, self._commands, self._limits, dt / steps, together
            )
        return self._poses


@kernel
def advance_team(
    poses: Array, velocities: Array, commands: Array, limits: Array, dt: float, steps: int
) -> None:
    """Move every robot by `steps` steps of `dt` seconds under held commands, in place.

    Poses and velocities `(N, 3)` are in the map frame, commands in the bodies'; `limits` `(N, 5)`
    has a row of `cavalcade.robots.motion.MotionLimits` per robot.
    """
    for robot in range(poses.shape[0]):
        pose, velocity, row = poses[robot], velocities[robot], limits[robot]
        state = (pose[0], pose[1], pose[2], velocity[0], velocity[1], velocity[2])
        command = (commands[robot, 0], commands[robot, 1], commands[robot, 2])
        own = MotionLimits(row[0], row[1], row[2], row[3], row[4])
        for _ in range(steps):
            state = advance(state, command, dt, own)
        pose[0], pose[1], pose[2], velocity[0], velocity[1], velocity[2] = state
