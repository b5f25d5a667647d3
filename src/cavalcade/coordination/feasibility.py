"""What can be proven before any planning: problems without a plan, and why."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from cavalcade.coordination.problem import TeamProblem
from cavalcade.geometry.boxes import footprints_meet
from cavalcade.lattice.collision import pose_free
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.motion_limits import footprint
from cavalcade.lattice.planner import SpaceTimePlanner

_TOUCH = -1e-6
"""Bodies that only touch don't overlap, m."""


def infeasible(
    problem: TeamProblem, lattice: SpaceTimePlanner, deadline: Deadline
) -> tuple[str, tuple[int, ...]] | None:
    """Why there can be no plan, in one line, and the robots that it is about; None without a proof.

    The lattice's cost-to-go says what is connected.
    """
    footprints = [footprint(model) for model in problem.models]
    for name, poses in (("start", problem.starts), ("goal", problem.goals)):
        for k, pose in enumerate(poses):
            if not pose_free(lattice.grid, footprints[k], *pose, _TOUCH):
                return f"the {name} of robot {k} is off the map or in an obstacle", (k,)
        for i, j in combinations(range(len(poses)), 2):
            if footprints_meet(footprints[i], poses[i], footprints[j], poses[j], _TOUCH):
                return f"the {name}s of robots {i} and {j} overlap", (i, j)
    for k, (start, goal) in enumerate(zip(problem.starts, problem.goals, strict=True)):
        if deadline.late:
            break
        if not lattice.reachable(problem.models[k], np.array(start), np.array(goal)):
            return f"no way leads robot {k} to its goal, not even alone", (k,)
    return None
