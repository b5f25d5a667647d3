"""A plan with its footholds and its summary."""

from __future__ import annotations

from dataclasses import dataclass

from cavalcade.coordination.result import TeamPlan
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.metrics.summary import Summary


@dataclass(frozen=True)
class PlanResult:
    """What planning came to.

    Attributes:
        plan: The coordinator's answer.
        footholds: Per robot `(M, 6)` t_down, t_up (s), leg, x, y, z (m, map frame); empty for
            robots without legs and where there is no trajectory.
        summary: Its metrics.
    """

    plan: TeamPlan
    footholds: tuple[Array, ...]
    summary: Summary

    @property
    def solved(self) -> bool:
        """Whether every robot has a trajectory and none meets anything."""
        return self.summary.success

    @property
    def reason(self) -> str:
        """`solved`, `infeasible` or `budget`, as in `summary.json`."""
        return self.summary.reason

    @property
    def trajectories(self) -> tuple[Trajectory | None, ...]:
        """One per robot, map frame; see `TeamPlan.trajectories` for unsolved problems."""
        return self.plan.trajectories
