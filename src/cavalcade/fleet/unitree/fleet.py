"""Unitree Go2s behind the interface of every fleet."""

from __future__ import annotations

import atexit
import math
import threading
import time
from collections.abc import Callable, Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import FleetError, InputError
from cavalcade.fleet.protocol import Observation
from cavalcade.fleet.schedule import Schedule
from cavalcade.fleet.unitree.link import Go2Link
from cavalcade.fleet.unitree.records import Stage, Wish
from cavalcade.fleet.unitree.robot import Robot
from cavalcade.fleet.unitree.sdk import load_sdk
from cavalcade.geometry import Array
from cavalcade.values import instances_of, number_array, number_in, whole_number

Silence = Literal["stop", "damp"]

_LOOK = 0.02
"""How often robots are looked at while they are waited for, s."""

_LAST = 1e11
"""Stamps are before this, s."""


class Go2Fleet:
    """A `LiveFleet` of Unitree Go2s, each driven by a helper process of its own.

    A helper streams the newest command 50 times a second. It stops its robot when nothing was
    sent for 0.5 s and when this process dies. Faults of the observation: `link-down` (no state
    for 0.5 s), `api-error` (the robot refuses a request), `battery-low`, `fallen`, `damping`,
    `lying` and `locked` (the robot does not stand ready to walk, such as after a press on its
    remote control), `second-commander` (another program tells the robot to move) and `helper` (the
    process has ended or does not answer).

    True poses are the last reported ones, true velocities the trend of those of the last second.
    Time is that of the wall when the fleet was made, and goes on evenly from there.

    Args:
        links: Where the robots are.
        starts: `(N, 3)` poses x, y in m, yaw in rad at which they stand when they are started;
            needed for odometry without an offset of its own.
        silence: What a helper does without a fleet: have the robot `stop`, or `damp` its motors
            besides, so that it sinks to the ground.
        lie_down: Whether robots lie down at the end; otherwise they stay standing.
        names: What the robots are called in errors; None numbers them.

    Raises:
        InputError: The SDK is not there, two robots share a place, or a start is missing.
    """

    def __init__(
        self,
        links: Sequence[Go2Link],
        *,
        starts: ArrayLike | None = None,
        silence: Silence = "stop",
        lie_down: bool = False,
        names: Sequence[str] | None = None,
    ) -> None:
        self.links = instances_of(links, Go2Link, "links", "a list of Go2Link")
        _check_distinct(self.links)
        if silence not in get_args(Silence):
            raise InputError(
                "what is done without a fleet", key="silence", choices=("stop", "damp")
            )
        count = len(self.links)
        known: list[tuple[float, float, float] | None] = [None] * count
        if starts is not None:
            rows = number_array(starts, "starts", (count, 3), f"({count}, 3) poses")
            known = [(x, y, yaw) for x, y, yaw in rows.tolist()]
        for index, link in enumerate(self.links):
            if link.pose_source == "sport" and link.offset is None and known[index] is None:
                text = "expected an offset, or starts: odometry alone says no place on the map"
                raise InputError(text, key=f"links[{index}].offset")
        load_sdk()
        self._epoch = time.time() - time.monotonic()
        self._damp = silence == "damp"
        self._lie_down = bool(lie_down)
        called = [f"robot {index}" for index in range(count)] if names is None else list(names)
        if len(called) != count:
            raise InputError(f"expected {count}, one per robot", key="names")
        self._robots = [
            Robot(index, called[index], link, known[index], self._epoch)
            for index, link in enumerate(self.links)
        ]
        self._lock = threading.RLock()
        self._schedule = Schedule()
        self._anchored = False
        self._closed = False

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.links)

    @property
    def time(self) -> float:
        """s; it never jumps."""
        return time.monotonic() + self._epoch

    def connect(self, timeout: float) -> None:
        """Wait until every robot has been heard; nobody moves.

        Raises:
            FleetError: Somebody was not heard within `timeout` s; it says who and where.
        """
        number_in(timeout, "timeout", 0.0)
        with self._lock:
            if self._closed:
                raise FleetError("the fleet is closed")
            for robot in self._robots:
                robot.launch(self._damp)
        atexit.register(self.close)
        self._wait(timeout, lambda: [robot.missing() for robot in self._robots])

    def start(self, timeout: float) -> None:
        """Connect, and have all robots stand up, ready to walk; after `damp`, once more.

        Robots that stand ready are left as they are.

        Raises:
            FleetError: Somebody was not heard, or did not stand up within `timeout` s, or must
                not, or was damped meanwhile; it says who and why. Nobody stands up where one must
                not.
        """
        end = time.monotonic() + timeout
        self.connect(timeout)
        with self._lock:
            self._look()
            unfit = [
                f"{fault.kind}: {robot.name} ({fault.detail})"
                for robot in self._robots
                for fault in robot.faults()
                if fault.kind in ("battery-low", "fallen")
            ]
        if unfit:
            raise FleetError("robots must not stand up: " + ", ".join(unfit))
        if all(robot.wished is Wish.MOVE and not robot.faults() for robot in self._robots):
            return
        with self._lock:
            for robot in self._robots:
                robot.wish(Wish.WAIT)  # a wish that comes again is a new one

        def standing() -> list[str]:
            self._check_damped()
            for robot in self._robots:
                robot.wish(Wish.STAND)
            return [_standing(robot) for robot in self._robots]

        self._wait(max(end - time.monotonic(), 0.0), standing)
        with self._lock:
            self._check_damped()
            if not self._anchored:
                for robot in self._robots:
                    robot.anchor()
                self._anchored = True
            for robot in self._robots:
                robot.wish(Wish.MOVE)

    def damp(self, robot: int | None = None) -> None:
        """Damp the motors of a robot or, as an e-stop, of all: they sink to the ground.

        Commands have no effect until `start` has them stand up again.
        """
        chosen = self._robots
        if robot is not None:
            chosen = [self._robots[whole_number(robot, "robot", 0, self.size - 1)]]
        with self._lock:
            for one in chosen:
                if not self._closed:
                    one.wish(Wish.DAMP)

    def close(self) -> None:
        """Command all robots to stop, or to lie down, and leave; a second call does nothing."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            for robot in self._robots:
                robot.leave(self._lie_down and robot.wished is not Wish.DAMP)
        atexit.unregister(self.close)
        for robot in self._robots:
            robot.close()

    def set_pose(self, robot: int, pose: ArrayLike, stamp: float | None = None) -> None:
        """Say where a robot with the pose source `external` is; from any thread.

        Args:
            robot: Which.
            pose: x, y in m, yaw in rad, map frame. Nan says that it was not seen.
            stamp: When that was measured, s of the fleet's clock; None for now.

        Raises:
            InputError: There is no such robot, or it is located by its odometry.
        """
        one = self._robots[whole_number(robot, "robot", 0, self.size - 1)]
        if one.link.pose_source != "external":
            raise InputError("is located by its odometry", key=f"robot {robot}")
        x, y, yaw = number_array(pose, "pose", (3,), "x, y, yaw", math.nan).tolist()
        when = self.time if stamp is None else number_in(stamp, "stamp", -_LAST, _LAST)
        with self._lock:
            one.hand_in((x, y, yaw), when)

    def observe(self) -> Observation:
        """The newest pose of every robot, nan for one that was never located, and its faults."""
        with self._lock:
            self._look()
            reports = [robot.pose() for robot in self._robots]
            faults = tuple(fault for robot in self._robots for fault in robot.faults())
        poses = np.array([pose for pose, _ in reports])
        return Observation(self.time, poses, np.array([stamp for _, stamp in reports]), faults)

    def send(self, commands: ArrayLike) -> None:
        """Command body-frame velocities `(N, 3)`: m/s, m/s, rad/s, to robots that were started.

        Raises:
            InputError: Another shape, or a value that is not finite; nothing is sent then.
        """
        shape = (self.size, 3)
        wanted = number_array(commands, "commands", shape, f"finite commands of shape {shape}")
        with self._lock:
            if self._closed:
                return
            for robot, (x, y, turn) in zip(self._robots, wanted.tolist(), strict=True):
                if robot.wished is Wish.MOVE:
                    robot.wish(Wish.MOVE, (x, y, turn))

    def advance(self, dt: float) -> None:
        """Wait until the next cycle of a fixed rate is due; see `Schedule`.

        Raises:
            InputError: `dt` is not positive and finite.
        """
        self._schedule.wait(dt, lambda: self.time)

    def true_poses(self) -> Array:
        """`(N, 3)` the last reported poses, map frame."""
        with self._lock:
            return np.array([robot.trend.pose for robot in self._robots])

    def true_velocities(self) -> Array:
        """`(N, 3)` the trend of the last poses, map frame: m/s, m/s, rad/s."""
        with self._lock:
            return np.array([robot.trend.velocity() for robot in self._robots])

    def _check_damped(self) -> None:
        """Whoever stands up is not to be pushed on against an e-stop."""
        damped = [robot.name for robot in self._robots if robot.wished is Wish.DAMP]
        if damped:
            raise FleetError(f"{damped[0]} was damped while the team stood up")

    def _look(self) -> None:
        for robot in self._robots:
            robot.look()

    def _wait(self, timeout: float, missing: Callable[[], list[str]]) -> None:
        """Until nothing is missing.

        Raises:
            FleetError: Something still is, or what is missing will not come.
        """
        end = time.monotonic() + timeout
        while True:
            with self._lock:
                if self._closed:
                    raise FleetError("the fleet was closed meanwhile")
                self._look()
                lacks = [text for text in missing() if text]
                failed = any(robot.failed for robot in self._robots)
            if not lacks:
                return
            if failed or time.monotonic() >= end:
                raise FleetError("; ".join(lacks))
            time.sleep(_LOOK)


def _standing(robot: Robot) -> str:
    """What is missing until a robot stands, in words; empty if nothing is."""
    if gone := robot.missing():
        return gone
    if robot.stage is Stage.READY:
        return ""
    why = robot.refusal() or "not yet ready to walk"
    return f"{robot.name} does not stand up: {why}"


def _check_distinct(links: Sequence[Go2Link]) -> None:
    """Refuse a team without robots, and two at one place: they would hear the same requests."""
    if not links:
        raise InputError("expected a robot", key="links")
    known: dict[tuple[int, str | None], int] = {}
    for index, link in enumerate(links):
        place = link.domain, link.interface
        if place in known:
            raise InputError(
                f"robots {known[place]} and {index} are both in {link.place}: their topics are the "
                "same, so each needs a domain or an interface of its own",
                key=f"links[{index}]",
            )
        known[place] = index
