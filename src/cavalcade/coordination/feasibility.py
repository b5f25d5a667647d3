"""What can be proven before any planning: problems without a plan, and why."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cavalcade.coordination.problem import Pose, TeamProblem
from cavalcade.geometry import Array
from cavalcade.lattice.collision import bodies_meet, pose_free
from cavalcade.lattice.planner import TimedPlanner
from cavalcade.robots import RobotModel

_TOUCH = -1e-6
"""Bodies that only touch don't overlap, m."""


@dataclass(frozen=True)
class Proof:
    """Why there is no plan.

    Attributes:
        text: One line.
        robots: That it is about.
    """

    text: str
    robots: tuple[int, ...]


def impossible(problem: TeamProblem, timed: TimedPlanner) -> Proof | None:
    """A proof that there is no plan, if one is at hand.

    Args:
        problem: The team's.
        timed: Its guides say what is connected.
    """
    for name, poses in (("start", problem.starts), ("goal", problem.goals)):
        for k, pose in enumerate(poses):
            if not _stands_free(timed, problem.models[k], pose):
                return Proof(f"the {name} of robot {k} is off the map or in an obstacle", (k,))
        for i, j in combinations(range(len(poses)), 2):
            if _overlap(problem.models[i], poses[i], problem.models[j], poses[j]):
                return Proof(f"the {name}s of robots {i} and {j} overlap", (i, j))
    for k, (start, goal) in enumerate(zip(problem.starts, problem.goals, strict=True)):
        guide, cell = timed.guide(np.array(goal), problem.models[k])
        if guide.shape[0] and not np.isfinite(guide[_cell(guide, cell, start)]):
            return Proof(f"no way leads robot {k} to its goal, not even alone", (k,))
    return None


def _stands_free(timed: TimedPlanner, model: RobotModel, pose: Pose) -> bool:
    return bool(
        pose_free(
            timed.grid,
            *pose,
            model.length / 2.0,
            model.width / 2.0,
            float(model.round),
            _TOUCH,
        )
    )


def _overlap(one: RobotModel, at: Pose, other: RobotModel, there: Pose) -> bool:
    return bool(
        bodies_meet(
            *at,
            one.length / 2.0,
            one.width / 2.0,
            float(one.round),
            *there,
            other.length / 2.0,
            other.width / 2.0,
            float(other.round),
            _TOUCH,
        )
    )


def _cell(guide: Array, cell: float, pose: Pose) -> tuple[int, int]:
    rows, cols = guide.shape
    return min(int(pose[1] / cell), rows - 1), min(int(pose[0] / cell), cols - 1)
