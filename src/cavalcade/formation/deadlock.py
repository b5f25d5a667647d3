"""Deadlocks: noticing that a team gets nowhere, and sending it through one by one."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation.cycle import EMPTY_PATH, Cycle, direction, order_of
from cavalcade.formation.goals import GoalPlan, descend_from, eta_from
from cavalcade.formation.roles import least_cost
from cavalcade.geometry import Array

PATIENCE = 3.0
"""s without progress after which a deadlock is assumed."""
_STEP = 0.10  # s of ETA, or m of distance, that count as progress
_ATTEMPTS = 6  # at resolving before a team is reported as stuck
_OVER = 8.0  # s of median ETA gained, after which a deadlock is past
_SETTLED = 0.09  # m from all slots: nothing left to gain
_MAKE_ROOM = 2.0  # s for which robots step back in a repeated attempt
_NO_PATH = 1e3  # s that stand for no path at all
_GAIN = 0.95  # share of the squared times to which an exchange must bring them
_NEIGHBOUR = 1.3  # m between robots that may be in each other's way


class ProgressMonitor:
    """Watches a number that should fall; after `patience` s without a new low, it is stalled."""

    def __init__(self, patience: float = PATIENCE) -> None:
        self.patience = patience
        self.reset()

    def reset(self) -> None:
        """Start anew: another goal, map or mode."""
        self._best = np.inf
        self._since: float | None = None

    def stalled(self, measure: float, time: float) -> bool:
        """Whether `measure` has not fallen for too long at a time in s."""
        if self._since is None or measure < self._best - _STEP:
            self._best = min(self._best, measure)
            self._since = time
        return time - self._since > self.patience


@dataclass(frozen=True)
class SingleFile:
    """What resolving asks of the team in one cycle.

    Attributes:
        roles: `(N,)` final slots.
        rank: `(N,)` precedence.
        paths: Per robot, its path to its slot.
        courses: `(N, 2)` wanted velocities as shares of the top speed.
    """

    roles: NDArray[np.int64]
    rank: NDArray[np.int64]
    paths: tuple[Array, ...]
    courses: Array


class DeadlockMonitor:
    """Decides when the team resolves a deadlock, how, and when it is over.

    `rng` draws the precedence in repeated attempts.

    Attributes:
        attempts: How many times this deadlock has been tried to resolve.
        late: Robots that are not in their slots, once the team is stuck.
    """

    def __init__(self, lookahead: float, rng: np.random.Generator) -> None:
        self._lookahead = lookahead
        self._rng = rng
        self._monitor = ProgressMonitor()
        self.restart()

    def restart(self) -> None:
        """Another goal, shape or team."""
        self.late: tuple[int, ...] = ()
        self._slots: SlotExchange | None = None
        self.attempts = 0
        self._begun = 0.0
        self._begun_eta = np.inf
        self._order: NDArray[np.int64] | None = None
        self._near = False
        self._monitor.reset()

    def refresh(self) -> None:
        """Another map or state: progress is measured anew."""
        self._monitor.reset()

    def next_state(self, state: str, cycle: Cycle, roles: NDArray[np.int64]) -> str:
        """The state to go on in: `partial`, `final`, `resolving` or `stuck`."""
        eta = np.minimum(cycle.eta[cycle.active], 1e3)
        middle = median(eta.tolist())
        gained = self._begun_eta - middle
        if gained > _OVER and state == "partial":
            self.attempts, self._begun_eta = 0, np.inf
        measure = float(eta.mean())
        near = state == "final" or (state == "resolving" and eta.min() < 1.0)
        if near != self._near:
            self._near = near
            self._monitor.reset()  # what is measured changes: metres there, seconds here
        if near:
            away = cycle.plan_distances(roles)
            if away.max() < _SETTLED:
                self._monitor.reset()
                return state
            measure = float(away.sum())
        over = gained > 2.0 * (1 + self.attempts) and eta.min() > self._lookahead
        if state == "resolving" and over:
            self._slots = None
            self._monitor.reset()
            return "partial"
        if not self._monitor.stalled(measure, cycle.time):
            return state
        self._monitor.reset()
        self.attempts += 1
        if self.attempts > _ATTEMPTS:
            away = cycle.plan_distances(roles)
            self.late = tuple(int(k) for k in cycle.active[away > _SETTLED])
            self.attempts = 0
            return "stuck"
        self._slots = None
        self._begun, self._begun_eta = cycle.time, middle
        # The first try goes by who is ahead; if that did not help, by lot.
        repeated = self.attempts > 1
        self._order = self._rng.permutation(len(cycle.points)) if repeated else None
        return "resolving"

    def single_file(self, cycle: Cycle) -> SingleFile:
        """Paths, precedence and courses while resolving.

        Robots are not unique, so two in each other's way need not pass: they exchange slots. The
        robot that is ahead goes first; those behind give way. In a repeated attempt those who are
        in the way of an earlier one first step back from it.
        """
        points, active = cycle.points, cycle.active
        if self._slots is None:
            self._slots = SlotExchange(len(points))
        roles = self._slots.assign(cycle.plan, points, active, cycle.time)
        paths = [EMPTY_PATH] * len(points)
        courses = np.zeros((len(points), 2))
        rank = order_of(cycle.eta) if self._order is None else self._order
        for k in active:
            paths[k] = descend_from(
                cycle.plan.slot_field(int(roles[k]), points[active]), points[k]
            ).points
            courses[k] = direction(paths[k])
        if self._order is not None and cycle.time - self._begun < _MAKE_ROOM:
            _step_back(courses, points, active, rank)
        return SingleFile(roles, rank, tuple(paths), courses)


def _step_back(
    courses: Array, points: Array, active: NDArray[np.int64], rank: NDArray[np.int64]
) -> None:
    """Turn robots near one of earlier precedence away from it, in place."""
    for k in active:
        for j in active:
            offset = points[k] - points[j]
            gap = float(np.hypot(*offset))
            if rank[j] < rank[k] and 1e-9 < gap < _NEIGHBOUR:
                courses[k] = 0.6 * offset / gap


class SlotExchange:
    """Final slots in a deadlock: exchanged wherever two robots stand in each other's way.

    After the target swapping of Okumura and Défago (2022). Each pair rests for a while after an
    exchange, so that it cannot go back and forth. Without `roles` `(N,)` to begin with, it begins
    with those of the least sum of squared times.
    """

    def __init__(self, robots: int, roles: NDArray[np.int64] | None = None) -> None:
        self._roles = roles
        self._last = np.full((robots, robots), -np.inf)

    def assign(
        self, goal: GoalPlan, points: Array, active: NDArray[np.int64], time: float
    ) -> NDArray[np.int64]:
        """Slots `(N,)` of robots at `points` `(N, 2)` at a time in s, -1 for those not active."""
        eta = np.full((len(points), len(goal.places)), np.inf)
        for k in active:
            for slot in range(len(goal.places)):
                eta[k, slot] = eta_from(goal.slot_field(slot, points[active]), points[k])
        times = np.minimum(eta, _NO_PATH)
        if self._roles is None:
            self._roles = least_cost(times[active] ** 2, len(points), active)
        roles = self._roles
        # Two exchange slots if the sum of their squared times falls by it. That sum over the
        # team falls with every exchange, so that a team that stands settles.
        for i in active:
            for j in active:
                if i >= j or time - self._last[i, j] < PATIENCE:
                    continue
                a, b = roles[i], roles[j]
                straight = times[i, a] ** 2 + times[j, b] ** 2
                crossed = times[i, b] ** 2 + times[j, a] ** 2
                if crossed < _GAIN * straight - _STEP:
                    roles[i], roles[j] = b, a
                    self._last[i, j] = time
        return roles.copy()
