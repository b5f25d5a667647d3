"""What can be proven before any planning: problems without a plan, and why."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from cavalcade.coordination.problem import TeamProblem
from cavalcade.geometry import CLEARANCE, transform_points
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.planner import SpaceTimePlanner
from cavalcade.world import OccupancyMap
from cavalcade.world.gaps import BORDER, CELLS, body_at, gap_between, nearest_obstacle, too_near
from cavalcade.world.occupancy import FREE, OCCUPIED

_KEPT = f"; at starts and goals bodies keep {1e3 * CLEARANCE:g} mm"


def infeasible(
    problem: TeamProblem, lattice: SpaceTimePlanner, deadline: Deadline
) -> tuple[str, tuple[int, ...]] | None:
    """Why there can be no plan, in one line, and the robots that it is about; None without a proof.

    Obstacles count as the shapes that they are, as far as these are known. The lattice's
    cost-to-go says what is connected; that is left out when the deadline has come.
    """
    cells, yaw = _cells(problem), problem.origin[2]
    for name, poses in (("start", problem.starts), ("goal", problem.goals)):
        bodies = [
            body_at(model, (*transform_points(cells.origin, [pose[:2]])[0], pose[2] + yaw))
            for model, pose in zip(problem.models, poses, strict=True)
        ]
        for k, body in enumerate(bodies):
            gap, what = nearest_obstacle(body, cells, problem.shapes)
            if too_near(gap):
                return f"the {name} of robot {k} {_fault(gap, what, cells)}", (k,)
        for i, j in combinations(range(len(bodies)), 2):
            gap = gap_between(bodies[i], bodies[j])
            if too_near(gap):
                apart = f"are {1e3 * gap:.2g} mm apart{_KEPT}" if gap > 0.0 else "overlap or touch"
                return f"the {name}s of robots {i} and {j} {apart}", (i, j)
    for k, (start, goal) in enumerate(zip(problem.starts, problem.goals, strict=True)):
        if deadline.late:
            break
        if not lattice.reachable(problem.models[k], np.array(start), np.array(goal)):
            return f"no way leads robot {k} to its goal, not even alone", (k,)
    return None


def _cells(problem: TeamProblem) -> OccupancyMap:
    """What is known as cells alone."""
    ground = problem.ground
    solid = ground.solid
    if ground.outlines.part.size:
        solid = solid & (ground.outlines.part < 0)
    grid = np.where(solid, np.int8(OCCUPIED), np.int8(FREE))
    return OccupancyMap(grid, ground.cell, problem.origin)


def _fault(gap: float, what: int, cells: OccupancyMap) -> str:
    if what == BORDER:
        thing = "the map's border"
    elif what == CELLS:
        thing = f"an occupied cell of the map ({cells.resolution:g} m wide)"
    else:
        thing = f"world.obstacles[{what}]"
    if gap > 0.0:
        return f"is {1e3 * gap:.2g} mm from {thing}{_KEPT}"
    return "is off the map or on its border" if what == BORDER else f"is in or touches {thing}"
