"""How a run ended."""

from __future__ import annotations

from dataclasses import dataclass

from cavalcade.geometry import Array


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes:
        reason: `arrived`, `done`, `timeout`, `stuck`, `fallen`, `infeasible`, `budget` or
            `stopped`.
        detail: One line about it, empty where there is nothing to add.
        involved: The robots it is about.
        last_waypoint: Index of the last goal.
        wall_time: Of the whole loop, s.
        planning: `(T,)` s of wall time spent in the planner in each cycle.
    """

    reason: str
    detail: str
    involved: tuple[int, ...]
    last_waypoint: int
    wall_time: float
    planning: Array
