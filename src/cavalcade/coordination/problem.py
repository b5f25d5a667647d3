"""The problem that all coordinators share: a ground, robots, and a start and a goal for each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cavalcade.body.ground import Ground
from cavalcade.robots import RobotModel

Pose = tuple[float, float, float]


@dataclass(frozen=True)
class PlanSettings:
    """How a coordinator plans.

    Attributes:
        constraints: `timed`: bodies of others count while they are there; `static`: they are
            obstacles for all time, as in the paper.
        conflict: Which conflict of a node is resolved: the `costly` one, the `earliest`, or the
            `first` in the order of the robots, as in the paper.
        leaps: Whether legged robots may leap.
        improve: Iterations spent on a better plan once there is one.
        iterations: The budget: expansions of searches and trees.
        seconds: Limit of wall time, s; None for none. A plan never depends on it otherwise.
    """

    constraints: Literal["timed", "static"] = "timed"
    conflict: Literal["costly", "earliest", "first"] = "costly"
    leaps: bool = True
    improve: int = 0
    iterations: int = 2_000_000
    seconds: float | None = None


@dataclass(frozen=True)
class TeamProblem:
    """Robots on a ground, each with a start and a goal.

    Attributes:
        ground: What is in the way.
        models: Of each robot.
        starts, goals: Poses (x m, y m, yaw rad) in the ground's own frame.
    """

    ground: Ground
    models: tuple[RobotModel, ...]
    starts: tuple[Pose, ...]
    goals: tuple[Pose, ...]
