"""What coordination ends with, apart from the methods, whose kernels not every job needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cavalcade.geometry.trajectory import Trajectory


@dataclass(frozen=True)
class TeamPlan:
    """The answer to a `TeamProblem`; "no plan" is an answer, too.

    Attributes:
        reason: `solved`; `infeasible`: there is no plan, and `detail` says why; `budget`: none
            was found before the budget was spent.
        detail: One line, empty where there is nothing to add.
        involved: The robots that `detail` is about.
        trajectories: One per robot in the map frame. Of an unsolved problem what is known: paths
            to the goals that meet somewhere, or None.
        method: Which coordinator found it; of `auto` the one that it fell back on.
        iterations: Expansions of searches and trees, what the iteration budget counts.
        planning_time: s of wall time, without the compilation or loading of kernels.
        history: Iterations and summed cost of the first plan and of each better one, where
            improvement was asked for.
        counts: Further figures of the method, such as nodes of the conflict tree.
        margins: By how much each robot's body was inflated, m; empty where none was.
    """

    reason: str
    detail: str
    involved: tuple[int, ...]
    trajectories: tuple[Trajectory | None, ...]
    method: str
    iterations: int
    planning_time: float
    counts: Mapping[str, int] = field(default_factory=dict)
    history: tuple[tuple[int, float], ...] = ()
    margins: tuple[float, ...] = ()

    @property
    def solved(self) -> bool:
        """Whether every robot has a trajectory and none meets another, as the method sees it."""
        return self.reason == "solved"
