"""Velocities from poses: the motion model follows the commands, the poses correct it."""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.robots.motion import advance, limits_of

_CORRECTION = 0.3  # share of the residual taken as velocity
_TRUSTED = 0.02  # m and rad: a prediction this good confirms the predicted velocity


class VelocityTracker:
    """Estimates the team's velocities.

    A robot that moves as the model predicts has the predicted velocity; otherwise the last two
    poses tell it.
    """

    def __init__(self, model: RobotModel) -> None:
        self._limits = limits_of(model)
        self._poses: Array | None = None
        self._predicted: Array = np.empty((0, 6))
        self._velocities: Array = np.empty((0, 3))
        self._commands: Array = np.empty((0, 3))
        self._time = 0.0

    def reset(self) -> None:
        """Forget everything; the team counts as standing."""
        self._poses = None

    def update(self, poses: Array, time: float) -> Array:
        """Velocities `(N, 3)` in the frame of the poses: m/s, m/s, rad/s.

        Args:
            poses: `(N, 3)` now.
            time: Now, s.
        """
        elapsed = time - self._time
        if self._poses is None or len(self._poses) != len(poses) or not 0.0 < elapsed < 0.5:
            velocities = np.zeros_like(poses)
        else:
            velocities = np.empty_like(poses)
            steps = max(1, int(np.ceil(elapsed / 0.0125 - 1e-9)))
            for k, (pose, velocity, command) in enumerate(
                zip(self._poses, self._velocities, self._commands, strict=True)
            ):
                state = (*pose, *velocity)
                for _ in range(steps):
                    state = advance(*state, *command, elapsed / steps, self._limits)
                moved = poses[k] - pose
                moved[2] = wrap_angle(moved[2])
                off = poses[k] - state[:3]
                off[2] = wrap_angle(off[2])
                good = np.abs(off).max() < _TRUSTED
                guess = np.array(state[3:]) + _CORRECTION / elapsed * off
                velocities[k] = guess if good else moved / elapsed
        self._poses, self._velocities, self._time = poses.copy(), velocities.copy(), time
        return velocities

    def commanded(self, commands: Array) -> None:
        """Body-frame commands `(N, 3)` that hold from now on."""
        self._commands = commands.copy()
