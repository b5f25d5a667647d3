"""What lies between a planner and simulated robots: late and lost messages, noisy reports."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.errors import InputError
from cavalcade.fleet.protocol import Observation
from cavalcade.geometry import Array, wrap_angle
from cavalcade.values import number_array


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


class RadioFleet:
    """A simulated fleet as planners know it: a radio carries commands there and poses back.

    How robots move is up to those who derive from it: `_move`, and `_hear` if they must know when
    a command arrives. Their true poses `(N, 3)` at the start, map frame, are reported at once;
    `seed` is that of the noise, the jitter and the losses.
    """

    def __init__(
        self,
        poses: Array,
        time: float,
        noise: LocalisationNoise | None,
        delay: CommandDelay | None,
        seed: int,
    ) -> None:
        size = len(poses)
        self._time = time
        # What each robot was told last, body frame: m/s, m/s, rad/s.
        self._commands = np.zeros((size, 3))
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
        self._report(poses, lossy=False)

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self._commands)

    @property
    def time(self) -> float:
        """The fleet's clock, s."""
        return self._time

    def observe(self) -> Observation:
        """The newest pose report of every robot and when it was measured."""
        return Observation(self._time, self._reported.copy(), self._stamps.copy())

    def send(self, commands: ArrayLike, robots: ArrayLike | None = None) -> None:
        """Command body-frame velocities `(N, 3)`: m/s, m/s, rad/s. They hold until the next.

        Only `robots` `(N,)`, True or False, are told; all of them by default.

        Raises:
            InputError: Another shape, or a value that is not finite; nothing is sent then.
        """
        shape = self._commands.shape
        wanted = number_array(commands, "commands", shape, f"finite commands of shape {shape}")
        told = np.ones(self.size, dtype=bool) if robots is None else np.asarray(robots, dtype=bool)
        if self._instant:
            told = told & ~(self._silent | self._disabled)
            self._commands = np.where(told[:, None], wanted, self._commands)
            self._hear(told, self._time)
            return
        self._sent += 1
        delays = self._delay.mean + self._delay.jitter * self._random.standard_normal(self.size)
        lost = self._random.random(self.size) < self._delay.drop
        for robot in np.flatnonzero(told & ~lost):
            due = self._time + max(float(delays[robot]), 0.0)
            self._messages.append(_Message(due, self._sent, int(robot), wanted[robot]))

    def advance(self, dt: float) -> None:
        """Let `dt` seconds pass; every robot that answers then reports its pose.

        Raises:
            InputError: `dt` is not positive and finite, or physics has become unstable.
        """
        if not (math.isfinite(dt) and dt > 0.0):
            raise InputError("expected a positive time step", key="dt")
        start, self._time = self._time, self._time + dt
        self._report(self._move(start, dt), lossy=True)

    def halt(self, robot: int) -> None:
        """The robot forgets its command and comes to a halt; it obeys the next one."""
        self._commands[robot] = 0.0
        self._hear(np.eye(self.size, dtype=bool)[robot], self._time)

    def silence(self, robot: int) -> None:
        """The robot stops answering: no more reports, and it comes to a halt."""
        self._silent[robot] = True
        self.halt(robot)

    def revive(self, robot: int) -> None:
        """The robot answers and listens again, from where it stands."""
        self._silent[robot] = False

    def disable(self, robot: int) -> None:
        """The robot comes to a halt and ignores commands, but can still be located."""
        self._disabled[robot] = True
        self.halt(robot)

    def enable(self, robot: int) -> None:
        """The robot listens to commands again."""
        self._disabled[robot] = False

    def _move(self, start: float, dt: float) -> Array:
        """Move the robots from the time `start` on for `dt` s; their true poses `(N, 3)` then."""
        raise NotImplementedError

    def _hear(self, reached: NDArray[np.bool_], now: float) -> None:
        """Robots `reached` `(N,)` have got their `_commands` at `now` s."""

    def _deliver(self, now: float) -> None:
        """Let commands arrive that are due at `now` s."""
        if not self._messages:
            return
        waiting = []
        reached = np.zeros(self.size, dtype=bool)
        for message in self._messages:
            robot = message.robot
            if message.due > now + 1e-9:
                waiting.append(message)
            elif message.number > self._newest[robot]:
                self._newest[robot] = message.number
                if not (self._silent[robot] or self._disabled[robot]):
                    self._commands[robot] = message.command
                    reached[robot] = True
        self._messages = waiting
        self._hear(reached, now)

    def _report(self, poses: Array, lossy: bool) -> None:
        """Every robot that answers reports its pose; some reports are lost where `lossy`."""
        reporting = ~self._silent
        if lossy and self._delay.drop:
            reporting &= self._random.random(len(poses)) >= self._delay.drop
        seen = poses.copy()
        if self._noisy:
            scale = (self._noise.position, self._noise.position, self._noise.heading)
            seen += self._random.standard_normal(seen.shape) * scale
        seen[:, 2] = wrap_angle(seen[:, 2])
        self._reported[reporting] = seen[reporting]
        self._stamps[reporting] = self._time


def start_poses(poses: ArrayLike, robots: int) -> Array:
    """Start poses as an array `(robots, 3)` of their own, which must be finite."""
    what = f"one finite pose (x, y, yaw) per robot, shape ({robots}, 3)"
    if not robots:
        raise InputError(f"expected {what}, and a robot", key="poses")
    return number_array(poses, "poses", (robots, 3), what)
