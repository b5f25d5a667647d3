"""Perfect holonomic robots, with imperfections that can be switched on one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.fleet._kernels import advance_team
from cavalcade.fleet.protocol import Observation
from cavalcade.fleet.radio import CommandDelay, LocalisationNoise, Radio, start_poses
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots.model import RobotModel
from cavalcade.robots.motion import limits_of

LONGEST_STEP = 0.01
"""Longest internal time step, s."""


class IdealFleet:
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
        self._time = float(time)
        self._radio = Radio(self._poses, self._time, noise, delay, seed)

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self._poses)

    @property
    def time(self) -> float:
        """The fleet's clock, s."""
        return self._time

    def observe(self) -> Observation:
        """The newest pose report of every robot and when it was measured."""
        return self._radio.observation(self._time)

    def true_poses(self) -> Array:
        """`(N, 3)` true poses now, yaw in [-pi, pi)."""
        poses = self._poses.copy()
        poses[:, 2] = wrap_angle(poses[:, 2])
        return poses

    def true_velocities(self) -> Array:
        """`(N, 3)` true velocities now, map frame: m/s, m/s, rad/s."""
        return self._velocities.copy()

    def send(self, commands: ArrayLike) -> None:
        """Command body-frame velocities `(N, 3)`: m/s, m/s, rad/s. They hold until the next.

        Raises:
            InputError: Another shape, or a value that is not finite; nothing is sent then.
        """
        self._radio.send(commands, self._time)

    def advance(self, dt: float) -> None:
        """Let `dt` seconds pass; every robot that answers then reports its pose.

        Raises:
            InputError: `dt` is not positive and finite.
        """
        if not (math.isfinite(dt) and dt > 0.0):
            raise InputError("expected a positive time step", key="dt")
        steps = max(1, math.ceil(dt / LONGEST_STEP - 1e-9))
        start = self._time
        if self._radio.busy:
            for step in range(steps):
                self._radio.deliver(start + step * dt / steps)
                self._move(dt / steps, 1)
        else:
            self._move(dt / steps, steps)
        self._time = start + dt
        self._radio.report(self._poses, self._time)

    def silence(self, robot: int) -> None:
        """The robot stops answering: no more reports, and it brakes to a halt."""
        self._radio.silence(robot)

    def revive(self, robot: int) -> None:
        """The robot answers and listens again, from where it stands."""
        self._radio.revive(robot)

    def disable(self, robot: int) -> None:
        """The robot brakes to a halt and ignores commands, but can still be located."""
        self._radio.disable(robot)

    def enable(self, robot: int) -> None:
        """The robot listens to commands again."""
        self._radio.enable(robot)

    def _move(self, dt: float, steps: int) -> None:
        commands = self._radio.commands
        advance_team(self._poses, self._velocities, commands, self._limits, dt, steps)
