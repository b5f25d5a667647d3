"""Velocities from poses: the motion model follows the commands, the poses confirm it."""

from __future__ import annotations

from collections import deque

import numpy as np

from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.robots.motion import limits_of, predict_team

_WINDOW = 5  # cycles over which prediction and poses are compared
_TRUSTED = 0.025  # m and rad: displacements over the window that differ by less agree
_STEP = 0.0125  # s: step of the prediction
_LONGEST = 0.5  # s without a pose after which the team counts as standing


class VelocityTracker:
    """Estimates the team's velocities.

    A robot that moves as the model predicts from its commands has the predicted velocity, without
    the noise of differences. One that does not (late or lost commands, a slip) has the velocity
    that its last poses tell.

    Args:
        model: The robots'.
        period: Seconds between updates.
    """

    def __init__(self, model: RobotModel, period: float = 0.05) -> None:
        self._longest = max(_LONGEST, 2.5 * period)
        self._limits = limits_of(model)
        self._poses: Array | None = None
        self._velocities: Array = np.empty((0, 3))
        self._commands: Array = np.empty((0, 3))
        self._time = 0.0
        # Per cycle: seconds, displacement seen and displacement predicted.
        self._history: deque[tuple[float, Array, Array]] = deque(maxlen=_WINDOW)

    def update(self, poses: Array, time: float) -> Array:
        """Velocities `(N, 3)` in the frame of the poses: m/s, m/s, rad/s.

        Args:
            poses: `(N, 3)` now.
            time: Now, s.
        """
        elapsed = time - self._time
        if (
            self._poses is None
            or len(self._poses) != len(poses)
            or not 0.0 < elapsed < self._longest
        ):
            velocities = np.zeros_like(poses)
            self._history.clear()
        else:
            steps = max(1, int(np.ceil(elapsed / _STEP - 1e-9)))
            states = predict_team(
                self._poses, self._velocities, self._commands, elapsed / steps, steps, self._limits
            )
            seen = poses - self._poses
            seen[:, 2] = wrap_angle(seen[:, 2])
            self._history.append((elapsed, seen, states[:, :3] - self._poses))
            span = sum(entry[0] for entry in self._history)
            moved = sum((entry[1] for entry in self._history), np.zeros_like(poses))
            expected = sum((entry[2] for entry in self._history), np.zeros_like(poses))
            agree = np.abs(moved - expected).max(axis=1) < _TRUSTED
            velocities = np.where(agree[:, None], states[:, 3:], moved / span)
        self._poses, self._velocities, self._time = poses.copy(), velocities.copy(), time
        return velocities

    def commanded(self, commands: Array) -> None:
        """Body-frame commands `(N, 3)` that hold from now on."""
        self._commands = commands.copy()
