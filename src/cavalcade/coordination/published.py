"""The paper's low level: a robot's tree search with others as discs that are always there.

Others' positions become static discs of the threshold d (its section III-D). Of a whole path
that is avoided, positions count only if the other robot is there about when this one could be:
the time window of section III-B, with the distance from the start standing for time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.problem import PlanSettings
from cavalcade.coordination.robot_planner import EFFORT, RobotPlanner, Span, planned_by_trees
from cavalcade.coordination.solution import RobotPath
from cavalcade.geometry import Array
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.planner import TRACK_STEP

DISTANCE = 0.33
"""The threshold d between centres in the published code, m."""

_WINDOW = 2.0
"""Half the window of time, s."""

_SPACING = 4
"""Of a track every so many poses become discs."""


@dataclass(frozen=True, eq=False)
class PublishedPlanner(RobotPlanner):
    """Robots with legs by the paper's trees, with others as discs; they don't wait."""

    settings: PlanSettings
    seed: int

    def plan(
        self, robot: int, spans: Sequence[Span], budget: Budget, effort: int = EFFORT
    ) -> RobotPath | None:
        """See `RobotPlanner`; the path's cost is its length, as in the paper."""
        discs = [self._discs(robot, span) for span in spans]
        settings = BodySettings(
            iterations=budget.most(min(effort, BodySettings.iterations)),
            seconds=budget.deadline.left,
            leaps=self.settings.leaps,
            variant="published",
            discs=np.concatenate([np.zeros((0, 3)), *discs]),
        )
        # Another draw for every call, or the same failure would come again.
        seed = (self.seed * 1_000_003 + robot) * 100_003 + budget.used
        answer = planned_by_trees(self.problem, robot, settings, seed, budget)
        if answer.trajectory is None:
            return None
        return RobotPath(answer.trajectory, answer.trajectory.length)

    def _discs(self, robot: int, span: Span) -> Array:
        places = span.track[::_SPACING, :2]
        if len(span.track) > 1 and span.end == np.inf:
            legs = self.problem.models[robot].legs
            speed = 0.5 if legs is None else legs.v_nom
            away = np.hypot(*(places - self.problem.starts[robot][:2]).T)
            there = np.arange(len(places)) * _SPACING * TRACK_STEP
            soon = np.abs(there - away / speed) <= _WINDOW
            places = np.concatenate([places[soon], span.track[-1:, :2]])
        return np.column_stack([places, np.full(len(places), DISTANCE)])
