"""What a team's navigation shows on a ROS 2 graph: status, plans, markers and diagnostics."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from cavalcade.fleet.ros2 import Graph, message_type, qos
from cavalcade.fleet.ros2.messages import fill_header, fill_path, fill_pose
from cavalcade.geometry import Array
from cavalcade.live.status import RobotStatus, TeamStatus
from cavalcade.live.team_file import Team
from cavalcade.recording.colors import NO_SLOT, SLOT_COLORS
from cavalcade.recording.frames import Frame, thinned

_MARKER = "visualization_msgs/msg/Marker"
_CUBE, _SPHERE, _LINE_STRIP, _LINE_LIST, _TEXT = 1, 2, 4, 5, 9
_ADD, _DELETE_ALL = 0, 3

_RED = (0.8, 0.0, 0.0)

OK, WARN, ERROR, STALE = b"\x00", b"\x01", b"\x02", b"\x03"
"""Levels of diagnostic_msgs/DiagnosticStatus."""

_BAD = ("stopped", "stuck", "infeasible", "stale")


class Ros2Views:
    """Publishers of a node in the namespace `team`, and what they publish.

    Args:
        graph: The node.
        team: Whose robots they are about.
    """

    def __init__(self, graph: Graph, team: Team) -> None:
        self._team = team
        latched = qos.latched()
        self._status = graph.publisher("std_msgs/msg/String", "status", latched)
        self._markers = graph.publisher("visualization_msgs/msg/MarkerArray", "markers", latched)
        self._diagnostics = graph.publisher(
            "diagnostic_msgs/msg/DiagnosticArray", "/diagnostics", qos.reliable()
        )
        self._plans = [
            graph.publisher("nav_msgs/msg/Path", f"/{name}/plan", latched) for name in team.names
        ]
        self._string = message_type("std_msgs/msg/String")
        self._path = message_type("nav_msgs/msg/Path")
        self._pose_stamped = message_type("geometry_msgs/msg/PoseStamped")
        self._point = message_type("geometry_msgs/msg/Point")
        self._marker_array = message_type("visualization_msgs/msg/MarkerArray")
        self._marker = message_type(_MARKER)
        self._array = message_type("diagnostic_msgs/msg/DiagnosticArray")
        self._diagnostic = message_type("diagnostic_msgs/msg/DiagnosticStatus")
        self._key_value = message_type("diagnostic_msgs/msg/KeyValue")

    def show_status(self, lifecycle: str, status: TeamStatus) -> None:
        """The JSON of a status, with the state of the node's life cycle."""
        said = {"lifecycle": lifecycle, **status.to_dict()}
        self._status.publish(self._string(data=json.dumps(said, allow_nan=False)))

    def show_plans(self, frame: Frame, now: float) -> None:
        """The path that each robot follows; an empty one where it follows none."""
        for publisher, path in zip(self._plans, frame.status.paths, strict=True):
            message = self._path()
            fill_header(message.header, now, self._team.frame)
            fill_path(message, thinned(path), self._pose_stamped)
            publisher.publish(message)

    def show_markers(self, frame: Frame, status: TeamStatus, now: float) -> None:
        """Bodies in the colours of their slots, red in trouble; names, goals, plans and springs."""
        found = [self._new(0, "clear", _CUBE, now)]
        found[0].action = _DELETE_ALL
        for k, robot in enumerate(status.robots):
            if robot.pose is not None:
                found += self._robot_markers(k, robot, frame, now)
        found += self._goal_markers(status, now)
        pairs = frame.status.connections
        for k, path in enumerate(frame.status.paths):
            if len(path) > 1:
                found.append(self._lines(k, "plans", _LINE_STRIP, thinned(path), now))
        if len(pairs):
            ends = np.nan_to_num(frame.poses[np.asarray(pairs).ravel(), :2])
            found.append(self._lines(0, "springs", _LINE_LIST, ends, now))
        self._markers.publish(self._marker_array(markers=found))

    def show_diagnostics(self, lifecycle: str, status: TeamStatus, now: float) -> None:
        """One entry for the team, one for each robot, with cause and ages."""
        array = self._array()
        fill_header(array.header, now, "")
        level, text = OK, status.message or status.state
        if status.cause:
            level = ERROR
        elif status.state in _BAD or status.refused or status.recording or status.message:
            level = WARN
        if lifecycle != "active":
            level, text = STALE, lifecycle + (f": {status.message}" if status.message else "")
        elif status.refused and not status.cause:
            text = f"refused: {status.refused}"
        pace = {
            f"{name} p99 ms": figures["p99"]
            for name, figures in status.pace.items()
            if isinstance(figures, dict)
        }
        array.status.append(
            self._entry(
                "",
                level,
                text,
                {
                    "state": status.state,
                    "mode": status.mode,
                    "cause": "; ".join(status.cause),
                    "dry run": status.dry_run,
                    "recording": status.recording,
                    "cycles": status.pace.get("cycles", 0),
                    "missed deadlines": status.pace.get("missed", 0),
                    **pace,
                },
            )
        )
        for robot in status.robots:
            array.status.append(self._robot_entry(lifecycle, robot))
        self._diagnostics.publish(array)

    def _robot_entry(self, lifecycle: str, robot: RobotStatus) -> Any:
        level, text = OK, "located"
        if lifecycle != "active":
            level, text = STALE, lifecycle
        elif robot.faults:
            level, text = ERROR, "; ".join(robot.faults)
        elif robot.lost:
            level, text = ERROR, "lost: the others go on without it"
        age = "never heard" if robot.age is None else f"{robot.age:.3f}"
        vx, vy, rate = robot.command
        values = {"pose age s": age, "command": f"{vx:.2f} {vy:.2f} {rate:.2f}"}
        return self._entry(f": {robot.name}", level, text, values)

    def _entry(self, name: str, level: bytes, text: str, values: dict[str, Any]) -> Any:
        entry = self._diagnostic()
        entry.name = f"cavalcade {self._team.name}{name}"
        entry.hardware_id = self._team.name
        entry.level, entry.message = level, text
        entry.values = [self._key_value(key=key, value=str(v)) for key, v in values.items()]
        return entry

    def _robot_markers(self, k: int, robot: RobotStatus, frame: Frame, now: float) -> list[Any]:
        pose, model = robot.pose or (0.0, 0.0, 0.0), self._team.models[k]
        colour = NO_SLOT if robot.slot < 0 else SLOT_COLORS[robot.slot % len(SLOT_COLORS)]
        if robot.faults or robot.lost:
            colour = _RED
        body = self._new(k, "robots", _CUBE, now)
        fill_pose(body.pose, pose, 0.15)
        body.scale.x, body.scale.y, body.scale.z = model.length, model.width, 0.2
        _paint(body, colour, 0.8)
        name = self._new(k, "names", _TEXT, now)
        fill_pose(name.pose, pose, 0.6)
        name.scale.z = 0.25
        name.text = f"{robot.name} (lost)" if robot.lost else robot.name
        _paint(name, (0.1, 0.1, 0.1), 1.0)
        goal = self._new(k, "partial_goals", _SPHERE, now)
        x, y = (float(value) for value in frame.status.goals[k])
        if not (math.isfinite(x) and math.isfinite(y)):
            return [body, name]
        fill_pose(goal.pose, (x, y, 0.0), 0.1)
        goal.scale.x = goal.scale.y = goal.scale.z = 0.15
        _paint(goal, colour, 0.9)
        return [body, name, goal]

    def _goal_markers(self, status: TeamStatus, now: float) -> list[Any]:
        """Goals of the formation's centre and of single robots."""
        goals = [*status.goals, *(r.goal for r in status.robots if r.goal is not None)]
        found = []
        for number, goal in enumerate(goals):
            marker = self._new(number, "goals", _CUBE, now)
            fill_pose(marker.pose, goal, 0.02)
            marker.scale.x, marker.scale.y, marker.scale.z = 0.4, 0.1, 0.02
            _paint(marker, (0.0, 0.6, 0.2), 0.9)
            found.append(marker)
        return found

    def _lines(self, number: int, space: str, kind: int, points: Array, now: float) -> Any:
        marker = self._new(number, space, kind, now)
        marker.scale.x = 0.02
        _paint(marker, NO_SLOT, 0.7)
        marker.points = [self._point(x=x, y=y, z=0.05) for x, y in points.tolist()]
        return marker

    def _new(self, number: int, space: str, kind: int, now: float) -> Any:
        marker = self._marker()
        fill_header(marker.header, now, self._team.frame)
        marker.ns, marker.id, marker.type, marker.action = space, number, kind, _ADD
        marker.pose.orientation.w = 1.0
        return marker


def _paint(marker: Any, colour: tuple[float, float, float], alpha: float) -> None:
    marker.color.r, marker.color.g, marker.color.b = colour
    marker.color.a = alpha
