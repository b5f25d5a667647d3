"""One robot among others: the planner that coordinators call, one robot at a time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.course import Course
from cavalcade.coordination.problem import TeamProblem
from cavalcade.geometry import Array
from cavalcade.lattice.collision import move_free, place_free, pose_free
from cavalcade.lattice.planner import (
    CAREFUL,
    NOBODY,
    TRACK_STEP,
    Care,
    Others,
    TimedPlanner,
    Way,
    others_of,
)
from cavalcade.lattice.primitives import DURATION

EFFORT = 20_000
"""Expansions that one call may take; more are tried only where everything else has failed."""


_CRAMPED = 50
"""A search that ends within so few expansions was shut in: the margins are what is too large."""


_LATE = 1e9
"""When everybody stands for good, s."""


class Span(NamedTuple):
    """What a robot has to avoid: a track of another robot while it lasts.

    Attributes:
        robot: The other robot.
        track: Its poses `(K, 3)` every `TRACK_STEP` s; it stands at the last for good.
        begin, end: s.
        scale: Of its body's length and width: a smaller one asks for less room than it needs.
    """

    robot: int
    track: Array
    begin: float = 0.0
    end: float = math.inf
    scale: float = 1.0


class RobotPlanner(Protocol):
    """Plans one robot of the team at a time."""

    def plan(
        self, robot: int, spans: Sequence[Span], budget: Budget, effort: int = EFFORT
    ) -> Course | None:
        """The cheapest course found that avoids all spans; None if there is none.

        Args:
            robot: Which one.
            spans: What to avoid.
            budget: What is used is taken from it.
            effort: Iterations at most.
        """

    def delayed(
        self, robot: int, spans: Sequence[Span], delay: float, budget: Budget
    ) -> Course | None:
        """The same, standing at the start for `delay` s first."""

    def standing(self, robot: int) -> Array:
        """The track `(1, 3)` of a robot that stays at its start."""

    def refusal(self, robot: int) -> str:
        """A proof, found on the way, that the robot has no way even alone; else empty."""


@dataclass(frozen=True)
class EvenPlanner:
    """Robots of any kind on ground that is even, or walked on as if it were.

    Attributes:
        problem: The team's.
        timed: The search.
    """

    problem: TeamProblem
    timed: TimedPlanner

    def plan(
        self, robot: int, spans: Sequence[Span], budget: Budget, effort: int = EFFORT
    ) -> Course | None:
        """See `RobotPlanner`."""
        others = others_among(self.problem, spans)
        for care in CAREFUL:
            if care is not CAREFUL[-1] and not self._roomy(robot, others, care):
                continue
            before = budget.used
            way = self._search(robot, others, care, budget, effort)
            if way is not None:
                return Course(way, self.timed.cost(way))
            if budget.spent or (care is CAREFUL[1] and budget.used - before > _CRAMPED):
                break
        return None

    def delayed(
        self, robot: int, spans: Sequence[Span], delay: float, budget: Budget
    ) -> Course | None:
        """See `RobotPlanner`."""
        others = others_among(self.problem, spans)
        skip = round(delay / TRACK_STEP)
        delay = skip * TRACK_STEP
        model = self.problem.models[robot]
        x, y, yaw = self.problem.starts[robot]
        stand = np.zeros(6)
        stand[DURATION] = delay
        care = CAREFUL[-1]
        if not move_free(
            self.timed.grid,
            tuple(others),
            x,
            y,
            yaw,
            stand,
            self.timed.mover(model),
            0.0,
            np.array([care.ground, care.others]),
            np.array(care.steps),
            True,
        ):
            return None
        later = _later(others, skip)
        for care in CAREFUL:
            way = self._search(robot, later, care, budget, EFFORT)
            if way is not None:
                moves = np.concatenate([stand[None], way.moves])
                way = Way(way.start, moves, way.mover, way.model)
                return Course(way, self.timed.cost(way))
        return None

    def standing(self, robot: int) -> Array:
        """See `RobotPlanner`."""
        return np.array(self.problem.starts[robot], dtype=float)[None]

    def _roomy(self, robot: int, others: Others, care: Care) -> bool:
        """Whether start and goal keep the margins: otherwise no search with them can end well."""
        model = self.problem.models[robot]
        mover, grid = self.timed.mover(model), self.timed.grid
        shape = (model.length / 2.0, model.width / 2.0, float(model.round))
        for pose, time in ((self.problem.starts[robot], 0.0), (self.problem.goals[robot], _LATE)):
            if not pose_free(grid, *pose, *shape, care.ground):
                return False
            if not place_free(tuple(others), *pose, mover, time, care.others):
                return False
        return True

    def _search(
        self, robot: int, others: Others, care: Care, budget: Budget, effort: int
    ) -> Way | None:
        problem = self.problem
        way, _, expansions = self.timed.plan(
            problem.models[robot],
            np.array(problem.starts[robot], dtype=float),
            np.array(problem.goals[robot], dtype=float),
            others,
            budget.most(effort),
            care,
        )
        budget.spend(expansions)
        return way

    def refusal(self, robot: int) -> str:
        """See `RobotPlanner`."""
        return ""


def others_among(problem: TeamProblem, spans: Sequence[Span]) -> Others:
    """What is to be avoided, as kernels take it."""
    if not spans:
        return NOBODY
    models = [problem.models[span.robot] for span in spans]
    rows = [(k, span.begin, span.end) for k, span in enumerate(spans)]
    others = others_of([span.track for span in spans], models, rows)
    others.shapes[:, :2] *= np.array([span.scale for span in spans])[:, None]
    return others


def spans_of(courses: Iterable[tuple[int, Course]]) -> list[Span]:
    """The whole courses of other robots, to be avoided from the start and for good."""
    return [Span(robot, course.track) for robot, course in courses]


def _later(others: Others, skip: int) -> Others:
    """The others as seen by a clock that starts `skip` steps later."""
    if not len(others.spans):
        return others
    first = min(skip, others.tracks.shape[1] - 1)
    spans = others.spans.copy()
    spans[:, 1:] -= skip * others.step
    return others._replace(tracks=np.ascontiguousarray(others.tracks[:, first:]), spans=spans)
