"""What is known of one robot from its reports."""

from __future__ import annotations

import math

from cavalcade.fleet.ros2.messages import Pose, PoseReport
from cavalcade.fleet.ros2.robot import Ros2Robot
from cavalcade.fleet.trend import PoseTrend

AHEAD = 0.1
"""Stamps may be ahead of the clock by this, s: clocks of two computers never agree exactly."""
AHEAD_OF_TOPIC = 0.5
"""The same where the clock is a topic: a pose may come before the message of its own time."""

_NOWHERE = (math.nan, math.nan, math.nan)


class PoseTrack:
    """The newest report of a robot, what is wrong with it, and the trend of the sound ones."""

    def __init__(self, robot: Ros2Robot) -> None:
        self._robot = robot
        self.pose: Pose = _NOWHERE
        self.stamp = -math.inf
        self.heard = False
        self._frame: str | None = None
        self._ahead = 0.0
        self.trend = PoseTrend()

    def hear(self, report: PoseReport, now: float, margin: float = AHEAD) -> None:
        """Take a report over that comes at `now` s, ahead of which by `margin` s it may be."""
        if report.frame != self._robot.frame.removeprefix("/"):
            self._frame = report.frame
            return
        self._frame = None
        if report.stamp != 0.0 and report.stamp < self.stamp <= now + margin:
            return  # overtaken on its way; of one without a stamp nobody knows
        self.pose, self.stamp, self.heard = report.pose, report.stamp, True
        ahead = report.stamp - now
        self._ahead = ahead if ahead > margin else 0.0
        if all(map(math.isfinite, report.pose)):
            self.trend.add(report.stamp, report.pose)

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
        if self.heard and self._ahead:
            ahead = f"stamped {self._ahead:.2f} s ahead of the clock"
            return "stamp", f"{ahead}: synchronise the computers' clocks, or set use_sim_time"
        return None

    def _wrong_frame(self) -> str:
        robot = self._robot
        said = f"{self._frame!r}" if self._frame else "no frame"
        return f"poses on {robot.pose_source} are in {said}, not in {robot.frame!r}"
