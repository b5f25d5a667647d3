"""Settings of the simulated world."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array


@dataclass(frozen=True)
class PhysicsSettings:
    """How the simulated world behaves.

    Attributes:
        step: Length of a physics step, s.
        friction: Coulomb coefficient between a robot and what it touches: one for all or one per
            robot.
        mass_scale: Factor on all masses and inertias: one for all or one per robot.
        variation: Half width of the uniform distribution around 1 from which a further factor on
            the mass and one on the friction of each robot are sampled, by `seed`.
        torque_speed: Whether motors lose torque with speed: in a straight line from the stall
            torque at rest to none at the no-load speed. It holds where the motor drives; where it
            brakes, and otherwise, only the torque limit does.
        seed: Of what is sampled.
        looks: Whether the shapes for drawing are part of the model; they slow it down.
    """

    step: float = 0.002
    friction: float | tuple[float, ...] = 0.8
    mass_scale: float | tuple[float, ...] = 1.0
    variation: float = 0.0
    torque_speed: bool = False
    seed: int = 0
    looks: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step) and 1e-5 <= self.step <= 0.01):
            raise InputError("expected seconds between 0.00001 and 0.01", key="step")
        for name in ("friction", "mass_scale"):
            values = np.atleast_1d(np.array(getattr(self, name), dtype=float))
            if not (np.isfinite(values).all() and (values > 0.0).all()):
                raise InputError("expected positive numbers", key=name)
        if not 0.0 <= self.variation < 1.0:
            raise InputError("expected a number from 0 to less than 1", key="variation")

    def sample(self, robots: int) -> tuple[Array, Array]:
        """Friction coefficients `(N,)` and mass factors `(N,)` of so many robots."""
        factors = 1.0 + self.variation * (
            2.0 * np.random.default_rng(self.seed).random((robots, 2)) - 1.0
        )
        friction = self._each("friction", robots) * factors[:, 0]
        return friction, self._each("mass_scale", robots) * factors[:, 1]

    def _each(self, name: str, robots: int) -> Array:
        values = np.atleast_1d(np.array(getattr(self, name), dtype=float))
        if values.shape not in ((1,), (robots,)):
            raise InputError(f"expected one number or {robots}, one per robot", key=name)
        return np.broadcast_to(values, robots).copy()
