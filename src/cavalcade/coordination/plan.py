"""The front door of coordination: a problem and a method in, a plan or a reason out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from cavalcade.coordination.auto import solve_auto
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.feasibility import infeasible
from cavalcade.coordination.joint import solve_joint
from cavalcade.coordination.prioritised import improved, solve_sequential
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.published import DISTANCE, PublishedPlanner
from cavalcade.coordination.result import TeamPlan
from cavalcade.coordination.robot_planner import EFFORT, FlatPlanner, RobotPlanner, TeamSearch
from cavalcade.coordination.solution import Paths, RobotPath, Solution, total_cost
from cavalcade.coordination.terrain import TerrainPlanner, walkable
from cavalcade.coordination.warm import warm_up
from cavalcade.errors import InputError
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.planner import SpaceTimePlanner
from cavalcade.robots import RobotModel
from cavalcade.values import described, instance_of, whole_number

METHODS = ("auto", "sequential", "joint", "cbs")

_SMALLEST = 0.2
"""A margin less than this part of what was asked for is none."""

_SHARE = 0.5
"""Part of the iterations that are left for a search with margins, of which there may be another."""

_ALONE = 50 * EFFORT
"""Iterations that the search for a robot's path regardless of the others may take."""


def plan_team(
    problem: TeamProblem,
    method: str = "auto",
    settings: PlanSettings | None = None,
    seed: int = 0,
    cancelled: Callable[[], bool] | None = None,
) -> TeamPlan:
    """Plan a team whose robots have goals of their own.

    Args:
        problem: Ground, robots, starts and goals.
        method: `auto`, `sequential`, `joint` or `cbs`.
        settings: Options and budget.
        seed: Of all random numbers.
        cancelled: Asked now and then, from this thread, whether the plan is still wanted; if it is
            not, the answer comes soon: that the budget is spent.

    Returns:
        A plan, or why there is none. Trajectories are in the map's frame.

    Raises:
        InputError: An unknown method, a budget of nothing, or robots without legs where only
            robots with legs can go.
    """
    if not isinstance(method, str) or method not in METHODS:
        raise InputError(
            f"unknown method {described(method)}", key="planner.method", choices=METHODS
        )
    seed = whole_number(seed, "seed", 0)
    instance_of(problem, TeamProblem, "problem")
    if not problem.models:
        raise InputError("expected at least one robot", key="robots")
    settings = PlanSettings() if settings is None else settings
    instance_of(settings, PlanSettings, "settings")
    published = settings.variant == "published"
    legged = all(model.legs is not None for model in problem.models)
    if not legged and (published or not problem.ground.flat):
        where = "the published planner" if published else "uneven ground"
        raise InputError(f"{where} is for robots with legs", key="robots")
    Budget(settings.iterations, Deadline(settings.seconds))  # refuses before it costs
    warm_up(published or not problem.ground.flat)
    budget = Budget(settings.iterations, Deadline(settings.seconds, cancelled))
    if not settings.margin:
        return _Call(problem, method, settings, seed, budget).answer()
    return _plan_inflated(problem, method, settings, seed, budget)


def _plan_inflated(
    problem: TeamProblem, method: str, settings: PlanSettings, seed: int, budget: Budget
) -> TeamPlan:
    """The plan for bodies that are inflated by `settings.margin`, or by less where that has none.

    Robots do not go exactly where they are sent. Where start, goal or ground leave a robot no space
    for its margin, that is halved, then given up; where the search finds nothing, those of all are.
    """
    margins = [settings.margin] * len(problem.models)
    while True:
        inflating = any(margins)
        share = budget.share(_SHARE if inflating else 1.0)
        larger = replace(problem, models=tuple(map(inflated, problem.models, margins)))
        answer = _Call(larger, method, settings, seed, share).answer()
        budget.spend(answer.iterations)
        refused = answer.reason == "infeasible"
        tight = [k for k in answer.involved if margins[k]] if refused else range(len(margins))
        if answer.solved or not inflating or not tight or budget.deadline.late:
            return replace(answer, iterations=budget.used, margins=tuple(margins))
        for k in tight:
            half = 0.5 * margins[k]
            margins[k] = half if half >= _SMALLEST * settings.margin else 0.0


def inflated(model: RobotModel, margin: float) -> RobotModel:
    """The robot with a footprint that is `margin` m wider on all sides."""
    if not margin:
        return model
    return model.with_limits(length=model.length + 2.0 * margin, width=model.width + 2.0 * margin)


class _Call:
    """One problem, planned once."""

    def __init__(
        self, problem: TeamProblem, method: str, settings: PlanSettings, seed: int, budget: Budget
    ) -> None:
        self.problem, self.method = problem, method
        self.published = settings.variant == "published"
        if self.published and settings.distance is None:
            settings = replace(settings, distance=DISTANCE)
        self.settings = settings
        self.budget = budget
        self.rng = np.random.default_rng(seed)
        self.lattice = SpaceTimePlanner(problem.ground)
        self.planner: RobotPlanner
        if self.published:
            self.planner = PublishedPlanner(problem, settings, seed)
        elif problem.ground.flat:
            self.planner = FlatPlanner(problem, self.lattice)
        else:
            self.planner = TerrainPlanner(problem, settings, seed)

    def answer(self) -> TeamPlan:
        budget, planner = self.budget, self.planner
        proof = infeasible(self.problem, self.lattice, budget.deadline)
        if proof is not None:
            return self._team_plan("infeasible", *proof)
        if self.method == "joint":
            # Its trees plan all robots at once; nobody is planned alone.
            together = self._joint()
            if together is None:
                return self._team_plan("budget", f"no plan found in the product space; {budget}")
            return self._answered(self._checked(Solution(together, True, "joint")))
        robots = range(len(self.problem.models))
        for robot in robots:
            if why := planner.refusal(robot):
                return self._team_plan("infeasible", f"robot {robot}: {why}", (robot,))
        alone = [planner.plan(k, (), budget, _ALONE) for k in robots]
        lost = tuple(k for k in robots if alone[k] is None)
        for robot in lost:
            if why := planner.refusal(robot):
                return self._team_plan("infeasible", f"robot {robot}: {why}", (robot,), alone)
        if lost:
            text = f"robot {lost[0]}: no way was found, not even alone; {budget}"
            return self._team_plan("budget", text, lost, alone)
        search = self._search(tuple(path for path in alone if path is not None))
        solution = self._checked(self._solve(search))
        if solution.solved and self.settings.improve and not self.published:
            solution = self._improved(solution, search)
        return self._answered(solution)

    def _answered(self, solution: Solution) -> TeamPlan:
        text = "" if solution.solved else f"no plan without conflicts was found; {self.budget}"
        reason = "solved" if solution.solved else "budget"
        return self._team_plan(reason, text, (), solution.paths, solution)

    def _search(self, paths: Paths) -> TeamSearch:
        return TeamSearch(self.planner, self.lattice, self.settings, paths, self.budget, self.rng)

    def _joint(self) -> Paths | None:
        lattice = self.lattice
        if not self.problem.ground.flat:
            ground = self.problem.ground
            for model in sorted(set(self.problem.models), key=lambda model: model.name):
                ground = walkable(ground, model)
            lattice = SpaceTimePlanner(ground)
        return solve_joint(self.problem, lattice, self.budget, self.rng, not self.published)

    def _solve(self, search: TeamSearch) -> Solution:
        if self.method == "auto":
            return solve_auto(search)
        if self.method == "sequential":
            return solve_sequential(search)
        merging = self.problem.ground.flat and not self.published
        return conflict_search(search, search.alone, merging)

    def _checked(self, solution: Solution) -> Solution:
        """What is called solved has no conflicts; if it has some after all, they are resolved."""
        tracks = [path.track for path in solution.paths]
        distance = self.settings.distance
        if not solution.solved or not conflicts_of(tracks, self.problem.models, 1, distance):
            return solution
        return conflict_search(self._search(solution.paths), solution.paths)

    def _improved(self, solution: Solution, search: TeamSearch) -> Solution:
        """Robot by robot anew among the others, more patiently, until nothing gets cheaper."""
        planner = self.planner
        if isinstance(planner, FlatPlanner):
            planner = FlatPlanner(self.problem, SpaceTimePlanner(self.problem.ground, weight=1.0))
        budget = Budget(self.settings.improve, self.budget.deadline)
        search = replace(search, planner=planner, budget=budget)
        paths = solution.paths
        history = [(self.budget.used, total_cost(paths))]
        while not budget.spent:
            better = improved(search, paths, rounds=1)
            if total_cost(better) > total_cost(paths) - 1e-6:
                break
            paths = better
            history.append((self.budget.used + budget.used, total_cost(paths)))
        self.budget.spend(budget.used)
        if conflicts_of([path.track for path in paths], self.problem.models, 1):
            return solution
        return replace(solution, paths=paths, history=tuple(history))

    def _team_plan(
        self,
        reason: str,
        detail: str,
        involved: tuple[int, ...] = (),
        paths: Sequence[RobotPath | None] | None = None,
        solution: Solution | None = None,
    ) -> TeamPlan:
        ground = self.problem.ground
        return TeamPlan(
            reason,
            detail,
            involved,
            tuple(
                None if path is None else self.problem.in_map(path.trajectory(ground))
                for path in paths or [None] * len(self.problem.models)
            ),
            self.method if solution is None else solution.method or self.method,
            self.budget.used,
            self.budget.deadline.elapsed,
            {} if solution is None else solution.counts,
            () if solution is None else solution.history,
        )
