"""Poses of a draft that are changed by hand: of robots, of goals and of obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cavalcade.studio.build.draft import Checked, Pose
from cavalcade.studio.build.edits import is_individual, without_robot
from cavalcade.studio.build.obstacles import at_pose, obstacle_at, pose_of, with_obstacle

Data = dict[str, Any]


def pose_at(state: Checked, kind: str, index: int) -> Pose:
    """Where something is."""
    if kind == "robot":
        return state.robots[index][1]
    if kind == "goal":
        return state.goals[index]
    return pose_of(obstacle_at(state, index))


def moved(state: Checked, kind: str, index: int, pose: Sequence[float]) -> Data:
    """The data with something somewhere else; whether it can be there is seen by checking."""
    x, y, yaw = (round(float(value), 3) for value in pose)
    data = state.data
    if kind == "obstacle":
        return with_obstacle(state, at_pose(obstacle_at(state, index), (x, y, yaw)), index)
    if kind == "goal" and not is_individual(data):
        goals = list(data["task"]["goals"])
        goals[index] = [x, y, yaw]
        return {**data, "task": {**data["task"], "goals": goals}}
    robots = list(data["robots"])
    robots[index] = {**robots[index], "start" if kind == "robot" else "goal": [x, y, yaw]}
    return {**data, "robots": robots}


def removed(state: Checked, kind: str, index: int) -> Data:
    """The data without something."""
    data = state.data
    if kind == "robot":
        return without_robot(state, index)
    if kind == "obstacle":
        return with_obstacle(state, None, index)
    if is_individual(data):
        robots = list(data["robots"])
        robots[index] = {key: value for key, value in robots[index].items() if key != "goal"}
        return {**data, "robots": robots}
    goals = list(data["task"]["goals"])
    del goals[index]
    return {**data, "task": {**data["task"], "goals": goals}}
