"""Kernels are compiled or loaded before the clock of a plan starts, once in a process."""

from __future__ import annotations

import numpy as np

from cavalcade.coordination import _joint, _meeting
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.joint import solve_joint
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.single import EvenPlanner, spans_of
from cavalcade.coordination.uneven import UnevenPlanner
from cavalcade.eikonal import surface_distance
from cavalcade.kinodynamic import _search as trees
from cavalcade.kinodynamic.obstruction import find_way
from cavalcade.kinodynamic.parameters import make_body
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.ground import Ground, make_ground, read_only
from cavalcade.lattice.planner import TimedPlanner
from cavalcade.lattice.shortening import shorten
from cavalcade.lattice.surface import surface_along
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap


def warm_up(joint: bool, uneven: bool) -> None:
    """Use every kernel once on problems of a moment, unless this process has done so already.

    Args:
        joint: Those of the product space, too.
        uneven: Those of uneven ground, too.
    """
    if not shorten.signatures:
        _even()
    if joint and not _joint.search_joint.signatures:
        problem = _head_on()
        solve_joint(problem, TimedPlanner(problem.ground), Budget(10_000), np.random.default_rng(0))
    if uneven and not (trees.search.signatures and _meeting.first_meeting.signatures):
        _uneven()


def _even() -> None:
    problem = _head_on()
    planner = EvenPlanner(problem, TimedPlanner(problem.ground))
    budget = Budget(10_000)
    first = planner.plan(0, (), budget)
    if first is None:
        return
    second = planner.plan(1, spans_of([(0, first)]), budget)
    courses = [course for course in (first, second) if course is not None]
    conflicts_of([course.track for course in courses], problem.models[: len(courses)])
    for course in courses:
        course.trajectory(problem.ground)


def _uneven() -> None:
    """Two robots, one after the other, over a trench that asks for a leap."""
    ground = _trench()
    model = robot_model("spirit")
    starts, goals = ((1.0, 1.0, 0.0), (0.5, 2.0, 0.0)), ((3.5, 1.0, 0.0), (3.5, 2.0, 0.0))
    problem = TeamProblem(ground, (model, model), starts, goals)
    planner = UnevenPlanner(problem, PlanSettings(), 0)
    first = planner.plan(0, (), Budget(10_000))
    if first is not None:
        planner.plan(1, spans_of([(0, first)]), Budget(10_000))
    published = BodySettings(iterations=300, variant="published", discs=np.zeros((1, 3)))
    plan_body(ground, model, starts[0], goals[0], published, 0)
    # Round a wall, so that ways on the grid are looked for.
    ground.solid[25:, 52:55] = True
    ground = ground._replace(clearance=surface_distance(ground.solid, ground.cell))
    plan_body(ground, model, starts[1], goals[1], BodySettings(iterations=300, improve=50), 0)
    surface_along(read_only(ground), np.zeros((1, 2)))
    find_way(ground, make_body(model, False, 0.01), np.zeros((0, 3)), True, starts[1], goals[1])


def _head_on() -> TeamProblem:
    model = robot_model("spirit")
    starts, goals = ((0.6, 1.5, 0.0), (3.4, 1.5, np.pi)), ((3.4, 1.5, 0.0), (0.6, 1.5, np.pi))
    ground = make_ground(OccupancyMap.empty((4.0, 3.0)))
    return TeamProblem(ground, (model, model), starts, goals)


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
