"""Plays the commands of a task: a planner as the control loop takes it."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.execution.policy import Policy
from cavalcade.fleet import LeapingFleet, LeapRequest
from cavalcade.geometry import Array, wrap_angle
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Scenario
from cavalcade.scenario.commands import CommandSection
from cavalcade.world import Terrain

REACHED = 0.10
"""A robot stands as soon as it is this near to where it was sent, m."""

BRAKING = 0.5
"""It slows down before so hard, m/s²."""

ASIDE_GAIN, ASIDE_MOST = 0.6, 0.1
"""Sideways velocity per distance from the straight line, 1/s, and the largest, m/s."""

TURN_GAIN, TURN_MOST = 1.5, 0.6
"""Yaw rate per error of the heading, 1/s, and the largest, rad/s."""

STILL = 1.5
"""After a leap it stands so long, s."""


class CommandPlayer(Policy):
    """Commands each robot what the task says, whatever the others do.

    Its status is `commanded`; `done` when the task's time is over and every robot has been where
    it was sent last; `stuck` when a leap has failed. The task's clock goes on during a pause.
    Robots that are to leap need their fleet as the `leaper`; without `terrain` the ground is level.
    """

    def __init__(
        self,
        scenario: Scenario,
        terrain: Terrain | None = None,
        leaper: LeapingFleet | None = None,
    ) -> None:
        self._leaper = leaper
        self._terrain = terrain
        self._failed: int | None = None
        self._robots = len(scenario.robots)
        every = scenario.task.commands or ()
        self._due: list[list[CommandSection]] = [
            [one for one in every if one.robot in (None, robot)] for robot in range(self._robots)
        ]
        self._length = scenario.task.length
        self._active: list[CommandSection | None] = [None] * self._robots
        self._from: list[Array] = [np.zeros(2)] * self._robots
        self._reached = [True] * self._robots
        self._landed: list[float | None] = [None] * self._robots
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
            point = None if command is None else command.to or command.leap
            sent = point is not None
            places[robot] = self._from[robot] if point is None else point
            paths.append(np.stack([self._from[robot], places[robot]]) if sent else np.zeros((0, 2)))
        return PlannerStatus(
            state="stuck" if self._failed is not None else "done" if done else "commanded",
            roles=np.full(self._robots, -1),
            goals=places,
            paths=tuple(paths),
            eta=np.full(self._robots, max(self._length - self._moment, 0.0)),
            involved=() if self._failed is None else (self._failed,),
            message="" if self._failed is None else f"robot {self._failed} could not leap",
        )

    def step(self, poses: Array, time: float, stamps: Array) -> Array:
        """Poses `(N, 3)` and their times `(N,)` in, body-frame velocities `(N, 3)` out."""
        if self._start is None:
            self._start = time
        self._moment = time - self._start
        commands = np.zeros((self._robots, 3))
        for robot, pose in enumerate(poses):
            if self._leaper is not None and self._leaper.leap_failed[robot]:
                self._failed = robot
            due, new = self._due[robot], None
            while due and due[0].at <= self._moment + 1e-9:
                new = due.pop(0)
            if new is not None:
                self._active[robot] = new
                self._from[robot] = pose[:2].copy()
                self._begin(robot, new, pose)
            command = self._active[robot]
            if command is None:
                self._from[robot] = pose[:2].copy()
            elif command.velocity is not None:
                self._from[robot] = pose[:2].copy()
                commands[robot] = command.velocity
            elif command.to is not None:
                commands[robot] = self._walk(robot, command, pose)
            else:
                self._await(robot)
        return commands

    def _begin(self, robot: int, command: CommandSection, pose: Array) -> None:
        """A command that is new."""
        self._reached[robot] = command.velocity is not None
        if command.leap is None:
            return
        self._landed[robot] = None
        if self._leaper is None or self._leaper.leaping[robot]:
            self._failed = robot
        else:
            self._leaper.leap(robot, leap_request(pose, command.leap, self._terrain))

    def _await(self, robot: int) -> None:
        """Look whether a robot has leapt, and stood for a while."""
        if self._leaper is None or self._leaper.leaping[robot] or self._reached[robot]:
            return
        landed = self._landed[robot]
        if landed is None:
            self._landed[robot] = self._moment
        else:
            self._reached[robot] = self._moment - landed >= STILL

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


def leap_request(pose: Array, point: tuple[float, float], terrain: Terrain | None) -> LeapRequest:
    """A straight leap of a robot at `pose` `(3,)` to where the trunk is to be at `point`, m.

    It goes over the first break of the ground, which is level without `terrain`.
    """
    from cavalcade.execution.leaping import edges_of

    along = np.array(point) - pose[:2]
    heading = math.atan2(along[1], along[0])
    places = np.stack([pose[:2], np.array(point)])
    heights = np.zeros(2) if terrain is None else terrain.heights_at(places)
    first, last = (
        np.array([*place, height, heading]) for place, height in zip(places, heights, strict=True)
    )
    return LeapRequest(first, last, edges_of(terrain, first, last))
