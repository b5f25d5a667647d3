"""Stand-ins for what a draft lacks, so that the rest of it can be checked and shown."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from cavalcade.scenario import FormationSection
from cavalcade.scenario.task import INDIVIDUAL


def completed(data: Mapping[str, Any]) -> dict[str, Any]:
    """The data with a robot, a formation and goals where these can be added yet.

    A shape that takes another number of robots is replaced, too: robots come one by one. What is
    there and wrong stays wrong.
    """
    filled = copy.deepcopy(dict(data))
    if filled.get("robots") in (None, []):
        filled["robots"] = [{"start": [0.0, 0.0, 0.0]}]
    if filled.get("task") is None:
        filled["task"] = {}
    robots, task = filled["robots"], filled["task"]
    if not isinstance(robots, list) or not isinstance(task, dict) or task.get("commands"):
        return filled
    if task.get("goals") == INDIVIDUAL:
        for robot in robots:
            if isinstance(robot, dict) and robot.get("goal") is None and "start" in robot:
                robot["goal"] = robot["start"]
        return filled
    if task.get("goals") in (None, []):
        task["goals"] = [[0.0, 0.0, 0.0]]
    formation = task.get("formation")
    if formation is None or _of_others(formation, len(robots)):
        task["formation"] = {"shape": "column"}
    return filled


def _of_others(formation: Any, robots: int) -> bool:
    """Whether this is a shape, but one for another number of robots."""
    try:
        count = FormationSection.model_validate(formation).slot_count
    except ValidationError:
        return False
    return count is not None and count != robots
