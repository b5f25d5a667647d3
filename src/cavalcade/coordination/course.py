"""A course: one robot's motion as coordinators handle it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.lattice.ground import Ground
from cavalcade.lattice.planner import TRACK_STEP, Way, trajectory_of


@dataclass(frozen=True, eq=False)
class Course:
    """From a robot's start to its goal, in the ground's frame.

    Attributes:
        motion: Moves over even ground, or a trajectory.
        cost: What coordinators minimise: seconds, and a price for every metre.
    """

    motion: Way | Trajectory
    cost: float

    @property
    def duration(self) -> float:
        """S."""
        return self.motion.duration

    @property
    def length(self) -> float:
        """M."""
        return self.motion.length

    @cached_property
    def track(self) -> Array:
        """Poses `(K, 3)` every `TRACK_STEP` s, the last at or after the end."""
        if isinstance(self.motion, Way):
            return self.motion.track()
        count = int(np.ceil(self.motion.duration / TRACK_STEP - 1e-9)) + 1
        times = np.asarray(np.arange(count) * TRACK_STEP, dtype=np.float64)
        return self.motion.poses_at(times)

    def trajectory(self, ground: Ground) -> Trajectory:
        """The same as samples."""
        if isinstance(self.motion, Way):
            return trajectory_of(self.motion, ground)
        return self.motion
