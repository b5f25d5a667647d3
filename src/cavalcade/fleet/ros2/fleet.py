"""Robots on a ROS 2 graph behind the interface of every fleet."""

from __future__ import annotations

import atexit
import threading
import time as wall
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import FleetError, InputError
from cavalcade.fleet.protocol import Fault, Observation
from cavalcade.fleet.ros2 import qos
from cavalcade.fleet.ros2.availability import message_type
from cavalcade.fleet.ros2.graph import Graph
from cavalcade.fleet.ros2.messages import (
    POSE_TYPES,
    VELOCITY_TYPES,
    PoseReport,
    fill_header,
    fill_twist,
    read_report,
)
from cavalcade.fleet.ros2.robot import Ros2Robot
from cavalcade.fleet.ros2.tracking import AHEAD, AHEAD_OF_TOPIC, PoseTrack
from cavalcade.fleet.ros2.transforms import TransformPoses
from cavalcade.fleet.schedule import Schedule
from cavalcade.geometry import Array
from cavalcade.values import number_array

_SETTLED = 0.5
"""How long others are looked for once all robots were heard, s."""

_PLACED = 2.0
"""Poses whose stamps fit the clock are waited for so long, s."""

_LOOK = 0.25
"""How often other commanders are looked for, s."""

_ZEROS = 3
"""How often robots are told to stop at the end; a radio may lose one."""


class Ros2Fleet:
    """A `LiveFleet` of robots that publish poses and take velocities on a ROS 2 graph.

    Poses are those of the messages, with their stamps; a message that is older than the last one
    is not used. What is wrong with them are faults of the observation: `frame` (another frame
    than the robot's `frame`), `stamp` (none, or ahead of the clock), `second-commander` (another
    node publishes on the robot's velocity topic) and `ros2` (an error in a callback). Robots are
    commanded as often as `send` is called, and told to stop by `close` and at the process's exit.

    True poses are the last reported ones, true velocities the trend of those of the last second:
    what walking robots and noisy reports say of a moment is not how fast they get on.

    Args:
        robots: Who they are and where they are found.
        name: Of the node.
        use_sim_time: Whether time is that of `/clock`; None: where somebody publishes that when
            the fleet starts.

    Raises:
        InputError: ROS 2 or a type of message is not there, or two robots share a topic.
    """

    def __init__(
        self,
        robots: Sequence[Ros2Robot],
        *,
        name: str = "cavalcade",
        use_sim_time: bool | None = None,
    ) -> None:
        self.robots = tuple(robots)
        _check_distinct(self.robots)
        self._tracks = [PoseTrack(robot) for robot in self.robots]
        self._types = [message_type(VELOCITY_TYPES[robot.velocity_type]) for robot in self.robots]
        for robot in self.robots:
            if robot.pose_type != "tf":
                message_type(POSE_TYPES[robot.pose_type])
        self._lock = threading.Condition()
        self._wanted_sim_time = use_sim_time
        self.graph = Graph(name, use_sim_time=bool(use_sim_time))
        self._schedule = Schedule()
        self._rivals: tuple[Fault, ...] = ()
        self._closed = False
        try:
            self._connect()
        except BaseException:
            self.close()
            raise
        atexit.register(self.close)

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.robots)

    @property
    def time(self) -> float:
        """ROS time, s: that of `/clock` where sim time is used, else the wall's."""
        return self.graph.time

    def start(self, timeout: float) -> None:
        """Wait until every robot has been heard in its frame.

        Raises:
            FleetError: Somebody was not heard within `timeout` s of the wall's time, or not in
                the right frame; it names the robots and their topics.
        """
        end = wall.monotonic() + timeout
        while self._missing() and wall.monotonic() < end:
            with self._lock:
                self._lock.wait(0.05)
            self._look_up()
        if missing := self._missing():
            raise FleetError("; ".join(missing))
        # Who publishes the clock, and who else commands, is known a little later than poses come.
        wall.sleep(min(_SETTLED, max(end - wall.monotonic(), 0.0)))
        if self._wanted_sim_time is None and self.graph.node.count_publishers("/clock"):
            self.graph.use_sim_time(True)
        while self.graph.sim_time and not self.time:
            if wall.monotonic() >= end:
                raise FleetError("no time was heard on /clock, which use_sim_time asks for")
            wall.sleep(0.01)
        # What came before the clock was known was compared with another time.
        until = min(end, wall.monotonic() + _PLACED)
        while self._misplaced() and wall.monotonic() < until:
            wall.sleep(0.01)
        self._look_for_rivals()

    def close(self) -> None:
        """Command all robots to stop and leave the graph; a second call does nothing."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        atexit.unregister(self.close)
        try:
            publishers = getattr(self, "_publishers", [])
            for _ in range(_ZEROS):
                for index in range(len(publishers)):
                    self._publish(index, np.zeros(3))
            self.graph.deliver(*publishers)
        finally:
            self.graph.close()

    def observe(self) -> Observation:
        """The newest pose of every robot, nan for one that was never heard, and its faults."""
        self._look_up()
        now = self.time
        faults: list[Fault] = []
        with self._lock:
            poses = np.array([track.pose for track in self._tracks])
            stamps = np.array([track.stamp for track in self._tracks])
            for index, track in enumerate(self._tracks):
                if found := track.fault(now):
                    faults.append(Fault(index, *found))
            faults += self._rivals
        if self.graph.failure is not None:
            faults.append(Fault(None, "ros2", f"{self.graph.failure!r} in a callback"))
        return Observation(now, poses, stamps, tuple(faults))

    def send(self, commands: ArrayLike) -> None:
        """Command body-frame velocities `(N, 3)`: m/s, m/s, rad/s. After `close` nothing is sent.

        Raises:
            InputError: Another shape, or a value that is not finite; nothing is sent then.
        """
        shape = (self.size, 3)
        wanted = number_array(commands, "commands", shape, f"finite commands of shape {shape}")
        with self._lock:
            if not self._closed:
                for index, command in enumerate(wanted):
                    self._publish(index, command)

    def advance(self, dt: float) -> None:
        """Wait until the next cycle of a fixed rate is due; see `Schedule`.

        Raises:
            InputError: `dt` is not positive and finite.
        """
        self._schedule.wait(dt, lambda: self.time)

    def true_poses(self) -> Array:
        """`(N, 3)` the last reported poses, map frame."""
        with self._lock:
            return np.array([track.trend.pose for track in self._tracks])

    def true_velocities(self) -> Array:
        """`(N, 3)` the trend of the last poses, map frame: m/s, m/s, rad/s."""
        with self._lock:
            return np.array([track.trend.velocity() for track in self._tracks])

    def _connect(self) -> None:
        graph = self.graph
        self._publishers: list[Any] = []
        transforms = []
        for index, robot in enumerate(self.robots):
            command = VELOCITY_TYPES[robot.velocity_type]
            topic = robot.topic(robot.velocity_topic)
            self._publishers.append(graph.publisher(command, topic, qos.reliable(1)))
            if robot.pose_type == "tf":
                transforms.append(index)
            else:
                graph.subscribe(
                    POSE_TYPES[robot.pose_type],
                    robot.pose_source,
                    partial(self._hear_message, index),
                    qos.sensor_data(),
                )
        self._transforms = TransformPoses(graph) if transforms else None
        self._transformed = tuple(transforms)
        graph.every(_LOOK, self._look_for_rivals)

    def _hear_message(self, index: int, message: Any) -> None:
        self._hear(index, read_report(message))

    def _hear(self, index: int, report: PoseReport) -> None:
        now = self.time
        margin = AHEAD_OF_TOPIC if self.graph.sim_time else AHEAD
        with self._lock:
            self._tracks[index].hear(report, now, margin)
            self._lock.notify_all()

    def _look_up(self) -> None:
        """Take over the newest transforms."""
        if self._transforms is not None:
            for index in self._transformed:
                robot = self.robots[index]
                report = self._transforms.newest(robot.frame, robot.base_frame)
                if report is not None:
                    self._hear(index, report)

    def _look_for_rivals(self) -> None:
        """Note who else publishes on a robot's velocity topic."""
        node = self.graph.node
        own = (node.get_name(), node.get_namespace())
        found = []
        for index, robot in enumerate(self.robots):
            topic = robot.topic(robot.velocity_topic)
            if node.count_publishers(topic) < 2:
                continue
            ends = node.get_publishers_info_by_topic(topic)
            names = [(end.node_name, end.node_namespace) for end in ends]
            if own in names:
                names.remove(own)
            told = sorted({_node_name(name, space) for name, space in names})
            if told:
                detail = f"{', '.join(told)} publishes on {topic}, too: stop it"
                found.append(Fault(index, "second-commander", detail))
        with self._lock:
            self._rivals = tuple(found)

    def _misplaced(self) -> bool:
        """Whether somebody's last pose does not fit the clock."""
        self._look_up()
        now = self.time
        with self._lock:
            return any(track.fault(now) or track.stamp > now + 1.0 for track in self._tracks)

    def _missing(self) -> list[str]:
        """What is missing of each robot that was not heard, in words."""
        with self._lock:
            return [text for track in self._tracks if (text := track.missing())]

    def _publish(self, index: int, command: Array) -> None:
        message = self._types[index]()
        robot = self.robots[index]
        if robot.velocity_type == "TwistStamped":
            fill_header(message.header, self.time, robot.base_frame)
            fill_twist(message.twist, command)
        else:
            fill_twist(message, command)
        self._publishers[index].publish(message)


def _node_name(name: str, namespace: str) -> str:
    """A node's whole name; publishers are known a moment before the names of their nodes."""
    if name.startswith("_NODE_NAME_UNKNOWN"):
        return "another node"
    return f"{namespace.rstrip('/')}/{name}"


def _check_distinct(robots: Sequence[Ros2Robot]) -> None:
    """Refuse a team without robots, and two robots that hear the same or are located alike."""
    if not robots:
        raise InputError("expected a robot", key="robots")
    known: dict[str, int] = {}
    for index, robot in enumerate(robots):
        for what in (robot.topic(robot.velocity_topic), robot.pose_source):
            if what in known:
                raise InputError(
                    f"robots {known[what]} and {index} share {what}", key=f"robots[{index}]"
                )
        known |= dict.fromkeys((robot.topic(robot.velocity_topic), robot.pose_source), index)
