"""What a robot's own controller measures of its state: with noise, and late."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array

State = tuple[Array, Array, Array]
"""`(N, 19)` positions, `(N, 18)` velocities and `(N, 4)` forces on feet, as of `TeamSimulator`."""


@dataclass(frozen=True)
class SensingErrors:
    """Standard deviations of white noise at every step, and a delay; none by default.

    Attributes:
        position, velocity: Of the trunk, m and m/s, in each direction.
        angle, rate: Of the trunk about each axis, rad and rad/s.
        joint, joint_rate: Of each joint, rad and rad/s.
        delay: How old what is measured is, s.
    """

    position: float = 0.0
    velocity: float = 0.0
    angle: float = 0.0
    rate: float = 0.0
    joint: float = 0.0
    joint_rate: float = 0.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError("expected a number from 0 on", key=field.name)

    @property
    def none(self) -> bool:
        """Whether all errors are zero."""
        return not any(getattr(self, field.name) for field in fields(self))


class Sensing:
    """Makes measured states of true ones, one every `step` s; `seed` is that of the noise."""

    def __init__(self, errors: SensingErrors, step: float, seed: int = 0) -> None:
        self._kept: deque[State] = deque(maxlen=1 + round(errors.delay / step))
        self._random = np.random.default_rng([seed, 1])
        self._position = np.repeat((errors.position, errors.angle, errors.joint), (3, 3, 12))
        self._velocity = np.repeat((errors.velocity, errors.rate, errors.joint_rate), (3, 3, 12))
        self._noisy = bool(self._position.any() or self._velocity.any())

    def measured(self, state: State) -> State:
        """What is known of the robots when their state is this; at first, the first state.

        The arrays given must not be changed afterwards.
        """
        self._kept.append(self._with_noise(state) if self._noisy else state)
        return self._kept[0]

    def _with_noise(self, state: State) -> State:
        qpos, qvel, feet = state
        off = self._random.standard_normal((2, len(qpos), 18))
        off[0] *= self._position
        off[1] *= self._velocity
        measured = qpos.copy()
        measured[:, :3] += off[0, :, :3]
        measured[:, 7:] += off[0, :, 6:]
        measured[:, 3:7] = turned(qpos[:, 3:7], off[0, :, 3:6])
        return measured, qvel + off[1], feet


def turned(quaternions: Array, rotations: Array) -> Array:
    """Unit quaternions `(N, 4)` w, x, y, z turned by rotation vectors `(N, 3)` of the body."""
    angle = np.linalg.norm(rotations, axis=1, keepdims=True)
    # sin(a/2)/a, which is 1/2 at zero.
    vector = rotations * (0.5 * np.sinc(angle / (2.0 * np.pi)))
    scalar = np.cos(0.5 * angle[:, 0])
    w, x, y, z = quaternions.T
    a, b, c = vector.T
    return np.stack(
        (
            w * scalar - x * a - y * b - z * c,
            w * a + x * scalar + y * c - z * b,
            w * b - x * c + y * scalar + z * a,
            w * c + x * b - y * a + z * scalar,
        ),
        axis=1,
    )
