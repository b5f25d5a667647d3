"""Follows planned trajectories: a planner as the control loop takes it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cavalcade.body.trajectory import Trajectory
from cavalcade.errors import InputError
from cavalcade.formation.status import PlannerStatus
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel

POSITION_GAIN = 2.0
"""Velocity per error of the position, 1/s."""

HEADING_GAIN = 3.0
"""Yaw rate per error of the heading, 1/s."""

SIDE_GAIN = 6.0
"""Yaw rate of a unicycle per speed and sideways error, rad/m²."""

_PATH_SPACING = 10
"""Of the samples of a path, every so-many-th is shown."""


class PlanFollower:
    """Commands the velocity of the plan, and corrects what is off.

    The velocity of each cycle is the mean of the plan's until the next one, in the body frame.
    Robots that go in all directions are corrected in all of them; unicycles forwards and by
    turning (Kanayama et al. 1990).

    Args:
        paths: One trajectory per robot, map frame.
        models: Of the robots.
        starts, goals: `(N, 3)` poses.
        rate: Cycles per second.
        refusal: Why there is no plan: nobody moves then, and the status says so.
    """

    def __init__(
        self,
        paths: Sequence[Trajectory | None],
        models: Sequence[RobotModel],
        starts: Sequence[Sequence[float]],
        goals: Sequence[Sequence[float]],
        rate: float,
        refusal: str | None = None,
    ) -> None:
        self._paths = [
            _standing(start) if path is None or refusal is not None else path
            for path, start in zip(paths, starts, strict=True)
        ]
        self._unicycle = np.array([model.drive.startswith("unicycle") for model in models])
        self._period = 1.0 / rate
        self._refusal = refusal
        self._start: float | None = None
        self._targets = np.array(goals, dtype=float).reshape(-1, 3)
        for robot, model in enumerate(models):
            # Where one that goes in all directions looks is of no interest.
            if model.drive.startswith("integrator"):
                self._targets[robot, 2] = self._paths[robot].yaw[-1]
        self._lines = [path.position[::_PATH_SPACING, :2] for path in self._paths]
        self._moments = [path.time[::_PATH_SPACING] for path in self._paths]
        self._status = self._status_at(0.0)

    @property
    def status(self) -> PlannerStatus:
        """Of the last cycle."""
        return self._status

    def step(self, poses: Array, time: float, stamps: Array) -> Array:
        """Poses `(N, 3)` and their times `(N,)` in, body-frame velocities `(N, 3)` out."""
        if self._start is None:
            self._start = time
        now = time - self._start
        self._status = self._status_at(now)
        commands = np.zeros((len(poses), 3))
        if self._refusal is not None:
            return commands
        for robot, path in enumerate(self._paths):
            marks = np.array([now, now + self._period, stamps[robot] - self._start])
            here, there, wanted = path.poses_at(marks)
            rate = (there - here) / self._period
            error = wanted - poses[robot]
            error[2] = wrap_angle(error[2])
            heading = poses[robot, 2]
            if self._unicycle[robot]:
                commands[robot] = _unicycle(rate, error, heading, 0.5 * (here[2] + there[2]))
            else:
                commands[robot] = _free(rate, error, heading, self._period)
        return commands

    def _status_at(self, now: float) -> PlannerStatus:
        size = len(self._paths)
        left = np.array([max(path.duration - now, 0.0) for path in self._paths])
        state = "infeasible" if self._refusal is not None else "final"
        return PlannerStatus(
            state=state,
            leader=-1,
            roles=np.arange(size),
            slots=np.zeros((0, 2)),
            goals=self._targets[:, :2],
            goal=None,
            paths=tuple(
                line[int(np.searchsorted(moments, now)) :]
                for line, moments in zip(self._lines, self._moments, strict=True)
            ),
            connections=np.zeros((0, 2), dtype=np.int64),
            eta=left,
            arrived=bool((left <= 0.0).all()) and self._refusal is None,
            waypoint=0,
            goal_moved=0.0,
            involved=(),
            message=self._refusal or "",
            targets=self._targets,
        )

    def pause(self) -> None:
        """Stop until `resume`."""

    def resume(self) -> None:
        """Go on; the plan's clock has not stood still, so the robots catch up."""

    def set_goals(self, goals: Sequence[Sequence[float]]) -> None:
        """A plan has its goals."""
        raise InputError("the goals of a plan cannot be changed")

    def set_formation(self, formation: Any) -> None:
        """A plan has no formation."""
        raise InputError("a plan has no formation")

    def lose(self, robot: int) -> None:
        """A plan is for all its robots."""
        raise InputError("a plan cannot go on without a robot")

    def rejoin(self, robot: int) -> None:
        """A plan is for all its robots."""
        raise InputError("a plan cannot go on without a robot")

    def update_map(self, map: Any) -> None:
        """A plan is for the world as it was."""
        raise InputError("a plan is for a world that stays as it is")

    def set_moving_obstacles(self, obstacles: Sequence[Any]) -> None:
        """A plan is for the world as it was."""
        raise InputError("a plan is for a world that stays as it is")


def _free(rate: Array, error: Array, heading: float, period: float) -> Array:
    """Command of a robot that goes in all directions, for its heading in mid-period."""
    turn = rate[2] + HEADING_GAIN * error[2]
    x, y = rate[:2] + POSITION_GAIN * error[:2]
    middle = heading + 0.5 * turn * period
    c, s = np.cos(middle), np.sin(middle)
    return np.array([c * x + s * y, c * y - s * x, turn])


def _unicycle(rate: Array, error: Array, heading: float, planned: float) -> Array:
    """Command of a robot that goes forwards, backwards and turns."""
    speed = float(np.cos(planned) * rate[0] + np.sin(planned) * rate[1])
    c, s = np.cos(heading), np.sin(heading)
    ahead, aside = c * error[0] + s * error[1], c * error[1] - s * error[0]
    forwards = speed * np.cos(error[2]) + POSITION_GAIN * ahead
    turn = rate[2] + SIDE_GAIN * speed * aside + HEADING_GAIN * np.sin(error[2])
    return np.array([forwards, 0.0, turn])


def _standing(pose: Sequence[float]) -> Trajectory:
    """A robot that stays where it is."""
    x, y, yaw = pose
    return Trajectory(
        np.zeros(1), np.array([[x, y, 0.0]]), np.zeros((1, 3)), np.array([yaw]),
        np.zeros(1, dtype=np.int8),
    )  # fmt: skip
