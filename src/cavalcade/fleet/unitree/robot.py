"""The fleet's side of one Go2: its helper process, its pose and what is wrong with it."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time

from cavalcade.fleet.protocol import Fault
from cavalcade.fleet.trend import Pose, PoseTrend
from cavalcade.fleet.unitree.link import Go2Link
from cavalcade.fleet.unitree.records import Order, Report, SharedRecords, Stage, Wish
from cavalcade.fleet.unitree.sdk import SPORT_STATE
from cavalcade.fleet.unitree.sport import meaning_of, name_of, posture_of

LINK_DOWN = 0.5
"""A robot of which nothing was heard for so long, s, is not connected."""

_HELPER = 0.5
"""A helper process that shows no sign of life for so long, s, has stopped."""

_RIVAL = 1.0
"""Another program that told it to move so long ago, s, may do so again; a real one streams."""

_FALLEN = 1.0
"""A trunk that is rolled or pitched by more, rad, has fallen; stairs and slopes are below 0.7."""

_ENDING = 15.0
"""How long a helper may take to end: a robot that lies down takes its time, s."""


class Robot:
    """One robot. The fleet's lock is held by whoever calls."""

    def __init__(
        self, number: int, name: str, link: Go2Link, start: Pose | None, epoch: float
    ) -> None:
        self.number = number
        self.name = name
        self.link = link
        self._start = start
        self._epoch = epoch  # of the fleet's clock, on the monotonic one
        self._offset = link.offset
        self._records = SharedRecords()
        self._process: subprocess.Popen[bytes] | None = None
        self._lifeline: int | None = None
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 - closed by `close`
        self._wish = Wish.WAIT
        self._wishes = 0
        self._external: tuple[Pose, float] | None = None
        self._report: Report | None = None
        self.trend = PoseTrend()

    def launch(self, damp: bool) -> None:
        """Start the helper process; a second call does nothing."""
        if self._process is not None:
            return
        ours, theirs = os.pipe()
        self._lifeline = theirs
        link, memory = self.link, self._records.file
        arguments = [str(memory), str(ours), str(link.domain), link.interface or ""]
        try:
            self._process = subprocess.Popen(
                [
                    *(sys.executable, "-m", "cavalcade.fleet.unitree.helper_process"),
                    *(*arguments, "damp" if damp else "stop"),
                ],
                pass_fds=(memory, ours),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._messages,
                start_new_session=True,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )
        finally:
            os.close(ours)

    def wish(self, wish: Wish, velocity: Pose = (0.0, 0.0, 0.0)) -> None:
        """Say what the robot is to do; the same again is the same wish."""
        if wish is not self._wish:
            self._wish = wish
            self._wishes += 1
        order = Order(time.monotonic(), wish, self._wishes, *velocity)
        self._records.order.write(order)

    @property
    def wished(self) -> Wish:
        """What it is to do."""
        return self._wish

    def look(self) -> None:
        """Take over what the helper knows."""
        report = self._records.report.read()
        if report is None:
            return
        self._report = report
        if report.heard and self._offset is None and self._start is not None:
            self.anchor()
        pose, stamp = self.pose()
        if all(map(math.isfinite, pose)):
            self.trend.add(stamp, pose)

    def anchor(self) -> None:
        """The robot stands at its start now, where no offset says otherwise."""
        report = self._report
        if self._start is None or self.link.offset is not None or report is None:
            return
        x, y, yaw = self._start
        turn = yaw - report.yaw
        c, s = math.cos(turn), math.sin(turn)
        self._offset = (x - c * report.x + s * report.y, y - s * report.x - c * report.y, turn)
        self.trend.clear()

    def hand_in(self, pose: Pose, stamp: float) -> None:
        """Take a pose of somebody who sees the robot; one that was overtaken is not used."""
        newest = -math.inf if self._external is None else self._external[1]
        # One that is stamped later than now has overtaken nobody.
        if stamp >= newest or newest > time.monotonic() + self._epoch:
            self._external = pose, stamp

    def pose(self) -> tuple[Pose, float]:
        """Where it was last, map frame, and when, s of the fleet's clock."""
        nowhere = ((math.nan, math.nan, math.nan), -math.inf)
        if self.link.pose_source == "external":
            return self._external or nowhere
        report = self._report
        if report is None or not report.heard or self._offset is None:
            return nowhere
        x0, y0, turn = self._offset
        c, s = math.cos(turn), math.sin(turn)
        yaw = math.remainder(turn + report.yaw, 2.0 * math.pi)
        x, y = x0 + c * report.x - s * report.y, y0 + s * report.x + c * report.y
        return (x, y, yaw), report.heard + self._epoch

    @property
    def stage(self) -> Stage:
        """How far it is with what was wished last."""
        report = self._report
        if report is None or report.number != self._wishes:
            return Stage.LISTENING
        return Stage(report.stage)

    @property
    def failed(self) -> bool:
        """Whether it will not get any further by waiting."""
        return self.stage is Stage.FAILED or bool(self._gone())

    def missing(self) -> str:
        """What is missing of it before it can be driven, in words; empty if nothing is."""
        who = self.name
        if gone := self._gone():
            return f"{who}: {gone}"
        report = self._report
        if report is None or not report.heard:
            return (
                f"{who}: nothing was heard on {SPORT_STATE}, {self.link.place}: is it on, is the "
                "cable in, and is this computer in the robot's network (192.168.123.x)?"
            )
        if self.link.pose_source == "external" and self._external is None:
            return f"{who}: no pose was handed in (set_pose)"
        return ""

    def faults(self) -> list[Fault]:
        """What is wrong with it now."""
        report, now = self._report, time.monotonic()
        if gone := self._gone():
            return [Fault(self.number, "helper", gone)]
        if report is None or not report.heard:
            return [Fault(self.number, "link-down", f"nothing was heard yet, {self.link.place}")]
        found = []
        if now - report.beat > _HELPER:
            found.append(("helper", f"no sign of life for {now - report.beat:.1f} s"))
        elif now - report.heard > LINK_DOWN:
            lost = f"no state for {now - report.heard:.1f} s, {self.link.place}"
            found.append(("link-down", lost))
        elif report.failed_api and self._wish is not Wish.WAIT:
            found.append(("api-error", self.refusal()))
        if report.rival and now - report.rival < _RIVAL:
            found.append(("second-commander", "another program tells it to move: stop that"))
        if 0.0 <= report.charge < self.link.battery_min:
            least = f"{report.charge:.0f} %, {self.link.battery_min:g} % are asked for"
            found.append(("battery-low", least))
        if tilt := self.fallen():
            found.append(("fallen", tilt))
        elif self._wish is Wish.DAMP:
            found.append(("damping", "as ordered; start has it stand up again"))
        elif self._wish is Wish.MOVE:
            posture = posture_of(report.error_code, report.mode)
            if posture != "ready":
                found.append((posture, "start it again once it is safe to stand up"))
        return [Fault(self.number, kind, detail) for kind, detail in found]

    def fallen(self) -> str:
        """How it lies where it should stand; empty if it does not."""
        report = self._report
        if report is None or max(abs(report.roll), abs(report.pitch)) <= _FALLEN:
            return ""
        return f"roll {math.degrees(report.roll):.0f}°, pitch {math.degrees(report.pitch):.0f}°"

    def refusal(self) -> str:
        """Which request failed last, and why; empty if none did."""
        report = self._report
        if report is None or not report.failed_api:
            return ""
        name, code = name_of(report.failed_api), report.failed_code
        if not code:
            state = f"state {report.error_code}, mode {report.mode}"
            return f"{name} was agreed to but not done ({state})"
        return f"{name}: code {code}, {meaning_of(code)}"

    def leave(self, lie_down: bool) -> None:
        """Have the helper stop the robot and end."""
        if self._wish is not Wish.LEAVE:
            self.wish(Wish.LIE if lie_down else Wish.LEAVE)

    def close(self) -> None:
        """Wait until the helper has ended, and let go of all."""
        if self._process is not None:
            try:
                self._process.wait(_ENDING)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        if self._lifeline is not None:
            os.close(self._lifeline)
            self._lifeline = None
        self._messages.close()

    def _gone(self) -> str:
        """Why there is no helper any more; empty while there is one."""
        if self._process is None:
            return "was not started"
        code = self._process.poll()
        if code is None:
            return ""
        if self._messages.closed:
            return "its helper process has ended"
        self._messages.seek(0)
        said = self._messages.read()[-2000:].decode(errors="replace").strip().splitlines()
        why = f": {said[-1]}" if said else ""
        return said[-1] if code == 2 and said else f"its helper process ended with {code}{why}"
