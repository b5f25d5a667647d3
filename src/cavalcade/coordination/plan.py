"""The front door of coordination: a problem and a method in, a plan or a reason out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from cavalcade.coordination.auto import solve_auto
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.course import Course
from cavalcade.coordination.feasibility import impossible
from cavalcade.coordination.found import Found
from cavalcade.coordination.joint import solve_joint, solve_merged
from cavalcade.coordination.prioritised import improved
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.published import DISTANCE, PublishedPlanner
from cavalcade.coordination.result import TeamPlan
from cavalcade.coordination.room import plan_with_room
from cavalcade.coordination.sequential import solve_sequential
from cavalcade.coordination.single import EFFORT, EvenPlanner, RobotPlanner
from cavalcade.coordination.uneven import UnevenPlanner, walkable
from cavalcade.coordination.warm import warm_up
from cavalcade.errors import InputError
from cavalcade.lattice.planner import TimedPlanner

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
        InputError: An unknown method, a budget of nothing, or robots without legs where only
            robots with legs can go.
    """
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}", key="planner.method", choices=METHODS)
    if seed < 0:
        raise InputError("expected 0 or more", key="seed")
    if not problem.models:
        raise InputError("expected at least one robot", key="robots")
    settings = settings or PlanSettings()

    def plan(problem: TeamProblem, settings: PlanSettings) -> TeamPlan:
        return _Call(problem, method, settings, seed).answer()

    return plan_with_room(problem, settings, plan) if settings.margin else plan(problem, settings)


class _Call:
    """One call of `plan_team`."""

    def __init__(
        self, problem: TeamProblem, method: str, settings: PlanSettings, seed: int
    ) -> None:
        self.problem, self.method, self.seed = problem, method, seed
        self.published = settings.variant == "published"
        if self.published and settings.distance is None:
            settings = replace(settings, distance=DISTANCE)
        self.settings = settings
        self.budget = Budget(settings.iterations, settings.seconds)  # refuses before it costs
        self.rng = np.random.default_rng(seed)
        legged = all(model.legs is not None for model in problem.models)
        if not legged and (self.published or not problem.ground.flat):
            where = "the published planner" if self.published else "uneven ground"
            raise InputError(f"{where} is for robots with legs", key="robots")
        warm_up(method != "sequential", self.published or not problem.ground.flat)
        self.budget = Budget(settings.iterations, settings.seconds)
        self.timed = TimedPlanner(problem.ground)
        self.planner = self._planner()

    def answer(self) -> TeamPlan:
        problem, budget = self.problem, self.budget
        proof = impossible(problem, self.timed)
        robots = range(len(problem.models))
        nothing: list[Course | None] = [None for _ in robots]
        if proof is not None:
            return self._team_plan("infeasible", proof.text, proof.robots, nothing)
        if self.method == "joint":
            # Its trees plan all robots at once; nobody is planned alone.
            together = self._joint()
            if together is None:
                text = f"no plan found in the product space; {budget}"
                return self._team_plan("budget", text, (), nothing)
            found = self._checked(Found(together, True, "joint"))
            return self._answered(found)
        refused = next(((k, why) for k in robots if (why := self.planner.refusal(k))), None)
        if refused is not None:
            text = f"robot {refused[0]}: {refused[1]}"
            return self._team_plan("infeasible", text, refused[:1], nothing)
        effort = (50 if self.settings.seconds is None else 5) * EFFORT
        alone = [self.planner.plan(k, (), budget, effort) for k in robots]
        lost = tuple(k for k in robots if alone[k] is None)
        if lost:
            for robot in lost:
                why = self.planner.refusal(robot)
                if why:
                    return self._team_plan("infeasible", f"robot {robot}: {why}", (robot,), alone)
            text = f"robot {lost[0]}: no way was found, not even alone; {budget}"
            return self._team_plan("budget", text, lost, alone)
        courses = tuple(course for course in alone if course is not None)
        found = self._checked(self._solve(courses))
        if found.solved and self.settings.improve and not self.published:
            found = self._improved(found, courses)
        return self._answered(found)

    def _answered(self, found: Found) -> TeamPlan:
        return self._team_plan(
            "solved" if found.solved else "budget",
            "" if found.solved else f"no plan without conflicts was found; {self.budget}",
            (),
            list(found.courses),
            found,
        )

    def _planner(self) -> RobotPlanner:
        if self.published:
            return PublishedPlanner(self.problem, self.settings, self.seed)
        if self.problem.ground.flat:
            return EvenPlanner(self.problem, self.timed)
        return UnevenPlanner(self.problem, self.settings, self.seed)

    def _joint(self) -> tuple[Course, ...] | None:
        timed = self.timed
        if not self.problem.ground.flat:
            ground = self.problem.ground
            for model in sorted(set(self.problem.models), key=lambda model: model.name):
                ground = walkable(ground, model)
            timed = TimedPlanner(ground)
        return solve_joint(self.problem, timed, self.budget, self.rng, not self.published)

    def _solve(self, alone: tuple[Course, ...]) -> Found:
        problem, planner, settings, budget = (
            self.problem,
            self.planner,
            self.settings,
            self.budget,
        )
        if self.method == "auto":
            together = partial(self._together, alone) if problem.ground.flat else None
            return solve_auto(problem, planner, settings, alone, budget, self.rng, together)
        if self.method == "sequential":
            return solve_sequential(problem, planner, settings, alone, budget)
        merge = None if self.published else self._pair
        return conflict_search(problem, planner, settings, alone, budget, merge=merge)

    def _checked(self, found: Found) -> Found:
        """What is called solved has no conflicts; if it has some after all, they are resolved."""
        tracks = [course.track for course in found.courses]
        distance = self.settings.distance
        if not found.solved or not conflicts_of(tracks, self.problem.models, 1, distance):
            return found
        return conflict_search(
            self.problem, self.planner, self.settings, found.courses, self.budget
        )

    def _together(self, alone: tuple[Course, ...], budget: Budget) -> tuple[Course, ...] | None:
        """The robots in conflict as one, and the others past them."""
        return solve_merged(self.problem, self.timed, self.planner, alone, budget, self.rng)

    def _pair(self, pair: tuple[int, int]) -> tuple[Course, ...] | None:
        """Two robots as one, regardless of the others."""
        if not self.problem.ground.flat:
            return None
        part = replace(
            self.problem,
            models=tuple(self.problem.models[k] for k in pair),
            starts=tuple(self.problem.starts[k] for k in pair),
            goals=tuple(self.problem.goals[k] for k in pair),
        )
        return solve_joint(part, self.timed, self.budget, self.rng)

    def _improved(self, found: Found, alone: tuple[Course, ...]) -> Found:
        """Robot by robot anew among the others, more patiently, until nothing gets cheaper."""
        planner = self.planner
        if isinstance(planner, EvenPlanner):
            planner = EvenPlanner(self.problem, TimedPlanner(self.problem.ground, greed=1.0))
        left = self.budget.left
        budget = Budget(self.settings.improve, None if left is None else max(left, 1e-3))
        team, courses = dict(enumerate(alone)), dict(enumerate(found.courses))
        history = [(self.budget.used, _total(courses))]
        while not budget.spent:
            better = improved(planner, courses, team, budget, rounds=1)
            if _total(better) > _total(courses) - 1e-6:
                break
            courses = better
            history.append((self.budget.used + budget.used, _total(courses)))
        self.budget.spend(budget.used)
        better_plan = tuple(courses[k] for k in range(len(alone)))
        if conflicts_of([course.track for course in better_plan], self.problem.models, 1):
            return found
        return replace(found, courses=better_plan, history=tuple(history))

    def _team_plan(
        self,
        reason: str,
        detail: str,
        involved: tuple[int, ...],
        courses: list[Course | None],
        found: Found | None = None,
    ) -> TeamPlan:
        ground = self.problem.ground
        return TeamPlan(
            reason,
            detail,
            involved,
            tuple(
                None if course is None else self.problem.in_map(course.trajectory(ground))
                for course in courses
            ),
            self.method if found is None else found.method or self.method,
            self.budget.used,
            self.budget.elapsed,
            {} if found is None else found.counts,
            () if found is None else found.history,
        )


def _total(courses: Mapping[int, Course]) -> float:
    return sum(course.cost for course in courses.values())
