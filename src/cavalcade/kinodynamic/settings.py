"""How one robot's body is planned."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.values import described, instance_of, number_array, number_in, whole_number

VARIANTS = ("cavalcade", "published")


@dataclass(frozen=True, eq=False)
class BodySettings:
    """Settings of `plan_body`.

    Attributes:
        iterations: The budget: extensions of trees until the first plan. 0 allows none.
        seconds: Limit of wall time, s; None for none. A plan found never depends on it otherwise.
        improve: Iterations spent on a shorter plan once there is one.
        leaps: Whether the robot may leap.
        variant: `published` keeps to the planner that the paper builds on: leaps drawn at random,
            vertical speed that jumps where a leap begins and ends, no limit of the yaw rate.
        discs: `(K, 3)` x, y, radius in m where the body's centre may not be, besides the ground's
            own obstacles; for all time.
        margin: Kept between the footprint and solid ground, m; none where the start or the goal
            is nearer than that.

    Raises:
        InputError: A value out of range; the key says which.
    """

    iterations: int = 20_000
    seconds: float | None = None
    improve: int = 0
    leaps: bool = True
    variant: Literal["cavalcade", "published"] = "cavalcade"
    discs: Array = field(default_factory=lambda: np.zeros((0, 3)))
    margin: float = 0.01

    def __post_init__(self) -> None:
        whole_number(self.iterations, "iterations", 0)
        whole_number(self.improve, "improve", 0)
        if self.seconds is not None:
            number_in(self.seconds, "seconds", 0.0, unit="s")
        instance_of(self.leaps, bool, "leaps", "True or False")
        if not isinstance(self.variant, str) or self.variant not in VARIANTS:
            raise InputError(
                f"unknown variant {described(self.variant)}", key="variant", choices=VARIANTS
            )
        number_in(self.margin, "margin", 0.0, 1.0, "m")
        if np.shape(self.discs) == (0,):
            discs = np.zeros((0, 3))
        else:
            discs = number_array(self.discs, "discs", (None, 3), "discs (K, 3) in m")
        object.__setattr__(self, "discs", discs)
