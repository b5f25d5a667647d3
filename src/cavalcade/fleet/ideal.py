"""Perfect holonomic robots, with imperfections that can be switched on one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.errors import InputError
from cavalcade.fleet._kernels import advance_team
from cavalcade.fleet.protocol import Observation
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots.model import RobotModel
from cavalcade.robots.motion import limits_of

LONGEST_STEP = 0.01
"""Longest internal time step, s."""


@dataclass(frozen=True)
class LocalisationNoise:
    """Standard deviations of the white noise on every reported pose: m and rad."""

    position: float = 0.0
    heading: float = 0.0


@dataclass(frozen=True)
class CommandDelay:
    """What the radio does to messages.

    Attributes:
        mean, jitter: Mean and standard deviation of a command's delay, s; never below zero. A
            command that is overtaken by a later one is ignored.
        drop: Fraction of the messages, commands and pose reports alike, that is lost.
    """

    mean: float = 0.0
    jitter: float = 0.0
    drop: float = 0.0


@dataclass(frozen=True)
class _Message:
    due: float
    number: int
    robot: int
    command: Array


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
        start = np.array(poses, dtype=float)
        if start.ndim != 2 or start.shape != (len(models), 3) or not len(models):
            raise InputError(f"expected one pose (x, y, yaw) per robot, shape ({len(models)}, 3)")
        if not np.isfinite(start).all():
            raise InputError("expected finite poses")
        self._poses = start
        self._velocities = np.zeros_like(start)
        self._commands = np.zeros_like(start)
        self._limits = np.array([limits_of(model) for model in models])
        self._noise = noise or LocalisationNoise()
        self._delay = delay or CommandDelay()
        self._random = np.random.default_rng(seed)
        self._instant = not (self._delay.mean or self._delay.jitter or self._delay.drop)
        self._noisy = bool(self._noise.position or self._noise.heading)
        self._messages: list[_Message] = []
        self._sent = 0
        self._newest = np.full(self.size, -1)
        self._silent = np.zeros(self.size, dtype=bool)
        self._disabled = np.zeros(self.size, dtype=bool)
        self._time = float(time)
        self._reported = np.zeros_like(start)
        self._stamps = np.full(self.size, self._time)
        self._report(lossy=False)

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
        return Observation(self._time, self._reported.copy(), self._stamps.copy())

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
        wanted = np.array(commands, dtype=float)
        if wanted.shape != self._commands.shape or not np.isfinite(wanted).all():
            raise InputError(f"expected finite commands of shape {self._commands.shape}")
        if self._instant:
            self._commands = np.where(self._deaf[:, None], 0.0, wanted)
            return
        self._sent += 1
        delays = self._delay.mean + self._delay.jitter * self._random.standard_normal(self.size)
        lost = self._random.random(self.size) < self._delay.drop
        for robot in np.flatnonzero(~lost):
            due = self._time + max(float(delays[robot]), 0.0)
            self._messages.append(_Message(due, self._sent, int(robot), wanted[robot]))

    def advance(self, dt: float) -> None:
        """Let `dt` seconds pass; every robot that answers then reports its pose.

        Raises:
            InputError: `dt` is not positive and finite.
        """
        if not (math.isfinite(dt) and dt > 0.0):
            raise InputError("expected a positive time step", key="dt")
        steps = max(1, math.ceil(dt / LONGEST_STEP - 1e-9))
        start = self._time
        if self._messages:
            for step in range(steps):
                self._deliver(start + step * dt / steps)
                self._move(dt / steps, 1)
        else:
            self._move(dt / steps, steps)
        self._time = start + dt
        self._report(lossy=True)

    def silence(self, robot: int) -> None:
        """The robot stops answering: no more reports, and it brakes to a halt."""
        self._silent[robot] = True
        self._commands[robot] = 0.0

    def revive(self, robot: int) -> None:
        """The robot answers and listens again, from where it stands."""
        self._silent[robot] = False

    def disable(self, robot: int) -> None:
        """The robot brakes to a halt and ignores commands, but can still be located."""
        self._disabled[robot] = True
        self._commands[robot] = 0.0

    def enable(self, robot: int) -> None:
        """The robot listens to commands again."""
        self._disabled[robot] = False

    @property
    def _deaf(self) -> NDArray[np.bool_]:
        return self._silent | self._disabled

    def _deliver(self, now: float) -> None:
        waiting = []
        for message in self._messages:
            if message.due > now + 1e-9:
                waiting.append(message)
            elif message.number > self._newest[message.robot]:
                self._newest[message.robot] = message.number
                if not self._deaf[message.robot]:
                    self._commands[message.robot] = message.command
        self._messages = waiting

    def _move(self, dt: float, steps: int) -> None:
        advance_team(self._poses, self._velocities, self._commands, self._limits, dt, steps)

    def _report(self, lossy: bool) -> None:
        reporting = ~self._silent
        if lossy and self._delay.drop:
            reporting &= self._random.random(self.size) >= self._delay.drop
        poses = self._poses.copy()
        if self._noisy:
            scale = (self._noise.position, self._noise.position, self._noise.heading)
            poses += self._random.standard_normal(poses.shape) * scale
        poses[:, 2] = wrap_angle(poses[:, 2])
        self._reported[reporting] = poses[reporting]
        self._stamps[reporting] = self._time
