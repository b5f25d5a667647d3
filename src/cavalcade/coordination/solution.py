"""What methods work with: a robot's path, and what a method ends with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.lattice.ground import Ground
from cavalcade.lattice.planner import TRACK_STEP, TimedPath, trajectory_of


@dataclass(frozen=True, eq=False)
class RobotPath:
    """From a robot's start to its goal, in the ground's frame.

    Attributes:
        motion: Moves over even ground, or a trajectory.
        cost: What coordinators minimise: seconds, and the cost of every metre.
    """

    motion: TimedPath | Trajectory
    cost: float

    @cached_property
    def track(self) -> Array:
        """Poses `(K, 3)` every `TRACK_STEP` s, the last at or after the end."""
        if isinstance(self.motion, TimedPath):
            return self.motion.track()
        count = int(np.ceil(self.motion.duration / TRACK_STEP - 1e-9)) + 1
        times = np.asarray(np.arange(count) * TRACK_STEP, dtype=np.float64)
        return self.motion.poses_at(times)

    def trajectory(self, ground: Ground) -> Trajectory:
        """The same as samples."""
        if isinstance(self.motion, TimedPath):
            return trajectory_of(self.motion, ground)
        return self.motion


Paths = tuple[RobotPath, ...]
"""A path for each robot of a team, in their order."""


@dataclass(frozen=True)
class Solution:
    """What a method ended with, solved or not.

    Attributes:
        paths: A path for each robot; free of conflicts if `solved`.
        solved: Whether they are a plan.
        method: Which method it was; empty where no two robots were in conflict.
        counts: Figures of the method.
        history: Iterations and summed cost as the plan got better.
    """

    paths: Paths
    solved: bool
    method: str
    counts: Mapping[str, int] = field(default_factory=dict)
    history: tuple[tuple[int, float], ...] = ()


def total_cost(paths: Paths) -> float:
    """Summed over the robots."""
    return sum(path.cost for path in paths)
