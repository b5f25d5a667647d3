"""What planning came to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cavalcade.coordination.result import TeamPlan
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory


@dataclass(frozen=True)
class PlanResult:
    """What planning came to.

    Attributes:
        plan: The coordinator's answer.
        footholds: Per robot `(M, 6)` t_down, t_up (s), leg, x, y, z (m, map frame); empty for
            robots without legs and where there is no trajectory.
        summary: The content of `summary.json`.
        directory: The folder of the results, None if none was asked for.
        files: What was written there.
    """

    plan: TeamPlan
    footholds: tuple[Array, ...]
    summary: dict[str, Any]
    directory: Path | None
    files: tuple[Path, ...]

    @property
    def solved(self) -> bool:
        """Whether every robot has a trajectory and none meets anything."""
        return bool(self.summary["success"])

    @property
    def reason(self) -> str:
        """`solved`, `infeasible` or `budget`, as in `summary.json`."""
        return str(self.summary["reason"])

    @property
    def trajectories(self) -> tuple[Trajectory | None, ...]:
        """One per robot, map frame; see `TeamPlan.trajectories` for unsolved problems."""
        return self.plan.trajectories
