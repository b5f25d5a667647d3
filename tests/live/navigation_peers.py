"""A team's navigation among other processes on a real ROS 2 graph, for tests."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time as wall

from cavalcade.fleet.ros2 import Graph, message_type, qos
from cavalcade.fleet.ros2.messages import fill_header, fill_pose, read_pose, read_twist

SCENARIO = """\
version: 1
name: hall
world:
  empty: {size: [9, 6]}
robots:
  - {start: [1.5, 2.5, 0.0]}
  - {start: [1.5, 3.5, 0.0]}
task:
  formation: {shape: line, spacing: 1.0}
  goals: [[7.0, 3.0, 0.0]]
"""


TEAM = """\
version: 1
name: hall
robots: [{name: robot_0}, {name: robot_1}]
formation: {shape: line, spacing: 1.0}
supervision: {deadline: 1.0}  # the machine may be busy with other things
"""


class Peers:
    """Processes in a domain of their own, and an operator among them who hears everything."""

    def __init__(self, folder) -> None:
        self.folder = folder
        self.scenario = folder / "hall.yaml"
        self.scenario.write_text(SCENARIO)
        self.team = folder / "hall-team.yaml"
        self.team.write_text(TEAM)
        self._running: list[subprocess.Popen] = []
        self.graph = Graph("operator")
        self.status: dict = {}
        self.commands: dict[str, list] = {"robot_0": [], "robot_1": []}
        self.poses: dict[str, tuple] = {}
        self.plans: dict[str, int] = {}
        self.diagnostics: dict = {}
        graph = self.graph
        graph.subscribe("std_msgs/msg/String", "/team/status", self._on_status, qos.latched())
        graph.subscribe(
            "diagnostic_msgs/msg/DiagnosticArray",
            "/diagnostics",
            self._on_diagnostics,
            qos.reliable(),
        )
        for name in self.commands:
            graph.subscribe(
                "geometry_msgs/msg/Twist",
                f"/{name}/cmd_vel",
                lambda m, name=name: self.commands[name].append((wall.monotonic(), read_twist(m))),
                qos.reliable(100),
            )
            graph.subscribe(
                "nav_msgs/msg/Odometry",
                f"/{name}/odom",
                lambda m, name=name: self.poses.__setitem__(
                    name, (read_pose(m.pose.pose), read_twist(m.twist.twist))
                ),
                qos.sensor_data(),
            )
            graph.subscribe(
                "nav_msgs/msg/Path",
                f"/{name}/plan",
                lambda m, name=name: self.plans.__setitem__(name, len(m.poses)),
                qos.latched(),
            )
        pose = "geometry_msgs/msg/PoseStamped"
        self._goal = graph.publisher(pose, "/team/goal_pose", qos.reliable())
        self._robot_goals = {
            name: graph.publisher(pose, f"/{name}/goal_pose", qos.reliable())
            for name in self.commands
        }
        self._path = graph.publisher("nav_msgs/msg/Path", "/team/goals", qos.reliable())
        self._formation = graph.publisher("std_msgs/msg/String", "/team/formation", qos.reliable())
        self._map = graph.publisher("nav_msgs/msg/OccupancyGrid", "/map", qos.latched())

    def close(self) -> None:
        for process in self._running:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self._running:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
        self.graph.close()

    def run(self, *words: str) -> subprocess.Popen:
        """Start a command in a process of its own; its output is kept in files."""
        number = len(self._running)
        with open(self.folder / f"{number}.out", "w") as output:
            process = subprocess.Popen(
                [sys.executable, "-m", "cavalcade", *words],
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        process.output = self.folder / f"{number}.out"
        self._running.append(process)
        return process

    def simulate(self) -> subprocess.Popen:
        process = self.run("ros2", "simulate", str(self.scenario))
        self.until(lambda: len(self.poses) == 2, process)
        return process

    def navigate(self, *words: str, team=None) -> subprocess.Popen:
        self.status = {}
        process = self.run("ros2", "navigate", str(team or self.team), *words)
        state = "unconfigured" if "--wait" in words else "active"
        self.until(lambda: self.status.get("lifecycle") == state, process)
        return process

    def until(self, condition, process=None, limit: float = 60.0) -> None:
        """Wait until it holds; the limit is generous."""
        end = wall.monotonic() + limit
        while not condition():
            ended = process is not None and process.poll() is not None
            if ended or wall.monotonic() > end:
                text = process.output.read_text() if process is not None else ""
                raise AssertionError(f"it did not come to that: {self.status}\n{text}")
            wall.sleep(0.02)

    def send_goal(self, pose, frame="map", robot=None) -> None:
        publisher = self._goal if robot is None else self._robot_goals[robot]
        message = message_type("geometry_msgs/msg/PoseStamped")()
        fill_header(message.header, self.graph.time, frame)
        fill_pose(message.pose, pose)
        self._publish(publisher, message)

    def send_goals(self, poses, frame="map") -> None:
        message = message_type("nav_msgs/msg/Path")()
        fill_header(message.header, self.graph.time, frame)
        for pose in poses:
            stamped = message_type("geometry_msgs/msg/PoseStamped")()
            fill_pose(stamped.pose, pose)
            message.poses.append(stamped)
        self._publish(self._path, message)

    def send_formation(self, text) -> None:
        self._publish(self._formation, message_type("std_msgs/msg/String")(data=text))

    def send_map(self, message) -> None:
        self._publish(self._map, message)

    def call(self, name: str, kind="std_srvs/srv/Trigger", request=None):
        """Call a service of the node `/team/...` and give its answer."""
        service = message_type(kind)
        client = self.graph.node.create_client(service, f"/team/{name}")
        self.until(client.service_is_ready)
        answer = client.call_async(service.Request() if request is None else request)
        self.until(answer.done)
        return answer.result()

    def moving(self) -> bool:
        """Whether the last command of some robot is to go."""
        return any(kept and any(kept[-1][1]) for kept in self.commands.values())

    def standing(self) -> bool:
        """Whether all robots really stand."""
        return all(max(map(abs, velocity)) < 1e-3 for _, velocity in self.poses.values())

    def quiet_since(self, moment: float) -> bool:
        """Whether no robot was told to go after a moment, while commands came."""
        later = [c for kept in self.commands.values() for t, c in kept if t > moment]
        return len(later) > 20 and not any(any(c) for c in later)

    def state(self) -> str:
        return self.status.get("state", "")

    def _publish(self, publisher, message) -> None:
        self.until(lambda: publisher.get_subscription_count() > 0)
        publisher.publish(message)

    def _on_status(self, message) -> None:
        self.status = json.loads(message.data)

    def _on_diagnostics(self, message) -> None:
        for entry in message.status:
            self.diagnostics[entry.name] = (entry.level, entry.message)
