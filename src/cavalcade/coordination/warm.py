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
from cavalcade.kinodynamic import warming
from cavalcade.lattice.ground import make_ground, read_only
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
    if uneven:
        warming.warm_up()
        if not _meeting.first_meeting.signatures:
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
    ground, model = warming.trench(), robot_model("spirit")
    starts, goals = ((1.0, 1.0, 0.0), (0.5, 2.0, 0.0)), ((3.5, 1.0, 0.0), (3.5, 2.0, 0.0))
    problem = TeamProblem(ground, (model, model), starts, goals)
    planner = UnevenPlanner(problem, PlanSettings(), 0)
    first = planner.plan(0, (), Budget(10_000))
    if first is not None:
        planner.plan(1, spans_of([(0, first)]), Budget(10_000))
    surface_along(read_only(ground), np.zeros((1, 2)))


def _head_on() -> TeamProblem:
    model = robot_model("spirit")
    starts, goals = ((0.6, 1.5, 0.0), (3.4, 1.5, np.pi)), ((3.4, 1.5, 0.0), (0.6, 1.5, np.pi))
    ground = make_ground(OccupancyMap.empty((4.0, 3.0)))
    return TeamProblem(ground, (model, model), starts, goals)
