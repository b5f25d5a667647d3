"""What is known of one robot from its reports."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from cavalcade.fleet.ros2.messages import Pose, PoseReport
from cavalcade.fleet.ros2.robot import Ros2Robot
from cavalcade.geometry import Array

AHEAD = 0.1
"""Stamps may be ahead of the clock by this, s: clocks of two computers never agree exactly."""

_TREND = 1.0
"""Velocities are the trend of the poses in so many seconds."""

_FEW = 3
"""Reports without which there is no trend."""

_NOWHERE = (math.nan, math.nan, math.nan)


class PoseTrack:
    """The newest report of a robot, what is wrong with it, and how fast the robot is."""

    def __init__(self, robot: Ros2Robot) -> None:
        self._robot = robot
        self.pose: Pose = _NOWHERE
        self.stamp = -math.inf
        self.heard = False
        self._frame: str | None = None
        self._ahead = 0.0
        self._past: deque[tuple[float, float, float, float]] = deque()

    def hear(self, report: PoseReport, now: float) -> None:
        """Take a report over that comes at `now` s."""
        if report.frame != self._robot.frame.removeprefix("/"):
            self._frame = report.frame
            return
        self._frame = None
        if report.stamp != 0.0 and report.stamp < self.stamp <= now + AHEAD:
            return  # overtaken on its way; of one without a stamp nobody knows
        if report.stamp < self.stamp:  # the clock was set back
            self._past.clear()
        self.pose, self.stamp, self.heard = report.pose, report.stamp, True
        self._ahead = report.stamp - now
        if all(map(math.isfinite, report.pose)):
            self._keep(report)

    def missing(self) -> str:
        """What is missing so that the robot can be located; empty if nothing is."""
        robot = self._robot
        if self._frame is not None:
            return f"{robot.name}: {self._wrong_frame()}"
        kind = "" if robot.pose_type == "tf" else f" ({robot.pose_type})"
        return "" if self.heard else f"{robot.name}: nothing was heard on {robot.pose_source}{kind}"

    def fault(self, now: float) -> tuple[str, str] | None:
        """Kind and detail of what is wrong with its reports, None if nothing is."""
        if self._frame is not None:
            return "frame", self._wrong_frame()
        if self.heard and self.stamp == 0.0 and now > AHEAD:
            return "stamp", f"poses on {self._robot.pose_source} have no stamp"
        if self.heard and self._ahead > AHEAD:
            ahead = f"stamped {self._ahead:.2f} s ahead of the clock"
            return "stamp", f"{ahead}: synchronise the computers' clocks, or set use_sim_time"
        return None

    @property
    def sound_pose(self) -> Pose:
        """The last pose without nan; zeros if there was none."""
        return self._past[-1][1:] if self._past else (0.0, 0.0, 0.0)

    def velocity(self) -> Pose:
        """The trend of its poses, map frame: m/s, m/s, rad/s; zeros where there is none."""
        if len(self._past) < _FEW:
            return 0.0, 0.0, 0.0
        rows: Array = np.array(self._past)
        time = rows[:, 0] - rows[:, 0].mean()
        spread = float(time @ time)
        if spread <= 0.0:
            return 0.0, 0.0, 0.0
        rows[:, 3] = np.unwrap(rows[:, 3])
        vx, vy, rate = (float(value) for value in time @ (rows[:, 1:] - rows[-1, 1:]) / spread)
        return vx, vy, rate

    def _keep(self, report: PoseReport) -> None:
        past = self._past
        past.append((report.stamp, *report.pose))
        while past[0][0] < report.stamp - _TREND:
            past.popleft()

    def _wrong_frame(self) -> str:
        robot = self._robot
        said = f"{self._frame!r}" if self._frame else "no frame"
        return f"poses on {robot.pose_source} are in {said}, not in {robot.frame!r}"
