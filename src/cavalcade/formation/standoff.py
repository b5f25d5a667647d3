"""Stand-offs: noticing that a team gets nowhere, and sending it through one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation.goals import Descent, GoalPlan, descend_from
from cavalcade.geometry import Array

PATIENCE = 3.0
"""s without progress after which a stand-off is assumed."""
_STEP = 0.10  # s of ETA, or m of distance, that count as progress


class ProgressMonitor:
    """Watches numbers that should fall while the team gets on.

    Args:
        patience: Seconds without a new low after which the team counts as standing off.
    """

    def __init__(self, patience: float = PATIENCE) -> None:
        self.patience = patience
        self._best = np.inf
        self._since: float | None = None

    def reset(self) -> None:
        """Start anew: another goal, map or mode."""
        self._best = np.inf
        self._since = None

    def stalled(self, measure: float, time: float) -> bool:
        """Whether `measure` has not fallen for too long.

        Args:
            measure: What should fall.
            time: Now, s.
        """
        if self._since is None or measure < self._best - _STEP:
            self._best = min(self._best, measure)
            self._since = time
        return time - self._since > self.patience


@dataclass(frozen=True)
class SinglePlan:
    """What resolving asks of the team in one cycle.

    Attributes:
        roles: `(N,)` final slots.
        ways: Per robot, its way to its slot.
        rank: `(N,)` precedence: who is ahead goes first.
    """

    roles: NDArray[np.int64]
    ways: tuple[Descent, ...]
    rank: NDArray[np.int64]


class Resolver:
    """Brings robots to their final slots one by one, each along its own arrival-time field.

    Robots are not unique, so two in each other's way need not pass: they exchange slots, as in
    the target swapping of Okumura and Défago (2022). The robot that is ahead goes first; those behind give
    way.

    Args:
        roles: `(N,)` slots to begin with, -1 for robots that take no part.
    """

    def __init__(self, roles: NDArray[np.int64]) -> None:
        self._roles = roles.copy()
        self._last_swap = np.full((len(roles), len(roles)), -np.inf)

    def plan(
        self,
        goal: GoalPlan,
        points: Array,
        active: NDArray[np.int64],
        eta: Array,
        time: float,
    ) -> SinglePlan:
        """Ways and precedence now.

        Args:
            goal: Where to.
            points: `(N, 2)` robots, m.
            active: Robots that take part.
            eta: `(N,)` times to the formation's goal, s: who is ahead.
            time: Now, s.
        """
        self._swap(goal, points, active, time)
        ways = [Descent(np.empty((0, 2)), np.empty(0)) for _ in range(len(points))]
        for k in active:
            ways[k] = descend_from(goal.slot_field(int(self._roles[k])), points[k])
        rank = np.empty(len(points), dtype=np.int64)
        rank[np.argsort(eta, kind="stable")] = np.arange(len(points))
        return SinglePlan(self._roles.copy(), tuple(ways), rank)

    def _swap(self, goal: GoalPlan, points: Array, active: NDArray[np.int64], time: float) -> None:
        """Exchange slots wherever that shortens the longer of two ways, or a robot is in the way.

        Each pair rests for a while after an exchange, so that it cannot go back and forth.
        """
        eta = {
            (int(k), int(slot)): self._eta(goal, int(slot), points[k])
            for k in active
            for slot in self._roles[active]
        }
        for i in active:
            for j in active:
                if i >= j or time - self._last_swap[i, j] < PATIENCE:
                    continue
                a, b = int(self._roles[i]), int(self._roles[j])
                straight = (eta[int(i), a], eta[int(j), b])
                crossed = (eta[int(i), b], eta[int(j), a])
                near = float(np.hypot(*(points[i] - points[j]))) < 1.5
                shorter = max(crossed) < max(straight) - 0.2
                equal = max(crossed) <= max(straight) + 0.2 and sum(crossed) < sum(straight) - 0.2
                if shorter or (near and equal):
                    self._roles[i], self._roles[j] = b, a
                    self._last_swap[i, j] = time

    def _eta(self, goal: GoalPlan, slot: int, point: Array) -> float:
        field = goal.slot_field(slot)
        eta = field.eta(point)
        if np.isfinite(eta):
            return eta
        near = field.nearest_reached(point, reach=1.5)
        return np.inf if near is None else field.eta(near)
