"""The poses that a live robot reported lately, and the velocity that they show."""

from __future__ import annotations

from collections import deque

import numpy as np

from cavalcade.geometry import Array

Pose = tuple[float, float, float]

_SPAN = 1.0
"""Velocities are the trend of the poses in so many seconds."""

_FEW = 3
"""Reports without which there is no trend."""


class PoseTrend:
    """Finite poses x, y in m, yaw in rad, map frame, of the last second."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, float, float, float]] = deque()

    def add(self, stamp: float, pose: Pose) -> None:
        """Append a pose measured at `stamp` s, in the place of those that are not older."""
        past = self._past
        while past and past[-1][0] >= stamp:
            past.pop()
        past.append((stamp, *pose))
        while past[0][0] < stamp - _SPAN:
            past.popleft()

    def clear(self) -> None:
        """Forget all."""
        self._past.clear()

    @property
    def pose(self) -> Pose:
        """The last one; zeros if there was none."""
        return self._past[-1][1:] if self._past else (0.0, 0.0, 0.0)

    def velocity(self) -> Pose:
        """The trend, map frame: m/s, m/s, rad/s; zeros where there is none."""
        if len(self._past) < _FEW:
            return 0.0, 0.0, 0.0
        rows: Array = np.array(self._past)
        time = rows[:, 0] - rows[:, 0].mean()
        rows[:, 3] = np.unwrap(rows[:, 3])
        vx, vy, rate = time @ (rows[:, 1:] - rows[-1, 1:]) / float(time @ time)
        return float(vx), float(vy), float(rate)
