"""Braking when a team is paused, and setting off when it is resumed, as robots like it."""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array
from cavalcade.robots import RobotModel


class Ramp:
    """Lets what is wanted of robots change by no more than their limits of acceleration allow.

    From a pause on until robots that were resumed go as they would without it. What the safety
    filter takes back is another matter.
    """

    def __init__(self, model: RobotModel, period: float, robots: int) -> None:
        self._most = model.max_acceleration * period, model.max_yaw_acceleration * period
        self._sent = np.zeros((robots, 3))
        self._on = False
        self._time = 0.0
        self._longest = 2.5 * period

    def begin(self) -> None:
        """The team is paused."""
        self._on = True

    def left_out(self, now: float) -> bool:
        """Whether the pause went by without cycles until now, s: robots were commanded zero."""
        left_out = self._on and now - self._time > self._longest
        if left_out:
            self._sent[:] = 0.0
        return left_out

    def commanded(self, commands: Array, now: float) -> None:
        """Body-frame commands `(N, 3)` that are sent now."""
        self._sent, self._time = commands.copy(), now

    def limited(self, wanted: Array, yaw: Array, paused: bool) -> Array:
        """Wanted velocities `(N, 3)` of robots with headings `(N,)`, m/s, m/s, rad/s, limited."""
        if not self._on:
            return wanted
        x, y, turn = self._sent.T
        c, s = np.cos(yaw), np.sin(yaw)
        before = np.column_stack([c * x - s * y, s * x + c * y, turn])
        change = wanted - before
        size = np.hypot(change[:, 0], change[:, 1])
        most, most_turn = self._most
        change[:, :2] *= np.minimum(1.0, most / np.maximum(size, 1e-9))[:, None]
        change[:, 2] = np.clip(change[:, 2], -most_turn, most_turn)
        limited = before + change
        self._on = paused or bool(np.abs(limited - wanted).max(initial=0.0) > 1e-9)
        return np.asarray(limited)
