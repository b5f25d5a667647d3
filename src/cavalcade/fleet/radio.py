"""What lies between a planner and simulated robots: late and lost messages, noisy reports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.errors import InputError
from cavalcade.fleet.protocol import Observation
from cavalcade.geometry import Array, wrap_angle


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


class Radio:
    """Carries commands to the robots of a simulated fleet and their poses back.

    Args:
        poses: `(N, 3)` true poses at the start, map frame, m and rad; they are reported at once.
        time: The clock at the start, s.
        noise: Errors of the reported poses.
        delay: Delay and loss of messages.
        seed: Of the noise, the jitter and the losses.
    """

    def __init__(
        self,
        poses: Array,
        time: float,
        noise: LocalisationNoise | None = None,
        delay: CommandDelay | None = None,
        seed: int = 0,
    ) -> None:
        size = len(poses)
        self.commands = np.zeros((size, 3))
        """What each robot was told last, body frame: m/s, m/s, rad/s."""
        self._noise = noise or LocalisationNoise()
        self._delay = delay or CommandDelay()
        self._random = np.random.default_rng(seed)
        self._instant = not (self._delay.mean or self._delay.jitter or self._delay.drop)
        self._noisy = bool(self._noise.position or self._noise.heading)
        self._messages: list[_Message] = []
        self._sent = 0
        self._newest = np.full(size, -1)
        self._silent = np.zeros(size, dtype=bool)
        self._disabled = np.zeros(size, dtype=bool)
        self._reported = np.zeros((size, 3))
        self._stamps = np.full(size, time)
        self._report(poses, time, lossy=False)

    @property
    def busy(self) -> bool:
        """Whether commands are on their way."""
        return bool(self._messages)

    @property
    def deaf(self) -> NDArray[np.bool_]:
        """`(N,)` robots that ignore commands."""
        return self._silent | self._disabled

    def send(self, commands: ArrayLike, time: float) -> NDArray[np.bool_]:
        """Send commands `(N, 3)` off at `time` s; who has got one already, `(N,)`.

        Raises:
            InputError: Another shape, or a value that is not finite; nothing is sent then.
        """
        wanted = np.array(commands, dtype=float)
        if wanted.shape != self.commands.shape or not np.isfinite(wanted).all():
            raise InputError(f"expected finite commands of shape {self.commands.shape}")
        if self._instant:
            self.commands = np.where(self.deaf[:, None], 0.0, wanted)
            return ~self.deaf
        size = len(wanted)
        self._sent += 1
        delays = self._delay.mean + self._delay.jitter * self._random.standard_normal(size)
        lost = self._random.random(size) < self._delay.drop
        for robot in np.flatnonzero(~lost):
            due = time + max(float(delays[robot]), 0.0)
            self._messages.append(_Message(due, self._sent, int(robot), wanted[robot]))
        return np.zeros(size, dtype=bool)

    def deliver(self, now: float) -> NDArray[np.bool_]:
        """Let commands arrive that are due at `now` s; who has got one, `(N,)`."""
        waiting = []
        reached = np.zeros(len(self.commands), dtype=bool)
        for message in self._messages:
            if message.due > now + 1e-9:
                waiting.append(message)
            elif message.number > self._newest[message.robot]:
                self._newest[message.robot] = message.number
                if not (self._silent[message.robot] or self._disabled[message.robot]):
                    self.commands[message.robot] = message.command
                    reached[message.robot] = True
        self._messages = waiting
        return reached

    def report(self, poses: Array, time: float) -> None:
        """Every robot that answers reports its pose; some reports are lost."""
        self._report(poses, time, lossy=True)

    def observation(self, time: float) -> Observation:
        """The newest report of every robot, as known at `time` s."""
        return Observation(time, self._reported.copy(), self._stamps.copy())

    def silence(self, robot: int) -> None:
        """No more reports of the robot, and no commands to it."""
        self._silent[robot] = True
        self.commands[robot] = 0.0

    def revive(self, robot: int) -> None:
        """The robot answers and listens again."""
        self._silent[robot] = False

    def disable(self, robot: int) -> None:
        """The robot ignores commands, but reports its pose."""
        self._disabled[robot] = True
        self.commands[robot] = 0.0

    def enable(self, robot: int) -> None:
        """The robot listens to commands again."""
        self._disabled[robot] = False

    def _report(self, poses: Array, time: float, lossy: bool) -> None:
        reporting = ~self._silent
        if lossy and self._delay.drop:
            reporting &= self._random.random(len(poses)) >= self._delay.drop
        seen = poses.copy()
        if self._noisy:
            scale = (self._noise.position, self._noise.position, self._noise.heading)
            seen += self._random.standard_normal(seen.shape) * scale
        seen[:, 2] = wrap_angle(seen[:, 2])
        self._reported[reporting] = seen[reporting]
        self._stamps[reporting] = time


def start_poses(poses: ArrayLike, robots: int) -> Array:
    """Start poses as an array `(robots, 3)` of their own.

    Raises:
        InputError: Another number, or a pose that is not finite.
    """
    start = np.array(poses, dtype=float)
    if start.ndim != 2 or start.shape != (robots, 3) or not robots:
        raise InputError(f"expected one pose (x, y, yaw) per robot, shape ({robots}, 3)")
    if not np.isfinite(start).all():
        raise InputError("expected finite poses")
    return start
