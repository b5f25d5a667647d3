"""How one robot's body is planned."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array

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
        if self.iterations < 0:
            raise InputError("expected 0 or more", key="iterations")
        if self.improve < 0:
            raise InputError("expected 0 or more", key="improve")
        if self.seconds is not None and not self.seconds >= 0.0:
            raise InputError("expected 0 or more, or nothing", key="seconds")
        if self.variant not in VARIANTS:
            raise InputError(f"unknown variant {self.variant!r}", key="variant", choices=VARIANTS)
        if not 0.0 <= self.margin <= 1.0:
            raise InputError("expected 0 to 1 m", key="margin")
        discs = np.array(self.discs, dtype=np.float64).reshape(-1, 3)
        if not np.isfinite(discs).all():
            raise InputError("expected finite numbers", key="discs")
        object.__setattr__(self, "discs", discs)
