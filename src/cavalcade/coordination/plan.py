"""The front door of coordination: a problem and a method in, a plan or a reason out."""

from __future__ import annotations

import numpy as np

from cavalcade.body.timed import TimedPlanner
from cavalcade.coordination.auto import Found, solve_auto
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.course import Course
from cavalcade.coordination.feasibility import impossible
from cavalcade.coordination.prioritised import in_order
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.result import TeamPlan
from cavalcade.coordination.single import EFFORT, EvenPlanner, RobotPlanner
from cavalcade.errors import InputError

METHODS = ("auto", "sequential", "joint", "cbs")


def plan_team(
    problem: TeamProblem,
    method: str = "auto",
    settings: PlanSettings | None = None,
    seed: int = 0,
) -> TeamPlan:
    """Plan a team whose robots have goals of their own.

    Args:
        problem: Ground, robots, starts and goals.
        method: `auto`, `sequential`, `joint` or `cbs`.
        settings: Options and budget.
        seed: Of everything that is drawn.

    Returns:
        A plan, or why there is none. Trajectories are in the map's frame.

    Raises:
        InputError: An unknown method, or a budget of nothing.
    """
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}", key="planner.method", choices=METHODS)
    settings = settings or PlanSettings()
    budget = Budget(settings.iterations, settings.seconds)
    timed = TimedPlanner(problem.ground)
    proof = impossible(problem, timed)
    none = (None,) * len(problem.models)
    if proof is not None:
        return TeamPlan(
            "infeasible", proof.text, proof.robots, none, method, budget.used, budget.elapsed
        )
    planner = EvenPlanner(problem, timed)
    alone = [planner.plan(k, (), budget, 50 * EFFORT) for k in range(len(problem.models))]
    lost = tuple(k for k, course in enumerate(alone) if course is None)
    if lost:
        text = f"no way found for robot {lost[0]}, not even alone; {budget}"
        known = tuple(None if c is None else problem.in_map(c.trajectory(problem.ground)) for c in alone)
        return TeamPlan("budget", text, lost, known, method, budget.used, budget.elapsed)
    courses = tuple(course for course in alone if course is not None)
    rng = np.random.default_rng(seed)
    found = _solve(method, problem, planner, settings, courses, budget, rng)
    return TeamPlan(
        "solved" if found.solved else "budget",
        "" if found.solved else f"no plan without conflicts found; {budget}",
        (),
        tuple(problem.in_map(course.trajectory(problem.ground)) for course in found.courses),
        method if found.method == "alone" else found.method,
        budget.used,
        budget.elapsed,
        found.counts,
    )


def _solve(
    method: str,
    problem: TeamProblem,
    planner: RobotPlanner,
    settings: PlanSettings,
    alone: tuple[Course, ...],
    budget: Budget,
    rng: np.random.Generator,
) -> Found:
    if method == "auto":
        return solve_auto(problem, planner, settings, alone, budget, rng)
    if method == "sequential":
        order = range(len(alone))
        for leave in (0.0, 3.0):
            courses, failed = in_order(planner, order, budget, None, dict(enumerate(alone)), leave)
            if failed is None:
                return Found(tuple(courses[k] for k in order), True, method)
        # Its Algorithm 2 goes on: conflicts are resolved by constraints on either robot.
        rest = tuple(courses.get(k, alone[k]) for k in order)
        outcome = conflict_search(problem, planner, settings, rest, budget)
    else:
        outcome = conflict_search(problem, planner, settings, alone, budget)
    return Found(outcome.courses, outcome.solved, method, {"conflict_nodes": outcome.nodes})
