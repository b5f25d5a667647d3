"""What a job came to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cavalcade.coordination.result import TeamPlan
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.metrics.plan_result import PlanResult
from cavalcade.metrics.summary import Summary
from cavalcade.recording.frames import Recording
from cavalcade.scenario import ResolvedScenario, World


@dataclass(frozen=True)
class JobResult:
    """What `run` or `plan` was made of and what came out.

    Attributes:
        scenario: The resolved one.
        world: Its ground at the start.
        summary: The content of `summary.json`, also as a mapping.
        recording: Every cycle; None where nothing was carried out.
        planned: The plan as it was made, with its footholds; None for tasks that need none.
        directory: The folder of the results, None if none was asked for.
        files: What was written there.
    """

    scenario: ResolvedScenario
    world: World
    summary: Summary
    recording: Recording | None = None
    planned: PlanResult | None = None
    directory: Path | None = None
    files: tuple[Path, ...] = ()

    @property
    def success(self) -> bool:
        """It was done as asked, without a collision."""
        return self.summary.success

    @property
    def solved(self) -> bool:
        """The same, as one says it of a plan."""
        return self.summary.success

    @property
    def reason(self) -> str:
        """Why it ended, as in `summary.json`."""
        return self.summary.reason

    @property
    def plan(self) -> TeamPlan | None:
        """The coordinator's answer."""
        return None if self.planned is None else self.planned.plan

    @property
    def trajectories(self) -> tuple[Trajectory | None, ...]:
        """One per robot, map frame; see `TeamPlan.trajectories` for unsolved problems."""
        return () if self.planned is None else self.planned.trajectories

    @property
    def footholds(self) -> tuple[Array, ...]:
        """Per robot `(M, 6)` t_down, t_up (s), leg, x, y, z (m, map frame)."""
        return () if self.planned is None else self.planned.footholds
