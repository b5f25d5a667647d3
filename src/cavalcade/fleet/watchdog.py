"""Watches the pose reports and says when the team must not go on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from cavalcade.fleet.protocol import Fault, Observation
from cavalcade.world import OccupancyMap


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


class _Report(NamedTuple):
    """A pose in m and rad, and when it was measured, s."""

    x: float
    y: float
    yaw: float
    stamp: float


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
        self._area = area
        self._max_age = max_age
        self._max_jump = max_jump
        self._max_turn = max_turn
        self._max_speed = max_speed
        self._max_yaw_rate = max_yaw_rate
        self._lost = [False] * size
        self._known: list[_Report | None] = [None] * size
        self._cause: tuple[Fault, ...] = ()
        self._resuming = False

    def check(self, observation: Observation) -> WatchdogReport:
        """Judge the newest reports; call it once per cycle before planning."""
        found: list[Fault] = []
        # A few robots: Python's own numbers take a tenth of the time of arrays.
        reports = zip(observation.poses.tolist(), observation.stamps.tolist(), strict=True)
        for robot, ((x, y, yaw), stamp) in enumerate(reports):
            report = _Report(x, y, yaw, stamp)
            kind = self._kind_of_fault(report, self._known[robot], observation.time)
            if kind is not None and not self._lost[robot]:
                found.append(Fault(robot, kind))
            # A nonsense report leaves the last sound one in place, so that a robot which comes
            # back somewhere else is found to have jumped.
            if kind != "nan":
                self._known[robot] = report
        faults = tuple(found)
        if faults:
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
        self._known[robot] = None

    def _kind_of_fault(self, report: _Report, known: _Report | None, now: float) -> str | None:
        if not all(map(math.isfinite, report)):
            return "nan"
        if now - report.stamp > self._max_age + 1e-9:
            return "stale"
        if self._outside(report):
            return "out-of-map"
        if known is not None and self._jumped(report, known):
            return "jump"
        return None

    def _outside(self, report: _Report) -> bool:
        if self._area is None:
            return False
        x0, y0, yaw = self._area.origin
        x, y = report.x - x0, report.y - y0
        c, s = math.cos(yaw), math.sin(yaw)
        width, height = self._area.size
        return not (0.0 <= c * x + s * y <= width and 0.0 <= c * y - s * x <= height)

    def _jumped(self, report: _Report, known: _Report) -> bool:
        age = max(report.stamp - known.stamp, 0.0)
        moved = math.hypot(report.x - known.x, report.y - known.y)
        turned = abs((report.yaw - known.yaw + math.pi) % (2.0 * math.pi) - math.pi)
        return (
            moved - self._max_speed * age > self._max_jump
            or turned - self._max_yaw_rate * age > self._max_turn
        )
