"""Plays the commands of a task: a planner as the control loop takes it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cavalcade.errors import InputError
from cavalcade.formation.status import PlannerStatus
from cavalcade.geometry import Array, wrap_angle
from cavalcade.scenario import Scenario
from cavalcade.scenario.commands import CommandSection

REACHED = 0.10
"""A robot stands as soon as it is this near to where it was sent, m."""

BRAKING = 0.5
"""It slows down before so hard, m/s²."""

ASIDE_GAIN, ASIDE_MOST = 0.6, 0.1
"""Sideways velocity per distance from the straight line, 1/s, and the largest, m/s."""

TURN_GAIN, TURN_MOST = 1.5, 0.6
"""Yaw rate per error of the heading, 1/s, and the largest, rad/s."""


class CommandPlayer:
    """Commands each robot what the task says, whatever the others do.

    Its status is `final`, and `done` when the task's time is over and every robot has been where
    it was sent last.

    Args:
        scenario: Its task has commands.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._robots = len(scenario.robots)
        every = scenario.task.commands or ()
        self._due: list[list[CommandSection]] = [
            [one for one in every if one.robot in (None, robot)] for robot in range(self._robots)
        ]
        self._length = scenario.task.length
        self._active: list[CommandSection | None] = [None] * self._robots
        self._from: list[Array] = [np.zeros(2)] * self._robots
        self._reached = [True] * self._robots
        self._start: float | None = None
        self._moment = 0.0

    @property
    def status(self) -> PlannerStatus:
        """Of the last cycle."""
        waiting = [bool(due) for due in self._due]
        there = all(self._reached) and not any(waiting)
        done = there and self._moment >= self._length - 1e-9
        places = np.full((self._robots, 2), np.nan)
        paths: list[Array] = []
        for robot, command in enumerate(self._active):
            sent = command is not None and command.to is not None
            places[robot] = command.to if command is not None and sent else self._from[robot]
            paths.append(np.stack([self._from[robot], places[robot]]) if sent else np.zeros((0, 2)))
        return PlannerStatus(
            state="done" if done else "final",
            leader=-1,
            roles=np.full(self._robots, -1),
            slots=np.zeros((0, 2)),
            goals=places,
            goal=None,
            paths=tuple(paths),
            connections=np.zeros((0, 2), dtype=np.int64),
            eta=np.full(self._robots, max(self._length - self._moment, 0.0)),
            arrived=done,
            waypoint=0,
            goal_moved=0.0,
            involved=(),
            message="",
        )

    def step(self, poses: Array, time: float, stamps: Array) -> Array:
        """Poses `(N, 3)` and their times `(N,)` in, body-frame velocities `(N, 3)` out."""
        if self._start is None:
            self._start = time
        self._moment = time - self._start
        commands = np.zeros((self._robots, 3))
        for robot, pose in enumerate(poses):
            due = self._due[robot]
            while due and due[0].at <= self._moment + 1e-9:
                self._active[robot] = due.pop(0)
                self._from[robot] = pose[:2].copy()
                self._reached[robot] = self._active[robot].to is None  # type: ignore[union-attr]
            command = self._active[robot]
            if command is None:
                self._from[robot] = pose[:2].copy()
            elif command.velocity is not None:
                self._from[robot] = pose[:2].copy()
                commands[robot] = command.velocity
            else:
                commands[robot] = self._walk(robot, command, pose)
        return commands

    def _walk(self, robot: int, command: CommandSection, pose: Array) -> Array:
        """Velocity on the straight line to a point, and what leads back to it."""
        target, begin = np.array(command.to), self._from[robot]
        left = math.dist(target, pose[:2])
        self._reached[robot] |= left <= REACHED
        length = math.dist(target, begin)
        if self._reached[robot] or length <= REACHED:
            return np.zeros(3)
        along = (target - begin) / length
        aside = float(along[0] * (pose[1] - begin[1]) - along[1] * (pose[0] - begin[0]))
        error = float(wrap_angle(math.atan2(along[1], along[0]) - pose[2]))
        ahead = float(along @ (target - pose[:2]))
        if ahead <= 0.0:  # it has gone past, aside of it: from here
            self._from[robot] = pose[:2].copy()
        # It turns first where it looks elsewhere.
        speed = min(command.pace, math.sqrt(2.0 * BRAKING * left)) * max(math.cos(error), 0.0)
        back = min(max(-ASIDE_GAIN * aside, -ASIDE_MOST), ASIDE_MOST) * max(math.cos(error), 0.0)
        turn = min(max(TURN_GAIN * error, -TURN_MOST), TURN_MOST)
        c, s = math.cos(error), math.sin(error)
        return np.array([c * speed - s * back, s * speed + c * back, turn])

    def pause(self) -> None:
        """Stop until `resume`; the task's clock goes on."""

    def resume(self) -> None:
        """Go on with what is to be done by now."""

    def update_map(self, map: Any) -> None:
        """Commands know no map."""

    def set_moving_obstacles(self, obstacles: Sequence[Any]) -> None:
        """Commands know no obstacles."""

    def set_goals(self, goals: Sequence[Sequence[float]]) -> None:
        """Commands have no goals."""
        raise InputError("the task has commands, not goals")

    def set_formation(self, formation: Any) -> None:
        """Commands have no formation."""
        raise InputError("the task has commands, not a formation")

    def lose(self, robot: int) -> None:
        """Commands are for all robots."""
        raise InputError("the task has commands; no robot can be lost")

    def rejoin(self, robot: int) -> None:
        """Commands are for all robots."""
        raise InputError("the task has commands; no robot can come back")
