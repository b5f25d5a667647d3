"""Watches the pose reports and says when the team must not go on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.fleet.protocol import Observation
from cavalcade.geometry import Array, wrap_angle
from cavalcade.world import OccupancyMap


@dataclass(frozen=True)
class Fault:
    """What is wrong with one robot's reports.

    Attributes:
        robot: Its index.
        kind: `stale` (too old), `nan` (not finite), `out-of-map` or `jump`.
    """

    robot: int
    kind: str

    def __str__(self) -> str:
        return f"{self.kind}: robot {self.robot}"


@dataclass(frozen=True)
class WatchdogReport:
    """Whether the team may move.

    Attributes:
        ok: It may. False from the first fault until data are fresh again and `resume` was called.
        faults: What is wrong now; empty also while a past fault is waiting for `resume`.
        cause: The faults that stopped the team; empty where `ok`.
    """

    ok: bool
    faults: tuple[Fault, ...]
    cause: tuple[Fault, ...]


class Watchdog:
    """Latches the first fault of any robot's pose reports until it is told to resume.

    Args:
        size: Number of robots.
        area: Poses outside this map are faults; None leaves that out.
        max_age: Oldest report that may be used, s.
        max_jump: Longest displacement between two reports beyond what `max_speed` explains, m.
        max_turn: The same for the heading beyond what `max_yaw_rate` explains, rad.
        max_speed, max_yaw_rate: The fastest robot's, m/s and rad/s.
    """

    def __init__(
        self,
        size: int,
        area: OccupancyMap | None = None,
        *,
        max_age: float = 0.5,
        max_jump: float = 0.5,
        max_turn: float = 1.0,
        max_speed: float = 0.5,
        max_yaw_rate: float = 1.2,
    ) -> None:
        self._size = size
        self._area = area
        self._max_age = max_age
        self._max_jump = max_jump
        self._max_turn = max_turn
        self._max_speed = max_speed
        self._max_yaw_rate = max_yaw_rate
        self._lost = np.zeros(size, dtype=bool)
        self._poses: Array | None = None
        self._stamps = np.zeros(size)
        self._cause: tuple[Fault, ...] = ()
        self._resuming = False

    def check(self, observation: Observation) -> WatchdogReport:
        """Judge the newest reports; call it once per cycle before planning."""
        poses, stamps = observation.poses, observation.stamps
        finite = np.isfinite(poses).all(axis=1) & np.isfinite(stamps)
        stale = finite & (observation.time - stamps > self._max_age + 1e-9)
        outside = self._outside(poses, finite)
        jumped = self._jumped(poses, stamps, finite)
        faulty = (~finite | stale | outside | jumped) & ~self._lost
        self._remember(poses, stamps, finite)
        faults: tuple[Fault, ...] = ()
        if faulty.any():
            kinds = (("nan", ~finite), ("stale", stale), ("out-of-map", outside), ("jump", jumped))
            faults = tuple(
                Fault(int(robot), next(kind for kind, mask in kinds if mask[robot]))
                for robot in np.flatnonzero(faulty)
            )
            self._cause = self._cause or faults
        elif self._resuming:
            self._cause = ()
        self._resuming = False
        return WatchdogReport(not self._cause, faults, self._cause)

    def resume(self) -> None:
        """Let the team move again from the next check on, if that check finds all data good.

        A check that still finds a fault drops the request, so that nothing starts by itself later.
        """
        self._resuming = True

    def lose(self, robot: int) -> None:
        """The robot is known to be lost: whatever it reports is no fault."""
        self._lost[robot] = True

    def rejoin(self, robot: int) -> None:
        """The robot counts again; its next report is not compared with what came before."""
        self._lost[robot] = False
        if self._poses is not None:
            self._poses[robot] = np.nan

    def _outside(self, poses: Array, finite: NDArray[np.bool_]) -> NDArray[np.bool_]:
        if self._area is None:
            return np.zeros(self._size, dtype=bool)
        return finite & ~self._area.contains(np.where(finite[:, None], poses, 0.0)[:, :2])

    def _jumped(self, poses: Array, stamps: Array, finite: NDArray[np.bool_]) -> NDArray[np.bool_]:
        if self._poses is None:
            return np.zeros(self._size, dtype=bool)
        known = finite & np.isfinite(self._poses).all(axis=1)
        change = np.where(known[:, None], poses, 0.0) - np.where(known[:, None], self._poses, 0.0)
        age = np.where(known, np.maximum(stamps - self._stamps, 0.0), 0.0)
        moved = np.hypot(change[:, 0], change[:, 1]) - self._max_speed * age
        turned = np.abs(wrap_angle(change[:, 2])) - self._max_yaw_rate * age
        return known & ((moved > self._max_jump) | (turned > self._max_turn))

    def _remember(self, poses: Array, stamps: Array, finite: NDArray[np.bool_]) -> None:
        if self._poses is None:
            self._poses = np.full_like(poses, np.nan)
        # A nonsense report leaves the last sound one in place, so that a robot which comes back
        # somewhere else is found to have jumped.
        self._poses[finite] = poses[finite]
        self._stamps[finite] = stamps[finite]
