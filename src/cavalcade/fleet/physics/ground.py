"""What robots walk on and run into."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.geometry import Array


@dataclass(frozen=True)
class PhysicsGround:
    """The ground for physics: so far a level plane."""

    @classmethod
    def flat(cls) -> PhysicsGround:
        """Level ground without end at height 0."""
        return cls()

    def heights_at(self, points: ArrayLike) -> Array:
        """Heights `(N,)` in m of the ground at points `(N, 2)` of the map frame."""
        return np.zeros(len(np.asarray(points)))
