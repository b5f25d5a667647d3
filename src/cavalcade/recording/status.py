"""What the formation planner says about itself after each cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array


@dataclass(frozen=True)
class PlannerStatus:
    """The planner's view of one cycle; positions in the map frame.

    Attributes:
        state: `inactive`, `partial`, `final` (the paper's three), `resolving` (a deadlock is
            being resolved), `paused`, `stuck` or `infeasible`.
        leader: Index of the leading robot, -1 where there is none.
        roles: `(N,)` slot index of each robot, -1 for a robot that takes no part.
        slots: `(S, 2)` slots in the formation frame, m.
        goals: `(N, 2)` each robot's present (partial or final) goal, m; its own position where it
            has none.
        goal: `(3,)` pose of the formation's centre that is being driven to, or None.
        paths: Per robot, `(K, 2)` the path being followed, possibly empty.
        connections: `(C, 2)` pairs of robots joined by a spring now.
        eta: `(N,)` normalised seconds to the formation goal; inf where there is no path.
        arrived: All robots stand in their slots of the last goal.
        waypoint: Index of the goal being driven to.
        goal_moved: Distance in m by which the present goal was moved to fit; 0.0 normally.
        involved: Robots named by `stuck` or `infeasible`.
        message: One line for people; empty normally.
        targets: `(N, 3)` poses, where robots have goals of their own; there is no formation then.
    """

    state: str
    leader: int
    roles: NDArray[np.int64]
    slots: Array
    goals: Array
    goal: Array | None
    paths: tuple[Array, ...]
    connections: NDArray[np.int64]
    eta: Array
    arrived: bool
    waypoint: int
    goal_moved: float
    involved: tuple[int, ...]
    message: str
    targets: Array | None = None
