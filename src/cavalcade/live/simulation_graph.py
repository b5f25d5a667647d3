"""A simulation as a ROS 2 graph in real time: what drivers, scanners and a map server would say."""

from __future__ import annotations

import array
import math
import threading
import time as wall
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cavalcade.fleet.ros2 import Graph, has_message_type, message_type, qos, scenario_robots
from cavalcade.fleet.ros2.messages import (
    VELOCITY_TYPES,
    fill_header,
    fill_map,
    fill_place,
    fill_pose,
    fill_stamp,
    fill_transforms,
    fill_twist,
    read_twist,
)
from cavalcade.live.laser import RAYS, REACH
from cavalcade.live.robot_frames import RobotFrames, Transform
from cavalcade.live.simulation import STEP, Simulation
from cavalcade.robots import JOINT_NAMES

REPORTS, SCANS = 0.02, 0.1
"""How often poses, odometry, transforms and joints are told, and scans, s of simulated time."""

_SLOW = 0.95
"""Of the asked pace: what is slower is said."""

_WATCH = 5.0
"""Over how long the pace is measured, s of the wall's time."""

_BEHIND = 0.1
"""Who is later than this has lost that time for good, s of the wall's time."""


class SimulationGraph:
    """Robots `robot_0`, `robot_1` and so on with their topics, `/clock` and `/map`.

    They listen to `/robot_k/cmd_vel`. Poses are PoseStamped on `/robot_k/pose` with the scenario's
    noise, delay and loss; `/robot_k/odom` has the true pose and velocity, in `map`, and so have
    the transforms `map` -> `robot_k/base_link` -> `robot_k/FL_hip` and so on, which are called as
    the links of `/robot_k/robot_description`. Stamps are simulated time, which begins at the
    wall's.

    Args:
        simulation: Whose clock nobody else advances.
        stamped: Whether commands are TwistStamped instead of Twist.
        say: Told what happens, line by line.

    Raises:
        InputError: ROS 2 or a type of message is not there.
    """

    def __init__(
        self, simulation: Simulation, *, stamped: bool = False, say: Callable[[str], None]
    ) -> None:
        self._simulation = simulation
        self._say = say
        self._epoch = wall.time()
        self.robots = scenario_robots(simulation.size)
        self.graph = Graph("cavalcade_simulation", on_failure=lambda error: say(f"error: {error}"))
        try:
            self._connect("TwistStamped" if stamped else "Twist")
        except BaseException:
            self.graph.close()
            raise

    def close(self) -> None:
        """Leave the graph."""
        self.graph.close()

    def run(self, stop: threading.Event, speed: float = 1.0) -> None:
        """Let time pass at `speed` times the wall's pace, or as fast as it can, until `stop`.

        Raises:
            InputError: Physics has become unstable.
        """
        pace = _Pace(speed, self._say)
        # Who goes by the wall's clock and not by ours finds poses of now.
        self._epoch = wall.time()
        while not stop.is_set():
            ahead = pace.wait(self._simulation.time)
            if ahead > 0.0:
                stop.wait(ahead)
                continue
            for text in self._simulation.step():
                self._say(f"{self._simulation.time:.2f} s: {text}")
            self._publish()

    def _connect(self, command: str) -> None:
        graph, sensor = self.graph, qos.sensor_data()
        self._clock = _Channel(graph, "rosgraph_msgs/msg/Clock", "/clock", qos.clock())
        self._poses, self._odoms, self._joints, self._scans = [], [], [], []
        names = [robot.namespace[1:] for robot in self.robots]
        self._frames = list(map(RobotFrames, self._simulation.models, names))
        kept: list[Any] = []
        for number, (robot, frames) in enumerate(zip(self.robots, self._frames, strict=True)):
            topic, base = robot.topic, frames.base
            pose = _Channel(graph, "geometry_msgs/msg/PoseStamped", topic("pose"), sensor)
            odom = _Channel(graph, "nav_msgs/msg/Odometry", topic("odom"), sensor)
            odom.message.child_frame_id = base
            joints = _Channel(
                graph, "sensor_msgs/msg/JointState", topic("joint_states"), qos.reliable()
            )
            joints.message.name = list(JOINT_NAMES)
            scan = _Channel(graph, "sensor_msgs/msg/LaserScan", topic("scan"), sensor)
            scan.message.header.frame_id = base
            scan.message.angle_min = -math.pi
            scan.message.angle_increment = 2.0 * math.pi / RAYS
            scan.message.angle_max = math.pi - scan.message.angle_increment
            scan.message.scan_time = SCANS
            scan.message.range_max = REACH
            self._poses.append(pose)
            self._odoms.append(odom)
            self._joints.append(joints)
            self._scans.append(scan)
            graph.subscribe(
                VELOCITY_TYPES[command],
                topic("cmd_vel"),
                partial(self._hear, number),
                qos.reliable(1),
            )
            said = _Channel(graph, "std_msgs/msg/String", topic("robot_description"), qos.latched())
            said.message.data = frames.urdf
            said.publish()
            kept.append(said)
        area = _Channel(graph, "nav_msgs/msg/OccupancyGrid", "/map", qos.latched())
        fill_header(area.message.header, self._epoch, "map")
        fill_stamp(area.message.info.map_load_time, self._epoch)
        fill_map(area.message, self._simulation.world.map)
        area.publish()
        kept.append(area)
        self._tf: _Channel | None = None
        self._transform_type = message_type("geometry_msgs/msg/TransformStamped")
        if has_message_type("tf2_msgs/msg/TFMessage"):
            self._tf = _Channel(graph, "tf2_msgs/msg/TFMessage", "/tf", qos.reliable(100))
            fixed = _Channel(graph, "tf2_msgs/msg/TFMessage", "/tf_static", qos.latched())
            places = [place for frames in self._frames for place in frames.fixed]
            fill_transforms(fixed.message, self._epoch, places, self._transform_type)
            fixed.publish()
            kept.append(fixed)
        else:
            self._say("tf2_msgs is not there: no transforms on /tf")
        self._kept = tuple(kept)  # for those who come later

    def _hear(self, robot: int, message: Any) -> None:
        twist = message.twist if hasattr(message, "twist") else message
        self._simulation.command(robot, read_twist(twist))

    def _publish(self) -> None:
        """Tell what is due now."""
        simulation, now = self._simulation, self._epoch + self._simulation.time
        steps = round(simulation.time / STEP)
        fill_stamp(self._clock.message.clock, now)
        self._clock.publish()
        if steps % round(REPORTS / STEP) == 0:
            simulation.measure()
        for robot, pose, stamp in simulation.reports():
            channel = self._poses[robot]
            fill_header(channel.message.header, self._epoch + stamp, "map")
            fill_pose(channel.message.pose, pose)
            channel.publish()
        if steps % round(REPORTS / STEP) == 0:
            self._publish_bodies(now)
        if steps % round(SCANS / STEP) == 0:
            for channel, ranges in zip(self._scans, simulation.scan(), strict=True):
                fill_stamp(channel.message.header.stamp, now)
                channel.message.ranges = array.array("f", ranges.astype(np.float32).tobytes())
                channel.publish()

    def _publish_bodies(self, now: float) -> None:
        simulation = self._simulation
        trunks, velocities = simulation.trunks(), simulation.body_velocities()
        for number, channel in enumerate(self._odoms):
            message = channel.message
            fill_header(message.header, now, "map")
            held = message.pose.pose
            fill_place(held.position, held.orientation, trunks[number])
            fill_twist(message.twist.twist, velocities[number])
            channel.publish()
        joints = simulation.joints()
        for channel, legs in zip(self._joints, joints, strict=True):
            if legs is not None:
                fill_stamp(channel.message.header.stamp, now)
                channel.message.position, channel.message.velocity = (
                    array.array("d", values.tolist()) for values in legs
                )
                channel.publish()
        if self._tf is not None:
            places: list[Transform] = []
            for frames, trunk, legs in zip(self._frames, trunks, joints, strict=True):
                places.append(("map", frames.base, trunk))
                places += frames.legs(None if legs is None else legs[0])
            fill_transforms(self._tf.message, now, places, self._transform_type)
            self._tf.publish()


class _Channel:
    """A publisher with the one message that it publishes anew."""

    def __init__(self, graph: Graph, kind: str, topic: str, profile: Any) -> None:
        self.message: Any = message_type(kind)()
        self._publisher = graph.publisher(kind, topic, profile)

    def publish(self) -> None:
        self._publisher.publish(self.message)


class _Pace:
    """Keeps simulated time at a multiple of the wall's, and says when it cannot."""

    def __init__(self, speed: float, say: Callable[[str], None]) -> None:
        self._speed = speed
        self._say = say
        self._anchor: tuple[float, float] | None = None
        self._mark: tuple[float, float] | None = None
        self._slow = False

    def wait(self, time: float) -> float:
        """How long the wall's clock has to go on before the next step is due, s."""
        now = wall.monotonic()
        if self._anchor is None or self._mark is None:
            self._anchor = self._mark = now, time
        self._watch(now, time)
        began, start = self._anchor
        ahead = began + (time + STEP - start) / self._speed - now
        if ahead < -_BEHIND:
            self._anchor = now, time
        return ahead

    def _watch(self, now: float, time: float) -> None:
        since, start = self._mark or (now, time)
        if now - since < _WATCH:
            return
        factor = (time - start) / (now - since)
        slow = factor < _SLOW * self._speed
        if slow:
            self._say(f"slower than asked: {factor:.2f} times real time, not {self._speed:g}")
        elif self._slow:
            self._say(f"at the asked pace again: {factor:.2f} times real time")
        self._slow, self._mark = slow, (now, time)
