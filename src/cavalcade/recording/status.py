"""What a policy says about itself after each cycle, and how that is written as text."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array

DIGITS = 6
"""Decimals of numbers in text."""

_RARE = ("slots", "connections", "goal", "involved", "message", "goal_moved", "waypoint", "targets")
"""Written only when they change."""


@dataclass(frozen=True, kw_only=True)
class PlannerStatus:
    """The planner's view of one cycle; positions in the map frame.

    What only formations have may be left out.

    Attributes:
        state: `inactive`, `partial`, `final` (the paper's three), `resolving` (a deadlock is
            being resolved), `paused`, `stale` (a pose is too old), `stopped` (by a supervisor),
            `stuck` or `infeasible`.
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
        involved: Robots that the message is about.
        message: One line for people; empty normally.
        targets: `(N, 3)` poses, where robots have goals of their own; there is no formation then.
    """

    state: str
    leader: int = -1
    roles: NDArray[np.int64]
    slots: Array = field(default_factory=lambda: np.zeros((0, 2)))
    goals: Array
    goal: Array | None = None
    paths: tuple[Array, ...]
    connections: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    eta: Array
    arrived: bool = False
    waypoint: int = 0
    goal_moved: float = 0.0
    involved: tuple[int, ...] = ()
    message: str = ""
    targets: Array | None = None


class StatusEncoder:
    """Makes status after status into text, JSON, without their paths.

    What seldom changes is written only when it does.
    """

    def __init__(self) -> None:
        self._before: dict[str, Any] = {}

    def __call__(self, status: PlannerStatus) -> str:
        """The text of the next status."""
        said: dict[str, Any] = {
            "state": status.state,
            "leader": int(status.leader),
            "roles": np.asarray(status.roles).tolist(),
            "goals": _plain(status.goals),
            "eta": [None if value == np.inf else value for value in _plain(status.eta)],
            "arrived": bool(status.arrived),
            "slots": _plain(status.slots),
            "connections": np.asarray(status.connections).reshape(-1, 2).tolist(),
            "goal": None if status.goal is None else _plain(status.goal),
            "involved": [int(robot) for robot in status.involved],
            "message": status.message,
            "goal_moved": round(float(status.goal_moved), DIGITS),
            "waypoint": int(status.waypoint),
            "targets": None if status.targets is None else _plain(status.targets),
        }
        before, self._before = self._before, said
        kept = {key for key in _RARE if key in before and before[key] == said[key]}
        news = {key: value for key, value in said.items() if key not in kept}
        return json.dumps(news, separators=(",", ":"))


def decoded(texts: Iterable[tuple[str, tuple[Array, ...]]]) -> Iterator[PlannerStatus]:
    """The way back, of each text and the paths of that cycle.

    Raises:
        ValueError, KeyError, TypeError: A text is not what `StatusEncoder` writes.
    """
    rare: dict[str, Any] = {}
    for text, paths in texts:
        said = json.loads(text)
        rare |= {key: said[key] for key in _RARE if key in said}
        goal, targets = rare["goal"], rare.get("targets")
        yield PlannerStatus(
            state=said["state"],
            leader=int(said["leader"]),
            roles=np.array(said["roles"], dtype=np.int64),
            slots=np.array(rare["slots"], dtype=float).reshape(-1, 2),
            goals=np.array(said["goals"], dtype=float).reshape(-1, 2),
            goal=None if goal is None else np.array(goal, dtype=float),
            paths=paths,
            connections=np.array(rare["connections"], dtype=np.int64).reshape(-1, 2),
            eta=np.array([np.inf if v is None else v for v in said["eta"]], dtype=float),
            arrived=bool(said["arrived"]),
            waypoint=int(rare["waypoint"]),
            goal_moved=float(rare["goal_moved"]),
            involved=tuple(int(robot) for robot in rare["involved"]),
            message=str(rare["message"]),
            targets=None if targets is None else np.array(targets, dtype=float),
        )


def _plain(values: Any) -> Any:
    return np.round(np.asarray(values, dtype=float), DIGITS).tolist()
