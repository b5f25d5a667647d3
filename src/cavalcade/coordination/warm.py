"""Kernels are compiled or loaded before the clock of a plan starts, once in a process."""

from __future__ import annotations

import numpy as np

from cavalcade import lattice
from cavalcade.coordination._conflicts import find_conflicts, first_conflict
from cavalcade.coordination._joint import search_joint
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.feasibility import infeasible
from cavalcade.coordination.joint import solve_joint
from cavalcade.coordination.problem import TeamProblem
from cavalcade.eikonal import surface_distance
from cavalcade.kinodynamic.obstruction import find_way
from cavalcade.kinodynamic.parameters import make_body
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.collision import place_free
from cavalcade.lattice.ground import Ground, read_only
from cavalcade.lattice.motion_limits import footprint
from cavalcade.lattice.planner import NOBODY, SpaceTimePlanner
from cavalcade.lattice.surface import surface_along
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

_STARTS = ((0.6, 1.5, 0.0), (3.4, 1.5, np.pi))


def warm_up(joint: bool, terrain: bool) -> None:
    """Use every kernel once on problems of a moment, unless this process has done so already.

    Args:
        joint: Those of the product space, too.
        terrain: Those of uneven ground, too.
    """
    problem = TeamProblem.on_map(
        OccupancyMap.empty((4.0, 3.0)), ("spirit", "spirit"), _STARTS, _STARTS[::-1]
    )
    planner = SpaceTimePlanner(problem.ground)
    shape, track = footprint(problem.models[0]), np.array([_STARTS[0]])
    if not find_conflicts.signatures:
        lattice.warm_up()
        infeasible(problem, planner)
        place_free(NOBODY, shape, _STARTS[0], 0.0, 0.0)
        conflicts_of([track, track], problem.models)
    if joint and not search_joint.signatures:
        solve_joint(problem, planner, Budget(10_000), np.random.default_rng(0))
    if terrain and not first_conflict.signatures:
        _trees()
        surface_along(read_only(problem.ground), np.zeros((2, 6))[:, :2])  # not contiguous
        first_conflict(NOBODY, shape, track, 0.0, 0.0, 1.0)


def _trees() -> None:
    """The body planner's kernels, over a trench that asks for a leap and round a wall."""
    ground, model = _trench(), robot_model("spirit")
    starts, goals = ((1.0, 1.0, 0.0), (0.5, 2.0, 0.0)), ((3.5, 1.0, 0.0), (3.5, 2.0, 0.0))
    for settings in (
        BodySettings(iterations=300),
        BodySettings(iterations=300, variant="published", discs=np.zeros((1, 3))),
    ):
        plan_body(ground, model, starts[0], goals[0], settings, 0)
    ground.solid[25:, 52:55] = True
    ground = ground._replace(clearance=surface_distance(ground.solid, ground.cell))
    plan_body(ground, model, starts[1], goals[1], BodySettings(iterations=300, improve=50), 0)
    find_way(ground, make_body(model, False, 0.01), np.zeros((0, 3)), True, starts[1], goals[1])


def _trench() -> Ground:
    rows, cols, cell = 60, 90, 0.05
    y, x = (np.arange(rows) + 0.5) * cell, (np.arange(cols) + 0.5) * cell
    near_y, near_x = np.minimum(y, rows * cell - y), np.minimum(x, cols * cell - x)
    near = np.minimum(near_y[:, None], near_x[None])
    solid = np.zeros((rows, cols), dtype=bool)
    height, level = np.zeros((rows, cols)), np.zeros((rows, cols))
    ground = Ground(cell, solid, near, False, height, level, level, level, np.ones((rows, cols)))
    ground.height[:, 40:46] = -1.0
    ground.traversability[:, 39:47] = 0.0
    ground.solid[0, 0] = True
    return ground
