"""Robots that the team cannot rely on: located too long ago, or deaf to their commands."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation.cycle import named
from cavalcade.formation.estimation import Imperfections, longest_gap
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel

_WINDOW = 1.2  # s over which motion is compared with commands
_EVERY = 0.15  # s: it need not be in every cycle
_PATIENCE = 1.0  # s for which a robot may seem not to follow
_FAR = np.array([0.10, 0.30])  # m and rad of commanded motion that can be judged,
_SIGMAS = 5.0  # if they are also so many standard deviations of the reports
_TOLD, _TOLD_FOR, _COVERED = 0.1, 2.0, 0.2  # m/s, s, and share of it: less is not following
_INSTANT = 1e6  # m/s² and rad/s² of robots that change their velocities at once
_DEAF, _FOLLOWS = 0.25, 0.5  # share of it: below the first it seems not to follow, until the second


class AgeMonitor:
    """Says whose last pose is too old, or from the future.

    Attributes:
        stale: Robots that are located too badly to be driven, or to have others driven near.
        message: What is wrong, for people.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self.stale: tuple[int, ...] = ()
        self.message = ""

    def update(self, stamps: Array | None, now: float, active: NDArray[np.int64]) -> None:
        """Judge the stamps `(N,)` of the robots that take part; None for robots located now."""
        self.stale, self.message = (), ""
        if stamps is None:
            return
        age = now - stamps[active]
        odd = np.abs(age) > self._limit + 1e-9
        if odd.any():
            self.stale = tuple(active[odd].tolist())
            late = "older" if (age > self._limit).any() else "stamped later"
            self.message = f"last pose of {named(self.stale)} is {late} than {self._limit:g} s"
            self.message += "" if late == "older" else " from now"


class FollowingMonitor:
    """Says who does not do as commanded, within 3 s for commands that ask for 0.1 m/s or more.

    Motion of the last moments is compared with what the commands in effect should have
    brought about within the limit of acceleration.

    Attributes:
        deaf: Robots that have covered next to nothing of it for a second.
    """

    _window = _WINDOW

    def __init__(
        self,
        model: RobotModel | Sequence[RobotModel],
        robots: int,
        period: float,
        expected: Imperfections,
    ) -> None:
        self._delay = expected.delay
        self._longest = longest_gap(period)
        noise = np.array([expected.position, expected.heading])
        self._far = np.maximum(_FAR, _SIGMAS * noise)
        models = [model] * robots if isinstance(model, RobotModel) else model
        gains = [(one.max_acceleration, one.max_yaw_acceleration) for one in models]
        self._gain = np.minimum(np.array(gains, dtype=float).T, _INSTANT)
        self._velocities = np.zeros((robots, 3))  # in effect; body frame
        self._commands = np.zeros((robots, 3))
        self._coming: deque[tuple[float, Array]] = deque()
        self._poses: Array = np.empty((0, 3))
        self._time = self._now = 0.0
        # Since the beginning: motion that was commanded, and that was seen.
        self._totals = np.zeros((2, robots, 3))
        self._past: deque[tuple[float, Array]] = deque()
        self._since = np.full(robots, np.inf)
        self.deaf: tuple[int, ...] = ()

    def update(self, poses: Array, now: float) -> None:
        """Judge the poses `(N, 3)` reported at a time in s."""
        if now - self._now > self._longest:
            self.forget()
        self._now = now
        if len(self._poses) == 0:
            self._poses, self._time = poses, now
        elapsed = now - self._time
        if 0.0 < elapsed < _EVERY:
            return
        held = []
        while self._coming and self._coming[0][0] <= now:
            held.append(self._coming.popleft()[1])
        if held:
            self._commands = sum(held, np.zeros_like(poses)) / len(held)
        change = self._commands - self._velocities
        size = np.hypot(change[:, 0], change[:, 1])
        share = np.minimum(self._gain[0] * elapsed / np.maximum(size, 1e-9), 1.0)
        change[:, :2] *= share[:, None]
        most = self._gain[1] * elapsed
        change[:, 2] = np.minimum(np.maximum(change[:, 2], -most), most)
        self._velocities += change
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y, turn = (elapsed * self._velocities).T
        moved = np.empty_like(self._totals)
        moved[0, :, 0], moved[0, :, 1], moved[0, :, 2] = c * x - s * y, s * x + c * y, turn
        moved[1] = poses - self._poses
        moved[1, :, 2] = wrap_angle(moved[1, :, 2])
        self._totals = self._totals + self._counted(moved)
        self._poses, self._time = poses, now
        self._past.append((now, self._totals))
        while now - self._past[0][0] > self._window + 1e-9:
            self._past.popleft()
        wanted, seen = self._totals - self._past[0][1]
        self._judge(wanted, seen, now)

    def _counted(self, moved: Array) -> Array:
        """What counts of motion `(2, N, 3)` of a moment, commanded and seen, map frame."""
        return moved

    def commanded(self, commands: Array) -> None:
        """Body-frame commands `(N, 3)` that are sent now; said again, they replace the former."""
        due = self._now + self._delay
        if self._coming and self._coming[-1][0] == due:
            self._coming.pop()
        self._coming.append((due, commands))

    def forget(self) -> None:
        """Poses and commands before now say nothing of those that come."""
        self._past.clear()
        self._since[:] = np.inf
        self._poses = np.empty((0, 3))

    def _judge(self, wanted: Array, seen: Array, now: float) -> None:
        distance = np.hypot(wanted[:, 0], wanted[:, 1])
        along = (wanted[:, :2] * seen[:, :2]).sum(axis=1) / np.maximum(distance, 1e-9)
        turn = np.abs(wanted[:, 2])
        turned = seen[:, 2] * np.sign(wanted[:, 2])
        far = distance > self._far[0]
        turning = ~far & (turn > self._far[1])
        # The share of what was commanded that was seen; 1 where that was too little to tell.
        share = np.ones(len(wanted))
        share[far] = along[far] / distance[far]
        share[turning] = turned[turning] / turn[turning]
        since = np.where(share < _DEAF, np.minimum(self._since, now), self._since)
        self._since = np.where(share < _FOLLOWS, since, np.inf)
        deaf = now - self._since >= _PATIENCE
        self.deaf = tuple(np.nonzero(deaf)[0].tolist()) if deaf.any() else ()


class UnresponsiveMonitor(FollowingMonitor):
    """Says who was told to go at 0.1 m/s or more for 2 s and covered less than 20 % of that.

    What is covered is counted along the commanded path, wherever that leads: there and back again
    is following, though it leads nowhere. Commands are those that were sent; what a robot cannot
    do is not asked of it.
    """

    _window = _TOLD_FOR

    def __init__(self, models: Sequence[RobotModel], period: float, expected: Imperfections):
        super().__init__(models, len(models), period, expected)
        self._most = np.array([(one.max_speed_x, one.max_speed_y) for one in models])
        self._idle = np.full(len(models), np.inf)

    def commanded(self, commands: Array) -> None:
        """Body-frame commands `(N, 3)` that are sent now."""
        size = np.hypot(*(commands[:, :2] / np.maximum(self._most, 1e-9)).T)
        super().commanded(commands / np.maximum(size, 1.0)[:, None])

    def excuse(self, robots: Sequence[int]) -> None:
        """These take no commands at present."""
        self._idle[list(robots)] = np.inf

    def forget(self) -> None:
        """Poses and commands before now say nothing of those that come."""
        super().forget()
        self._coming.clear()
        self._commands = np.zeros_like(self._commands)
        self._velocities = np.zeros_like(self._velocities)
        self._idle[:] = np.inf
        self.deaf = ()

    def _counted(self, moved: Array) -> Array:
        """Of each robot the length of the commanded path, and what of it was covered, m."""
        wanted, seen = moved[:, :, :2]
        length = np.hypot(wanted[:, 0], wanted[:, 1])
        counted = np.zeros_like(moved)
        counted[0, :, 0] = length
        counted[1, :, 0] = (wanted * seen).sum(axis=1) / np.maximum(length, 1e-9)
        return counted

    def _judge(self, wanted: Array, seen: Array, now: float) -> None:
        told = np.hypot(self._commands[:, 0], self._commands[:, 1]) >= _TOLD - 1e-9
        self._idle = np.where(told, np.minimum(self._idle, now), now)
        length, covered = wanted[:, 0], seen[:, 0]
        deaf = told & (now - self._idle >= _TOLD_FOR - 1e-9) & (covered < _COVERED * length)
        deaf &= length > self._far[0]
        self.deaf = tuple(np.nonzero(deaf)[0].tolist()) if deaf.any() else ()
