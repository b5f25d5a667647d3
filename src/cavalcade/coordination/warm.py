"""Kernels are compiled or loaded before the clock of a plan starts, once in a process."""

from __future__ import annotations

from functools import cache

import numpy as np

from cavalcade import lattice
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.feasibility import infeasible
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.robot_planner import spans_of
from cavalcade.coordination.terrain import TerrainPlanner
from cavalcade.kinodynamic import warming
from cavalcade.lattice.collision import place_free, pose_free
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.ground import read_only
from cavalcade.lattice.motion_limits import footprint
from cavalcade.lattice.planner import NOBODY, SpaceTimePlanner
from cavalcade.lattice.surface import surface_along
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

_STARTS = ((0.6, 1.5, 0.0), (3.4, 1.5, np.pi))


def warm_up(terrain: bool) -> None:
    """Use every kernel once on problems of a moment, unless this process has done so already.

    Those of uneven ground (`terrain`) only if asked for, those of the product space when they are
    first used (`coordination.joint`): few plans need them.
    """
    _on_a_floor()
    if terrain:
        warming.warm_up()
        _over_a_trench()


@cache
def _on_a_floor() -> None:
    problem = TeamProblem.on_map(
        OccupancyMap.empty((4.0, 3.0)), ("spirit", "spirit"), _STARTS, _STARTS[::-1]
    )
    planner = SpaceTimePlanner(problem.ground)
    shape, track = footprint(problem.models[0]), np.array([_STARTS[0]])
    lattice.warm_up()
    infeasible(problem, planner, Deadline())
    pose_free(planner.grid, shape, *_STARTS[0], 0.0)
    place_free(NOBODY, shape, _STARTS[0], 0.0, 0.0)
    conflicts_of([track, track], problem.models)


@cache
def _over_a_trench() -> None:
    """Two robots, one after the other, over a trench that asks for a leap."""
    ground, model = warming.trench(), robot_model("spirit")
    starts, goals = ((1.0, 1.0, 0.0), (0.5, 2.0, 0.0)), ((3.5, 1.0, 0.0), (3.5, 2.0, 0.0))
    planner = TerrainPlanner(TeamProblem(ground, (model, model), starts, goals), PlanSettings(), 0)
    first = planner.plan(0, (), Budget(10_000))
    if first is not None:
        planner.plan(1, spans_of([(0, first)]), Budget(10_000))
    surface_along(read_only(ground), np.zeros((2, 6))[:, :2])  # not contiguous
