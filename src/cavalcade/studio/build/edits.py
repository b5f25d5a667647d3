"""Changes of a draft that concern several of its parts at once; plain data in and out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from cavalcade.errors import InputError
from cavalcade.execution.formation_policy import formation_of
from cavalcade.geometry import transform_points
from cavalcade.robots import robot_model
from cavalcade.scenario import FormationSection, PlannerSection, World
from cavalcade.scenario.ground import TERRAIN_OPTIONS
from cavalcade.scenario.rules import UNUSED_KEYS
from cavalcade.scenario.task import INDIVIDUAL
from cavalcade.studio.build.draft import Checked, Draft
from cavalcade.studio.build.placing import Pose, ends, is_free, stand

Data = dict[str, Any]

SIZES = {"square": "side", "triangle": "side", "circle": "radius"}
"""What the size of a shape is called; of all others it is `spacing`."""

LARGEST_TEAM = 64


def usual_shape(robots: int) -> str:
    """The shape that a team of so many robots gets where nothing else is said."""
    return {3: "triangle", 4: "square"}.get(robots, "column" if robots < 3 else "wedge")


def with_team(state: Checked, model: str, count: int, shape: str | None = None) -> Data:
    """The data with a new team in a shape, and with a goal where there is none.

    Raises:
        InputError: There is no room, or no such team.
    """
    if not 1 <= count <= LARGEST_TEAM:
        raise InputError(f"expected 1 to {LARGEST_TEAM} robots, got {count}", key="robots")
    data, models = state.data, [robot_model(model)] * count
    formation = {"shape": shape or usual_shape(count)}
    start, goal = _ends(state.world, formation, count)
    if is_individual(data) or models[0].legs is None or state.shown.world.has_heights:
        starts, goals = (
            stand(state.world, slots_at(formation, count, end), models) for end in (start, goal)
        )
        robots = [
            {"model": model, "start": list(here), "goal": list(there)}
            for here, there in zip(starts, goals, strict=True)
        ]
        return {**without_formation(data), "robots": robots}
    kept = [list(pose) for pose in state.goals] or [list(goal)]
    centre = _mean([pose for _, pose in state.robots]) if state.robots else start
    centre = (*centre[:2], _towards(centre, kept[0]))
    starts = stand(state.world, slots_at(formation, count, centre), models)
    robots = [{"model": model, "start": list(pose)} for pose in starts]
    return {**data, "robots": robots, "task": {"formation": formation, "goals": kept}}


def with_formation(state: Checked) -> Data:
    """The data with one formation and its goal in the place of individual goals."""
    data = state.data
    robots = [_without(one, ("goal",)) for one in data.get("robots") or ()]
    task: Data = {"goals": [list(_mean(state.goals))]} if state.goals else {}
    if robots:
        task["formation"] = {"shape": usual_shape(len(robots))}
    planner = _without(data.get("planner"), ("method", "variant", *UNUSED_KEYS["formation"]))
    return {**data, "robots": robots, "task": task, "planner": planner}


def with_individual_goals(state: Checked) -> Data:
    """The data with a goal for each robot, which it has relative to the others as its start.

    Raises:
        InputError: There is no room at the goal.
    """
    data = state.data
    robots = [dict(one) for one in data.get("robots") or ()]
    if robots and not is_individual(data):
        shape = {"shape": usual_shape(len(robots))}
        there = state.goals[-1] if state.goals else _ends(state.world, shape, len(robots))[1]
        centre = _mean([pose for _, pose in state.robots])
        dx, dy = there[0] - centre[0], there[1] - centre[1]
        wanted = [(x + dx, y + dy, there[2]) for _, (x, y, _) in state.robots]
        placed = stand(state.world, wanted, [model for model, _ in state.robots])
        for robot, pose in zip(robots, placed, strict=True):
            robot["goal"] = list(pose)
    return {**without_formation(data), "robots": robots}


def without_formation(data: Mapping[str, Any]) -> Data:
    """The data with individual goals, without what has no meaning for them."""
    planner = _without(data.get("planner"), ("method", "variant", *UNUSED_KEYS["individual"]))
    execution = _without(data.get("execution"), ("events", "noise", "delay"))
    return {**data, "task": {"goals": INDIVIDUAL}, "planner": planner, "execution": execution}


def with_world(draft: Draft, world: Mapping[str, Any]) -> Data:
    """The draft's data on another ground; a team that cannot stand there is placed anew.

    Raises:
        InputError: The ground cannot be made, or has no room for the team.
    """
    data = {**draft.data, "world": dict(world)}
    team = data.get("robots") or []
    bare = _without(data, ("robots", "task"))
    if is_individual(data) or _has_heights(world):
        bare = without_formation(bare)
    ground = draft.check(bare)
    if not team:
        return ground.data
    if is_individual(bare) == is_individual(data):
        try:
            kept = draft.check(data)
        except InputError as error:
            if not (error.key or "").startswith("robots["):
                raise
        else:
            if _reachable(kept):
                return kept.data
    shape = ((data.get("task") or {}).get("formation") or {}).get("shape")
    fitting = None if shape == "custom" else shape
    return with_team(ground, team[0].get("model", "go1"), len(team), fitting)


def without_robot(state: Checked, index: int) -> Data:
    """The data without one robot, in a shape that the others can take up."""
    robots = list(state.data["robots"])
    del robots[index]
    return _with_robots(state, robots)


def with_robot(state: Checked, model: str, pose: Pose) -> Data:
    """The data with one robot more, in a shape that all can take up."""
    robot: Data = {"model": model, "start": list(pose)}
    if is_individual(state.data):
        robot["goal"] = list(pose)
    return _with_robots(state, [*(state.data.get("robots") or ()), robot])


def _with_robots(state: Checked, robots: list[Data]) -> Data:
    data = {**state.data, "robots": robots}
    if is_individual(data) or not robots:
        return data
    task = dict(data.get("task") or {})
    if task.get("commands"):
        return data
    formation = task.get("formation") or {}
    count = FormationSection.model_validate(formation).slot_count if formation else 0
    if count is not None and count != len(robots):
        task["formation"] = {"shape": usual_shape(len(robots))}
    return {**data, "task": task}


def slots_at(formation: Mapping[str, Any], count: int, pose: Pose) -> list[Pose]:
    """Where the robots of a formation stand whose centre is at a pose."""
    section = FormationSection.model_validate(dict(formation))
    slots = formation_of(section, count, PlannerSection()).slots
    return [(float(x), float(y), pose[2]) for x, y in transform_points(pose, slots)]


def _ends(world: World, formation: Mapping[str, Any], count: int) -> tuple[Pose, Pose]:
    slots = slots_at(formation, count, (0.0, 0.0, 0.0))
    return ends(world, max(math.hypot(x, y) for x, y, _ in slots) + 0.4)


def is_individual(data: Mapping[str, Any]) -> bool:
    """Whether each robot has a goal of its own."""
    return (data.get("task") or {}).get("goals") == INDIVIDUAL


def _has_heights(world: Mapping[str, Any]) -> bool:
    generated = world.get("generate") or {}
    return "terrain" in world or generated.get("kind") in TERRAIN_OPTIONS


def _reachable(state: Checked) -> bool:
    """Whether all goals are on free ground."""
    goals = [pose[:2] for pose in state.goals]
    return not goals or bool(is_free(state.world.map, goals).all())


def _without(section: Mapping[str, Any] | None, keys: Sequence[str]) -> Data:
    return {key: value for key, value in (section or {}).items() if key not in keys}


def _mean(poses: Sequence[Pose]) -> Pose:
    count = len(poses)
    x, y = (round(sum(pose[i] for pose in poses) / count, 2) for i in (0, 1))
    return x, y, poses[0][2]


def _towards(start: Sequence[float], goal: Sequence[float]) -> float:
    dx, dy = goal[0] - start[0], goal[1] - start[1]
    return round(math.atan2(dy, dx), 3) if math.hypot(dx, dy) > 0.1 else start[2]
