"""What a team's navigation says of itself, in one piece that does not change."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from cavalcade.geometry import Array

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
        """What is worth telling at once when it changes."""
        lost = tuple(robot.lost for robot in self.robots)
        faults = tuple(robot.faults for robot in self.robots)
        goals = tuple(robot.goal for robot in self.robots)
        return (
            self.state, self.mode, self.cause, self.message, self.refused, self.goals,
            self.waypoint, lost, faults, goals,
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
            "goals": [_plain(goal) for goal in self.goals],
            "waypoint": self.waypoint,
            "goal_moved": _plain(self.goal_moved),
            "leader": self.leader,
            "dry_run": self.dry_run,
            "robots": robots,
            "pace": self.pace,
        }


def pose_or_none(row: Array) -> Pose | None:
    """A pose `(3,)` in plain numbers, None where it holds nonsense."""
    x, y, yaw = (float(value) for value in row)
    return (x, y, yaw) if all(map(math.isfinite, (x, y, yaw))) else None


def _plain(value: Any) -> Any:
    if value is None:
        return None
    if isinstance(value, float):
        return round(value, DIGITS) if math.isfinite(value) else None
    return [_plain(float(part)) for part in value]
