"""One robot among others: the planner that coordinators call, one robot at a time."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.problem import PlanSettings, TeamProblem
from cavalcade.coordination.solution import Paths, RobotPath
from cavalcade.geometry import Array
from cavalcade.kinodynamic import BodyPlan, BodySettings, plan_body
from cavalcade.lattice.collision import Margins, Others, move_free, place_free, pose_free
from cavalcade.lattice.leads import has_room, lead_free, lead_from
from cavalcade.lattice.motion_limits import footprint
from cavalcade.lattice.planner import (
    FOOTING,
    MARGINS,
    NOBODY,
    TRACK_STEP,
    SpaceTimePlanner,
    TimedPath,
    others_of,
)
from cavalcade.lattice.primitives import DURATION

EFFORT = 20_000
"""Expansions that one call may take; more are tried only where everything else has failed."""

_CRAMPED = 50
"""A search that ends within so few expansions was shut in: the margins are what is too large."""

_LEAST = (
    MARGINS[-1]._replace(others=MARGINS[-2].others, time_step=MARGINS[-2].time_step),
    MARGINS[-1],
)
"""For starts and goals that keep no others; near to the ground alone, robots keep off each other
as ever: less would count as a conflict."""

_LATE = 1e9
"""When everybody stands for good, s."""


class Span(NamedTuple):
    """What a robot has to avoid: a track of another robot while it lasts.

    Attributes:
        robot: The other robot.
        track: Its poses `(K, 3)` every `TRACK_STEP` s; it stands at the last for good.
        begin, end: s.
        scale: Of its body's length and width: a smaller one asks for less space than it needs.
    """

    robot: int
    track: Array
    begin: float = 0.0
    end: float = math.inf
    scale: float = 1.0


@dataclass(frozen=True, eq=False)
class RobotPlanner(ABC):
    """Plans one robot of the team at a time."""

    problem: TeamProblem

    @abstractmethod
    def plan(
        self, robot: int, spans: Sequence[Span], budget: Budget, effort: int = EFFORT
    ) -> RobotPath | None:
        """The cheapest path found that avoids all spans; None if there is none.

        At most `effort` iterations are used and taken from the budget.
        """

    def delayed(
        self, robot: int, spans: Sequence[Span], delay: float, budget: Budget
    ) -> RobotPath | None:
        """The same, standing at the start for `delay` s first; None of robots that never wait."""
        return None

    def standing(self, robot: int) -> Array:
        """The track `(1, 3)` of a robot that stays at its start."""
        return np.array(self.problem.starts[robot])[None]

    def refusal(self, robot: int) -> str:
        """A proof, found on the way, that the robot has no path even alone; else empty."""
        return ""


@dataclass(frozen=True, eq=False)
class FlatPlanner(RobotPlanner):
    """Robots of any kind on ground that is even, or walked on as if it were."""

    lattice: SpaceTimePlanner

    def plan(
        self, robot: int, spans: Sequence[Span], budget: Budget, effort: int = EFFORT
    ) -> RobotPath | None:
        """See `RobotPlanner`."""
        others = others_among(self.problem, spans)
        levels = self._levels(robot, others)
        if not self._has_room(robot, levels[-1]):
            for margins in levels:
                path = self._search(robot, others, margins, budget, min(effort, EFFORT))
                path = path or self._led(robot, others, margins, budget)
                if path is not None:
                    return RobotPath(path, path.cost)
                if budget.spent:
                    return None
            if effort <= EFFORT:
                return None
        for margins in levels:
            before = budget.used
            path = self._search(robot, others, margins, budget, effort)
            if path is not None:
                return RobotPath(path, path.cost)
            if budget.spent or (margins is MARGINS[1] and budget.used - before > _CRAMPED):
                break
        return None

    def delayed(
        self, robot: int, spans: Sequence[Span], delay: float, budget: Budget
    ) -> RobotPath | None:
        """See `RobotPlanner`."""
        others = others_among(self.problem, spans)
        skip = round(delay / TRACK_STEP)
        delay = skip * TRACK_STEP
        levels = self._levels(robot, others)
        scene = self.lattice.scene(self.problem.models[robot], others, levels[-1])
        stand = np.zeros(6)
        stand[DURATION] = delay
        if not move_free(scene, self.problem.starts[robot], stand, 0.0, True):
            return None
        later = _later(others, skip)
        for margins in levels:
            path = self._search(robot, later, margins, budget, EFFORT)
            if path is not None:
                path = replace(path, moves=np.concatenate([stand[None], path.moves]))
                return RobotPath(path, path.cost)
        return None

    def _levels(self, robot: int, others: Others) -> list[Margins]:
        """The margins that start and goal keep; the least only where they keep no others."""
        kept = [m for m in MARGINS[:-1] if self._keeps(robot, others, m)]
        kept = kept or [next((m for m in _LEAST if self._keeps(robot, others, m)), MARGINS[-1])]
        return kept if self.problem.ground.flat else [*kept, FOOTING]

    def _keeps(self, robot: int, others: Others, margins: Margins) -> bool:
        """Whether start and goal keep the margins: otherwise no search with them can end well."""
        shape, grid = footprint(self.problem.models[robot]), self.lattice.grid
        for pose, time in ((self.problem.starts[robot], 0.0), (self.problem.goals[robot], _LATE)):
            if not pose_free(grid, shape, *pose, margins.ground):
                return False
            if not place_free(others, shape, pose, time, margins.others):
                return False
        return True

    def _search(
        self, robot: int, others: Others, margins: Margins, budget: Budget, effort: int
    ) -> TimedPath | None:
        problem = self.problem
        ends = np.array(problem.starts[robot]), np.array(problem.goals[robot])
        return self._between(robot, ends, others, margins, budget, effort)

    def _between(
        self,
        robot: int,
        ends: tuple[Array, Array],
        others: Others,
        margins: Margins,
        budget: Budget,
        effort: int,
    ) -> TimedPath | None:
        path, _, expansions = self.lattice.plan(
            self.problem.models[robot], *ends, others, budget.most(effort), margins, budget.deadline
        )
        budget.spend(expansions)
        return path

    def _has_room(self, robot: int, margins: Margins) -> bool:
        """Whether the robot can turn at its start and at its goal, others aside."""
        scene = self.lattice.scene(self.problem.models[robot], NOBODY, margins)
        ends = self.problem.starts[robot], self.problem.goals[robot]
        return all(has_room(scene, np.array(pose)) for pose in ends)

    def _led(
        self, robot: int, others: Others, margins: Margins, budget: Budget
    ) -> TimedPath | None:
        """A path that leads out of the start and into the goal where there is no room to turn."""
        problem = self.problem
        scene = self.lattice.scene(problem.models[robot], others, margins)
        alone = scene._replace(others=NOBODY)
        start, goal = np.array(problem.starts[robot]), np.array(problem.goals[robot])
        out, begin = lead_from(alone, start, 1.0)
        into, end = lead_from(alone, goal, -1.0)
        if not len(out) and not len(into):
            return None
        # The search's clock starts at a sample of the others' tracks.
        skip = math.ceil(float(out[:, DURATION].sum()) / TRACK_STEP)
        wait = np.zeros((1, 6))
        wait[0, DURATION] = skip * TRACK_STEP - out[:, DURATION].sum()
        first = np.concatenate([out, wait])
        later = _later(others, skip)
        path = self._between(robot, (begin, end), later, margins, budget, EFFORT)
        if path is None:
            return None
        stand = np.zeros((1, 6))
        stand[0, DURATION] = others.tracks.shape[1] * others.step
        last = np.concatenate([into, stand])
        if not lead_free(scene, start, first, 0.0):
            return None
        if not lead_free(scene, end, last, skip * TRACK_STEP + path.duration):
            return None
        led = replace(path, start=start, moves=np.concatenate([first, path.moves, into]))
        return self.lattice.shortened(led, others, margins, budget.deadline)


@dataclass(frozen=True, eq=False)
class TeamSearch:
    """What the methods for a whole team start from.

    Attributes:
        lattice: Whose ground, limits and costs the product space is searched with.
        alone: Each robot's path regardless of the others.
        budget: What is used is taken from it.
        rng: Draws orders, and seeds the trees of the product space.
    """

    planner: RobotPlanner
    lattice: SpaceTimePlanner
    settings: PlanSettings
    alone: Paths
    budget: Budget
    rng: np.random.Generator


def planned_by_trees(
    problem: TeamProblem, robot: int, settings: BodySettings, seed: int, budget: Budget
) -> BodyPlan:
    """What the body planner answers for one robot; its iterations are taken from the budget."""
    start, goal = problem.starts[robot], problem.goals[robot]
    answer = plan_body(problem.ground, problem.models[robot], start, goal, settings, seed)
    budget.spend(answer.iterations)
    return answer


def others_among(problem: TeamProblem, spans: Sequence[Span]) -> Others:
    """What is to be avoided, as kernels take it."""
    if not spans:
        return NOBODY
    models = [problem.models[span.robot] for span in spans]
    rows = [(k, span.begin, span.end) for k, span in enumerate(spans)]
    others = others_of([span.track for span in spans], models, rows)
    others.shapes[:, :2] *= np.array([span.scale for span in spans])[:, None]
    return others


def spans_of(paths: Iterable[tuple[int, RobotPath]]) -> list[Span]:
    """The whole paths of other robots, to be avoided from the start and for good."""
    return [Span(robot, path.track) for robot, path in paths]


def _later(others: Others, skip: int) -> Others:
    """The others as seen by a clock that starts `skip` steps later."""
    if not len(others.spans):
        return others
    first = min(skip, others.tracks.shape[1] - 1)
    spans = others.spans.copy()
    spans[:, 1:] -= skip * others.step
    return others._replace(tracks=np.ascontiguousarray(others.tracks[:, first:]), spans=spans)
