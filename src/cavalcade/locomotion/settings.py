"""Settings of the gait and of the predictive control behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError
from cavalcade.geometry import GRAVITY

_POSITIVE = (
    "period", "acceleration", "turning", "silence", "force_weight", "mu", "max_force", "step",
    "interval", "touch",
)  # fmt: skip
_NOT_NEGATIVE = ("clearance", "capture", "stiffness", "joint_damping", "leash", "turn_leash")
_OFFSETS = (0.0, 0.5, 0.5, 0.0)  # of a trot: a front leg and the hind leg on the other side

GAIT = np.dtype(
    [
        *((name, np.float64) for name in ("duty", *_POSITIVE, *_NOT_NEGATIVE)),
        ("offset", np.float64, (4,)),  # of each leg in the cycle
        ("height", np.float64),  # of the trunk over the ground, m
        ("weights", np.float64, (12,)),
    ],
    align=True,
)
"""`GaitSettings` for one robot, whose `height` is known and whose `max_force` is in N."""

Weights = tuple[float, float, float, float, float, float, float, float, float, float, float, float]


@dataclass(frozen=True)
class GaitSettings:
    """A trot and the predictive control behind it.

    Attributes:
        period, duty: Of a cycle, s, and the share of it that a foot stands.
        height: Of the trunk's origin over the ground, m; None for what the robot's description
            says.
        clearance: Of a swinging foot over what is below it, m.
        capture: How far a foothold is moved per error of the velocity, s.
        acceleration, turning: Commands are approached so fast, m/s² and rad/s².
        silence: A robot that has heard no command for so long stops, s.
        weights: Of squared errors of roll, pitch, yaw, x, y, z, their rates in the same order
            (angular velocity, velocity).
        force_weight: Of squared forces, 1/N².
        mu: Friction that is counted on; less than the ground's.
        max_force: On one foot, in body weights.
        step, interval: Of the horizon and between solutions, s.
        stiffness, joint_damping: Of swinging legs' joints, N m/rad and N m s/rad.
        touch: Force from which a foot is known to stand, N.
        leash, turn_leash: The reference runs ahead of the robot at most so far, m and rad.

    Raises:
        InputError: A value that is not finite or out of range; the key is its name.
    """

    period: float = 0.36
    duty: float = 0.5
    height: float | None = None
    clearance: float = 0.08
    capture: float = 0.0
    acceleration: float = 1.0
    turning: float = 2.0
    silence: float = 0.5
    weights: Weights = (2.0, 2.0, 2.0, 4.0, 4.0, 50.0, 0.02, 0.02, 0.15, 0.6, 0.6, 0.2)
    force_weight: float = 1e-5
    mu: float = 0.6
    max_force: float = 1.5
    step: float = 0.04
    interval: float = 0.02
    stiffness: float = 40.0
    joint_damping: float = 1.0
    touch: float = 5.0
    leash: float = 0.06
    turn_leash: float = 0.15

    def __post_init__(self) -> None:
        for name in (*_POSITIVE, *_NOT_NEGATIVE):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError("expected a finite number, not negative", key=name)
            if value == 0.0 and name in _POSITIVE:
                raise InputError("expected a positive number", key=name)
        if not 0.0 < self.duty < 1.0:
            raise InputError("expected a share between 0 and 1", key="duty")
        if self.height is not None and not (math.isfinite(self.height) and self.height > 0.0):
            raise InputError("expected positive metres", key="height")
        weights = np.array(self.weights, dtype=float)
        if weights.shape != (12,) or not (np.isfinite(weights).all() and (weights >= 0.0).all()):
            raise InputError("expected 12 numbers, none of them negative", key="weights")

    def row(self, mass: float, stand_height: float) -> NDArray[np.void]:
        """A row `()` of `GAIT` for a robot of that mass, kg, and standing height, m."""
        row = np.zeros((), GAIT)
        for name in GAIT.names or ():
            if name not in ("offset", "height", "max_force"):
                row[name] = getattr(self, name)
        row["offset"] = _OFFSETS
        row["height"] = stand_height if self.height is None else self.height
        row["max_force"] = self.max_force * mass * GRAVITY
        return row
