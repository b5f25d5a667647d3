"""What stands between planners and robots: faults stop the team until an operator resumes.

| kind of fault | what it means |
|---|---|
| `stale` | a pose is older than the age limit, or stamped that much later than now |
| `nan` | a pose, a stamp, the time or a command is not a finite number |
| `out-of-map`, `geofence` | a robot is where it must not be |
| `jump` | a pose moved farther than the robot can have gone |
| `clock-back`, `clock-still` | the clock was set back, or does not advance |
| `clock-forward` | the clock was set forward, so that poses are older than the age limit |
| `deadline` | a cycle took longer than two deadlines |
| `unresponsive` | a robot does not go where it is told to, and nobody can go on without it |
| `planner` | the policy ended with an exception |
| `e-stop` | somebody stopped the team; held until `reset_stop` |
| `closed` | the loop has ended |

Fleets have others of their own, such as `frame`.
"""

from __future__ import annotations

import math
import time as wall
from collections.abc import Sequence
from dataclasses import dataclass
from threading import RLock
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.fleet.protocol import Fault, Observation
from cavalcade.formation.estimation import MAX_AGE, Imperfections
from cavalcade.formation.robot_monitor import UnresponsiveMonitor
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel
from cavalcade.values import MAX_VALUE, instance_of, instances_of, number_in, whole_number
from cavalcade.world import OccupancyMap, Polygon

STOP = "e-stop"
"""The kind of a stop that is held until `Supervisor.reset_stop`."""

_REPEATS = 2
"""So many cycles in a row the clock may show the same time, as one of 10 Hz does under a loop of
20 Hz."""

_EXACT = 1e-9
"""Rounding of times, s."""


@dataclass(frozen=True)
class Supervision:
    """What a supervisor allows.

    Attributes:
        max_age: Oldest pose by which robots may be driven, s. Under a supervisor it is the
            planner's limit, too.
        max_jump: Longest displacement between two reports of a robot beyond what its top speed
            explains, m.
        max_turn: The same of its heading, rad.
        geofence: Corners x, y in m, map frame, of the polygon that robots' centres must stay in;
            None for the map's area alone.
        max_speed: Cap of commanded speeds, m/s; None for the planner's own.
        max_yaw_rate: The same of yaw rates, rad/s. A command beyond a cap is scaled as a whole, so
            that the robot takes the same path more slowly.
        deadline: How long a cycle may take, s. A longer one is counted as missed; one of more
            than twice that stops the team. None for simulated time, which waits for the planner;
            live fleets then have one period.
        unresponsive: Whether the others go on (`continue`) without a robot that does not follow
            its commands, where the policy can do without it, or all `stop`.
        dry_run: Do everything, but command nobody.

    Raises:
        InputError: A value of another kind or out of range; the key is the attribute.
    """

    max_age: float = MAX_AGE
    max_jump: float = 0.5
    max_turn: float = 1.0
    geofence: tuple[tuple[float, float], ...] | None = None
    max_speed: float | None = None
    max_yaw_rate: float | None = None
    deadline: float | None = None
    unresponsive: Literal["continue", "stop"] = "continue"
    dry_run: bool = False

    def __post_init__(self) -> None:
        for name in ("max_age", "max_jump", "max_turn", "max_speed", "max_yaw_rate", "deadline"):
            value = getattr(self, name)
            if value is None and name not in ("max_age", "max_jump", "max_turn"):
                continue
            if number_in(value, name, 0.0, 1e3) == 0.0:
                raise InputError("expected a number above 0", key=name)
        if self.geofence is not None:
            try:
                points = Polygon(self.geofence).points
            except InputError as error:
                raise error.at(key="geofence") from None
            object.__setattr__(self, "geofence", points)
        if self.unresponsive not in ("continue", "stop"):
            raise InputError("what the others do", key="unresponsive", choices=("continue", "stop"))
        instance_of(self.dry_run, bool, "dry_run", "true or false")


@dataclass(frozen=True)
class SupervisorReport:
    """Whether the team may move.

    Attributes:
        ok: It may. False from the first fault until data are fresh again and `resume` was called.
        faults: What is wrong now; empty also while a past fault is waiting for `resume`.
        cause: The faults that stopped the team; empty where `ok`.
        unresponsive: Robots that this check found not to follow, and that count as lost from now
            on.
    """

    ok: bool
    faults: tuple[Fault, ...]
    cause: tuple[Fault, ...]
    unresponsive: tuple[int, ...] = ()

    @property
    def message(self) -> str:
        """Why the team stands, for people; empty where it need not."""
        return ", ".join(str(fault) for fault in self.cause)


class _Report(NamedTuple):
    """A pose in m and rad, and when it was measured, s."""

    x: float
    y: float
    yaw: float
    stamp: float


class Supervisor:
    """Watches what a fleet reports and lets commands pass only while nothing is wrong.

    The first fault is latched: until it is over and `resume` was called every command is zero.
    Nothing starts by itself. All methods may be called from any thread.

    Args:
        models: One model per robot.
        period: Of the control cycle, s.
        supervision: What is allowed.
        area: Poses outside this map are faults; None leaves that out.
        expected: How well robots are located and how late commands reach them, for telling who
            does not follow.

    Raises:
        InputError: An argument of another kind or out of range.
    """

    def __init__(
        self,
        models: Sequence[RobotModel],
        period: float,
        supervision: Supervision | None = None,
        area: OccupancyMap | None = None,
        expected: Imperfections | None = None,
    ) -> None:
        self._models = instances_of(models, RobotModel, "models", "a RobotModel per robot")
        self.period = number_in(period, "period", 1e-3, 10.0, "s")
        given = Supervision() if supervision is None else supervision
        self.supervision = instance_of(given, Supervision, "supervision")
        self.area = area
        size = len(self._models)
        self._following = UnresponsiveMonitor(
            self._models, self.period, Imperfections() if expected is None else expected
        )
        self._lock = RLock()
        self._lost = [False] * size
        self._known: list[_Report | None] = [None] * size
        self._seen = np.zeros((size, 3))
        self._time: float | None = None
        self._wall, self._leapt = wall.monotonic(), 0.0  # of the last check; how far it leapt then
        self._repeats = 0
        self._cause: tuple[Fault, ...] = ()
        self._stop: Fault | None = None
        self._heard = [-math.inf] * size  # stamps at the stop, which resuming takes newer ones than
        self._checked = self._resuming = self._closed = False
        self._missed = 0

    @property
    def stopped(self) -> bool:
        """Whether every command is zero now: a cause is latched or nothing was checked yet."""
        with self._lock:
            return bool(self._cause) or self._closed or not self._checked

    @property
    def cause(self) -> tuple[Fault, ...]:
        """What stopped the team; empty while it may move."""
        with self._lock:
            return self._cause

    @property
    def pressed(self) -> bool:
        """Whether the e-stop holds: `reset_stop` was not called since."""
        with self._lock:
            return self._stop is not None

    @property
    def lost(self) -> tuple[int, ...]:
        """Robots that the others go on without."""
        with self._lock:
            return tuple(robot for robot, lost in enumerate(self._lost) if lost)

    @property
    def missed(self) -> int:
        """How many cycles took longer than the deadline."""
        with self._lock:
            return self._missed

    def check(self, observation: Observation, busy: Sequence[int] = ()) -> SupervisorReport:
        """Judge the newest reports; call it once per cycle before planning.

        Args:
            observation: What the fleet reports.
            busy: Robots that take no commands at present, such as those that leap.
        """
        with self._lock:
            return self._check(observation, busy)

    def admit(self, commands: ArrayLike, took: float = 0.0) -> Array:
        """What may be sent of body-frame commands `(N, 3)`, m/s, m/s, rad/s, as an own array.

        All zero while the team is stopped and in a dry run, and for robots that are lost;
        otherwise within the caps.

        Args:
            commands: Those of the policy, by the observation that was checked last.
            took: How long it took since then, s.
        """
        with self._lock:
            wanted = np.array(commands, dtype=float)
            zeros = np.zeros((len(self._models), 3))
            if wanted.shape != zeros.shape:
                raise InputError(
                    f"expected commands of shape {zeros.shape}, got {wanted.shape}", key="commands"
                )
            if not np.isfinite(wanted).all():
                self._latch(Fault(None, "nan", "the planner's commands"))
            self._judge_time(took)
            admitted = self.gate(self._capped(wanted))
            self._following.commanded(admitted)
            return admitted

    def gate(self, commands: Array) -> Array:
        """Admitted commands `(N, 3)` as they may leave now: something may have happened since."""
        with self._lock:
            if self.stopped or self.supervision.dry_run:
                return np.zeros_like(commands)
            commands = commands.copy()
            commands[self._lost] = 0.0
            return commands

    def stop(self, kind: str = STOP, detail: str = "", robot: int | None = None) -> None:
        """Stop the team, at the latest with the next command.

        An `e-stop` is held until `reset_stop`; other kinds are over at once. All are latched.
        """
        fault = Fault(robot, kind, detail)
        with self._lock:
            if kind == STOP:
                self._stop = fault
            self._latch(fault)

    def reset_stop(self) -> None:
        """Lift the e-stop. Nobody moves yet: that takes `resume`."""
        with self._lock:
            self._stop = None

    def resume(self) -> None:
        """Let the team move again from the next check on, if that check finds all data good.

        Good means: no fault, and of each robot a report that is newer than the stop. A check that
        finds otherwise drops the request, so that nothing starts by itself later.
        """
        with self._lock:
            self._resuming = True

    def lose(self, robot: int) -> None:
        """The robot is known to be lost: whatever it reports is no fault, it is never commanded."""
        self._set_lost(robot, True)

    def rejoin(self, robot: int) -> None:
        """The robot counts again; its next report is not compared with what came before."""
        self._set_lost(robot, False)

    def close(self) -> None:
        """Stop the team for good."""
        with self._lock:
            self._closed = True
            self._latch(Fault(None, "closed"))

    def _set_lost(self, robot: int, lost: bool) -> None:
        robot = whole_number(robot, "robot", 0, len(self._models) - 1)
        with self._lock:
            self._lost[robot] = lost
            self._known[robot] = None if not lost else self._known[robot]
            self._following.forget()

    def _latch(self, *faults: Fault) -> None:
        """Remember why the team stands: what came first, and every e-stop."""
        if not self._cause:
            self._cause = faults
            now = math.inf if self._time is None else self._time
            for robot, report in enumerate(self._known):
                self._heard[robot] = -math.inf if report is None else min(report.stamp, now)
        else:
            new = tuple(f for f in faults if f.kind in (STOP, "closed") and f not in self._cause)
            self._cause += new
        self._resuming = False
        self._following.forget()

    def _check(self, observation: Observation, busy: Sequence[int]) -> SupervisorReport:
        now = float(observation.time)
        found = [] if self._stop is None else [self._stop]
        found += self._faults_of_clock(now)
        found += [f for f in observation.faults if f.robot is None or not self._lost[f.robot]]
        # A few robots: Python's own numbers take a tenth of the time of arrays.
        reports = zip(observation.poses.tolist(), observation.stamps.tolist(), strict=True)
        fresh = self._repeats == 0
        for robot, ((x, y, yaw), stamp) in enumerate(reports):
            report = _Report(x, y, yaw, stamp)
            fault = self._fault_of(robot, report, now)
            if fault is not None and not self._lost[robot] and fault not in found:
                found.append(fault)
            # A nonsense report leaves the last sound one in place, so that a robot which comes
            # back somewhere else is found to have jumped.
            if fault is None or fault.kind != "nan":
                self._known[robot] = report
                self._seen[robot] = x, y, yaw
                fresh &= stamp > self._heard[robot] or self._lost[robot]
        faults = tuple(found)
        self._checked = True
        if faults:
            self._latch(*faults)
        elif self._resuming and fresh and not self._closed:
            self._cause = ()
        self._resuming = False
        unresponsive = () if self._cause else self._unresponsive(now, busy)
        return SupervisorReport(not self._cause, faults, self._cause, unresponsive)

    def _faults_of_clock(self, now: float) -> list[Fault]:
        last, before = self._time, self._wall
        self._wall, self._leapt = wall.monotonic(), 0.0
        if not math.isfinite(now):
            return [Fault(None, "nan", "the time")]
        self._time = now
        if last is None:
            return []
        # Simulated time goes on by a period, however fast that is.
        self._leapt = leap(
            max(now - last - self.period, 0.0), self._wall - before, self.supervision
        )
        self._repeats = self._repeats + 1 if abs(now - last) <= _EXACT else 0
        if now < last - _EXACT:
            # Reports of before are later than all that will come.
            self._heard = [-math.inf] * len(self._heard)
            return [Fault(None, "clock-back", f"by {last - now:.3g} s")]
        if self._repeats > _REPEATS:
            return [Fault(None, "clock-still", f"at {now:.3f} s")]
        return []

    def _fault_of(self, robot: int, report: _Report, now: float) -> Fault | None:
        # Nan fails every comparison.
        if not (all(abs(value) <= MAX_VALUE for value in report[:3]) and abs(report.stamp) < 1e11):
            return Fault(robot, "nan")
        age = now - report.stamp
        if age > self.supervision.max_age + _EXACT:
            if age - self._leapt <= self.supervision.max_age:
                return Fault(None, "clock-forward", f"by {self._leapt:.3g} s")
            return Fault(robot, "stale", f"{age:.2f} s old")
        if -age > self.supervision.max_age + _EXACT:
            return Fault(robot, "stale", f"stamped {-age:.3g} s later than now")
        if self.area is not None and not _on_map(report, self.area):
            return Fault(robot, "out-of-map")
        fence = self.supervision.geofence
        if fence is not None and not _inside(report.x, report.y, fence):
            return Fault(robot, "geofence")
        known = self._known[robot]
        if known is not None and self._jumped(robot, report, known):
            return Fault(robot, "jump")
        return None

    def _jumped(self, robot: int, report: _Report, known: _Report) -> bool:
        model = self._models[robot]
        age = max(report.stamp - known.stamp, 0.0)
        moved = math.hypot(report.x - known.x, report.y - known.y)
        turned = abs((report.yaw - known.yaw + math.pi) % (2.0 * math.pi) - math.pi)
        return (
            moved - max(model.max_speed_x, model.max_speed_y) * age > self.supervision.max_jump
            or turned - model.max_yaw_rate * age > self.supervision.max_turn
        )

    def _unresponsive(self, now: float, busy: Sequence[int]) -> tuple[int, ...]:
        """Who turned out not to follow; they are lost, or stop the team if that is to be so."""
        if len(busy):
            self._following.excuse(busy)
        self._following.update(self._seen.copy(), now)
        deaf = tuple(robot for robot in self._following.deaf if not self._lost[robot])
        if not deaf:
            return ()
        left = self._lost.count(False) - len(deaf)
        if self.supervision.unresponsive == "stop" or not left:
            what = "commanded, but does not move"
            self._latch(*(Fault(robot, "unresponsive", what) for robot in deaf))
            return ()
        for robot in deaf:
            self.lose(robot)
        return deaf

    def _judge_time(self, took: float) -> None:
        deadline = self.supervision.deadline
        if deadline is None or took <= deadline + _EXACT:
            return
        self._missed += 1
        if not took <= 2.0 * deadline + _EXACT:
            self._latch(Fault(None, "deadline", f"a cycle took {took:.3g} s"))

    def _capped(self, wanted: Array) -> Array:
        """The commands, those beyond a cap scaled down to it."""
        allowed = self.supervision
        share = np.ones(len(wanted))
        if allowed.max_speed is not None:
            speed = np.hypot(wanted[:, 0], wanted[:, 1])
            share = allowed.max_speed / np.maximum(speed, allowed.max_speed)
        if allowed.max_yaw_rate is not None:
            turn = np.maximum(np.abs(wanted[:, 2]), allowed.max_yaw_rate)
            share = np.minimum(share, allowed.max_yaw_rate / turn)
        return wanted * share[:, None]


def leap(step: float, passed: float, supervision: Supervision) -> float:
    """How far a clock leapt that went on by `step` s while `passed` s went by, s; 0 if it did not.

    Clocks that go twice as fast as the wall's do not leap.
    """
    beyond = step - 2.0 * passed
    return beyond if beyond > supervision.max_age else 0.0


def _on_map(report: _Report, area: OccupancyMap) -> bool:
    x0, y0, yaw = area.origin
    x, y = report.x - x0, report.y - y0
    c, s = math.cos(yaw), math.sin(yaw)
    width, height = area.size
    return 0.0 <= c * x + s * y <= width and 0.0 <= c * y - s * x <= height


def _inside(x: float, y: float, corners: Sequence[tuple[float, float]]) -> bool:
    """Whether a point lies in a polygon; its edges belong to it."""
    inside = False
    x0, y0 = corners[-1]
    for x1, y1 in corners:
        across = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
        length = math.hypot(x1 - x0, y1 - y0)
        along = (x1 - x0) * (x - x0) + (y1 - y0) * (y - y0)
        if abs(across) <= _EXACT * length and -_EXACT <= along <= length * length + _EXACT:
            return True
        if (y0 > y) != (y1 > y) and (across > 0.0) == (y1 > y0):
            inside = not inside
        x0, y0 = x1, y1
    return inside
