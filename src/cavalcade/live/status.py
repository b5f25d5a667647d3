"""What a team's navigation says of itself, in one piece that does not change."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cavalcade.execution.control import Cycle
from cavalcade.fleet import Fault
from cavalcade.geometry import Array
from cavalcade.recording.frames import Frame
from cavalcade.recording.status import PlannerStatus

Pose = tuple[float, float, float]

DIGITS = 4
"""Decimals of numbers in text."""


@dataclass(frozen=True)
class RobotStatus:
    """One robot; poses in the map frame, m and rad.

    Attributes:
        name: Its name.
        pose: As it reported last; None if it never did, or nonsense.
        age: Of that pose, s; None without one.
        command: Body-frame velocity that was sent last: m/s, m/s, rad/s.
        slot: Of the formation, -1 for none.
        goal: Of its own, None if it has none.
        lost: Whether the others go on without it.
        faults: What is wrong with it now, a line each.
    """

    name: str
    pose: Pose | None = None
    age: float | None = None
    command: Pose = (0.0, 0.0, 0.0)
    slot: int = -1
    goal: Pose | None = None
    lost: bool = False
    faults: tuple[str, ...] = ()


@dataclass(frozen=True)
class TeamStatus:
    """The team at one moment; poses in the map frame, m and rad.

    Attributes:
        state: `inactive` (not started, or ended), `idle` (no goal), `partial`, `final`,
            `resolving`, `stuck` and `infeasible` (the planner's), `arrived`, `paused`, `stale` or
            `stopped`.
        mode: Whose goals are driven to: `formation` or `individual`.
        time: The fleet's clock, s.
        robots: Each of them, in the team's order.
        cause: What stopped the team, a line each, with robots' names; empty while it may move.
        message: One line for people: what happened, to whom, what to do; empty normally.
        refused: The last input that was refused, and why; empty after one that was taken.
        recording: What is wrong with what is recorded, such as a full disk; empty if nothing is.
        goals: Poses of the formation's centre that are to be driven to, in order.
        waypoint: Index of the present one.
        goal_moved: By how much the present one was moved to where the shape fits, m.
        leader: Name of the leading robot, empty for none.
        dry_run: Whether nobody is commanded.
        pace: Figures of the cycles: see `CycleStatistics.to_dict`.
    """

    state: str
    mode: str
    time: float
    robots: tuple[RobotStatus, ...]
    cause: tuple[str, ...] = ()
    message: str = ""
    refused: str = ""
    recording: str = ""
    goals: tuple[Pose, ...] = ()
    waypoint: int = 0
    goal_moved: float = 0.0
    leader: str = ""
    dry_run: bool = False
    pace: dict[str, Any] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether nothing stopped the team."""
        return not self.cause

    @property
    def arrived(self) -> bool:
        """Whether all stand where they are to."""
        return self.state == "arrived"

    @property
    def turning_point(self) -> tuple[Any, ...]:
        """What is worth telling at once when it changes.

        Of the present faults their kinds are: what is said of them, such as an age, may change in
        each cycle.
        """
        lost = tuple(robot.lost for robot in self.robots)
        faults = [tuple(line.partition(" (")[0] for line in robot.faults) for robot in self.robots]
        goals = tuple(robot.goal for robot in self.robots)
        return (
            self.state, self.mode, self.cause, self.message, self.refused, self.recording,
            self.goals, self.waypoint, lost, tuple(faults), goals,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: no nan, null for what is not known; robots by their names."""
        robots = {
            robot.name: {
                "pose": _plain(robot.pose),
                "age": _plain(robot.age),
                "command": _plain(robot.command),
                "slot": robot.slot,
                "goal": _plain(robot.goal),
                "lost": robot.lost,
                "faults": list(robot.faults),
            }
            for robot in self.robots
        }
        return {
            "state": self.state,
            "mode": self.mode,
            "ok": self.ok,
            "arrived": self.arrived,
            "time": _plain(self.time),
            "cause": list(self.cause),
            "message": self.message,
            "refused": self.refused,
            "recording": self.recording,
            "goals": [_plain(goal) for goal in self.goals],
            "waypoint": self.waypoint,
            "goal_moved": _plain(self.goal_moved),
            "leader": self.leader,
            "dry_run": self.dry_run,
            "robots": robots,
            "pace": self.pace,
        }


def robots_of(
    names: Sequence[str],
    frame: Frame,
    cycle: Cycle,
    cause: Sequence[Fault],
    goals: Sequence[Pose | None],
    lost: Sequence[int],
    now: float,
) -> tuple[RobotStatus, ...]:
    """The robots as of a cycle and its frame, at the time `now` in s, with goals of their own."""
    # Of each kind what is wrong now says more than what it was when it stopped the team.
    faults = {(fault.robot, fault.kind): fault for fault in (*cause, *cycle.report.faults)}
    commands = np.zeros_like(frame.commands) if cause else frame.commands
    return tuple(
        RobotStatus(
            name,
            _pose_or_none(frame.estimated[k]),
            _age(now, float(cycle.observation.stamps[k])),
            _pose_or_none(commands[k]) or (0.0, 0.0, 0.0),
            int(frame.status.roles[k]),
            goals[k],
            k in lost,
            tuple(line_of(fault) for (robot, _), fault in faults.items() if robot == k),
        )
        for k, name in enumerate(names)
    )


def state_of(
    planner: PlannerStatus, goals: bool, stopped: bool, coming: bool, arrived: bool
) -> str:
    """The team's state, of a planner's; `coming`: whether its task has changed since."""
    if stopped:
        return "stopped"
    if planner.state in ("paused", "stale"):
        return planner.state
    if not goals:
        return "idle"
    if coming and planner.state in ("inactive", "final", "stuck", "infeasible"):
        return "partial"  # the planner's state is of what was to be done before
    return "arrived" if arrived else planner.state


def message_of(
    planner: PlannerStatus, cause: tuple[str, ...], trouble: str, names: Sequence[str]
) -> str:
    """What happened, and what to do."""
    if cause:
        estop = any(line.startswith("e-stop") for line in cause)
        lift = "call reset_stop, then resume" if estop else "call resume"
        why = "; ".join(cause)
        if trouble and trouble not in why:
            why += f" ({trouble})"
        return f"stopped: {why}. When it is over, {lift}"
    if planner.message and planner.involved:
        who = ", ".join(names[robot] for robot in planner.involved)
        return f"{planner.message} ({who})"
    return planner.message or trouble


def line_of(fault: Fault, names: Sequence[str] = ()) -> str:
    """A fault in a line, with its robot's name if there are names."""
    who = f": {names[fault.robot]}" if fault.robot is not None and names else ""
    return f"{fault.kind}{who}" + (f" ({fault.detail})" if fault.detail else "")


def _age(now: float, stamp: float) -> float | None:
    return now - stamp if math.isfinite(stamp) and math.isfinite(now) else None


def _pose_or_none(row: Array) -> Pose | None:
    """A pose `(3,)` in plain numbers, None where it holds nonsense."""
    x, y, yaw = (float(value) for value in row)
    return (x, y, yaw) if all(map(math.isfinite, (x, y, yaw))) else None


def _plain(value: Any) -> Any:
    if value is None:
        return None
    if isinstance(value, float):
        return round(value, DIGITS) if math.isfinite(value) else None
    return [_plain(float(part)) for part in value]
