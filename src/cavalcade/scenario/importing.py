"""Problem files of other projects as scenarios.

So far those of db-CBS (Moldagalieva et al., 2023; github.com/IMRCLab/db-CBS): boxes in a
rectangle, robots of a type with start and goal states. They bound the robots' centres; we bound
bodies, so the ground is widened as far as the bodies at starts and goals need.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cavalcade.errors import ScenarioError
from cavalcade.geometry import rectangle_corners
from cavalcade.robots import RobotModel, robot_model
from cavalcade.scenario.loading import parse_scenario
from cavalcade.scenario.messages import short
from cavalcade.scenario.model import Scenario
from cavalcade.scenario.shipped import read_text
from cavalcade.yaml_text import parse_yaml

RESOLUTION = 0.025
"""Cells of imported worlds, m: they are small and their gaps are."""

_KNOWN = "db-CBS problems (environment with min, max and obstacles; robots with type, start, goal)"

_TYPES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "unicycle_first_order_0": ("unicycle", ("x", "y", "yaw")),
    "unicycle_first_order_0_sphere": ("unicycle-sphere", ("x", "y", "yaw")),
    "unicycle_second_order_0": ("unicycle-2", ("x", "y", "yaw", "v", "w")),
    "single_integrator_0": ("single-integrator", ("x", "y")),
    "double_integrator_0": ("double-integrator", ("x", "y", "vx", "vy")),
}
"""Their robots: our model and what their states hold."""

_LEAST_TIME, _TIME_PER_METRE = 180.0, 20.0
_STILL = 1e-6

Pose = tuple[float, float, float]


def import_problem(file: str | Path) -> Scenario:
    """The scenario of a problem file of another project, told by its content.

    Raises:
        ScenarioError: It is none that is known, it is damaged, or it has robots or obstacles of
            a kind that we lack; the message names them.
    """
    path = Path(file)
    data = parse_yaml(read_text(path), file=str(path))
    if isinstance(data, dict) and "version" in data and "world" in data:
        raise ScenarioError("is a scenario already", file=path)
    if not isinstance(data, dict) or not {"environment", "robots"} <= set(data):
        raise ScenarioError(f"unknown format; known are {_KNOWN}", file=path)
    try:
        said = _from_db_cbs(data, path.stem[:200] or "imported")
    except ScenarioError as error:
        raise error.at(file=path, key=error.key) from None
    return parse_scenario(said, path)


def _from_db_cbs(data: dict[str, Any], name: str) -> dict[str, Any]:
    """The plain data of a scenario, out of those of a db-CBS problem."""
    environment = data["environment"]
    if not isinstance(environment, dict):
        raise ScenarioError("expected a mapping with min, max and obstacles", key="environment")
    low, high = (_corner(environment, end) for end in ("min", "max"))
    obstacles = environment.get("obstacles")
    if obstacles is not None and not isinstance(obstacles, list):
        raise ScenarioError("expected a list of boxes", key="environment.obstacles")
    boxes = [_box(item, k) for k, item in enumerate(obstacles or [])]
    if not isinstance(data["robots"], list) or not data["robots"]:
        raise ScenarioError("expected a list of robots", key="robots")
    robots = [_robot(item, k) for k, item in enumerate(data["robots"])]
    origin, size, widened = _ground(low, high, robots)
    farthest = max(math.dist(start[:2], goal[:2]) for _, start, goal in robots)
    empty: dict[str, Any] = {"size": size}
    if origin != (0.0, 0.0):
        empty["origin"] = list(origin)
    note = ", widened by what bodies at starts and goals need" if widened else ""
    return {
        "version": 1,
        "name": name,
        "description": f"db-CBS problem of {len(robots)} robots; the ground bounds bodies, "
        f"there centres{note}",
        "world": {"empty": empty, "resolution": RESOLUTION, "obstacles": boxes},
        "robots": [
            {"model": model.name, "start": list(start), "goal": list(goal)}
            for model, start, goal in robots
        ],
        "task": {"goals": "individual"},
        "execution": {"timeout": max(_LEAST_TIME, 60.0 + _TIME_PER_METRE * farthest)},
    }


def _corner(environment: dict[str, Any], name: str) -> tuple[float, float]:
    key = f"environment.{name}"
    values = _numbers(environment.get(name), key)
    if len(values) == 3:
        raise ScenarioError("problems in three dimensions have no place here", key=key)
    if len(values) != 2:
        raise ScenarioError("expected [x, y]: 2 numbers", key=key)
    return values[0], values[1]


def _box(item: Any, index: int) -> dict[str, Any]:
    key = f"environment.obstacles[{index}]"
    if not isinstance(item, dict) or item.get("type") != "box":
        kind = short(item.get("type")) if isinstance(item, dict) else short(item)
        raise ScenarioError(f"expected box, got {kind}", key=f"{key}.type")
    center, size = (_numbers(item.get(k), f"{key}.{k}") for k in ("center", "size"))
    if len(center) != 2 or len(size) != 2:
        raise ScenarioError("expected center [x, y] and size [x, y]", key=key)
    return {"box": {"center": center, "size": size}}


def _robot(item: Any, index: int) -> tuple[RobotModel, Pose, Pose]:
    key = f"robots[{index}]"
    kind = item.get("type") if isinstance(item, dict) else None
    if not isinstance(kind, str):
        raise ScenarioError("expected a mapping with type, start and goal", key=key)
    if "trailer" in kind:
        text = f"{short(kind)} has a trailer; robots with trailers are left out"
        raise ScenarioError(text, key=f"{key}.type")
    if kind not in _TYPES:
        text = f"there is no model for {short(kind)}"
        raise ScenarioError(text, key=f"{key}.type", choices=_TYPES)
    name, words = _TYPES[kind]
    start, goal = (_state(item.get(k), words, f"{key}.{k}") for k in ("start", "goal"))
    return robot_model(name), start, goal


def _state(value: Any, words: tuple[str, ...], key: str) -> Pose:
    values = _numbers(value, key)
    if len(values) != len(words):
        raise ScenarioError(f"expected [{', '.join(words)}]: {len(words)} numbers", key=key)
    said = dict(zip(words, values, strict=True))
    x, y, yaw = said.pop("x"), said.pop("y"), said.pop("yaw", 0.0)
    if any(abs(speed) > _STILL for speed in said.values()):
        raise ScenarioError("expected a robot that stands still, with velocities 0", key=key)
    return x, y, yaw


def _numbers(value: Any, key: str) -> list[float]:
    if not isinstance(value, list):
        raise ScenarioError("expected a list of numbers", key=key)
    for item in value:
        valid = isinstance(item, int | float) and not isinstance(item, bool)
        if not valid or not abs(item) <= 1e6:
            raise ScenarioError(f"expected numbers within ±1e6, got {short(item)}", key=key)
    return [float(item) for item in value]


def _ground(
    low: tuple[float, float],
    high: tuple[float, float],
    robots: list[tuple[RobotModel, Pose, Pose]],
) -> tuple[tuple[float, float], tuple[float, float], bool]:
    """Origin and size of the ground in m, whole cells, and whether bodies made it wider."""
    origin, size, widened = [], [], False
    for axis in (0, 1):
        bodies = [_extent(model, pose, axis) for model, *poses in robots for pose in poses]
        first = min(low[axis], *(body[0] for body in bodies))
        last = max(high[axis], *(body[1] for body in bodies))
        widened = widened or first < low[axis] or last > high[axis]
        # Outwards to whole cells; what rounding added to an even number is taken off again.
        start = math.floor(first / RESOLUTION + 1e-6)
        stop = math.ceil(last / RESOLUTION - 1e-6)
        origin.append(round(start * RESOLUTION, 6))
        size.append(round((stop - start) * RESOLUTION, 6))
    return (origin[0], origin[1]), (size[0], size[1]), widened


def _extent(model: RobotModel, pose: Pose, axis: int) -> tuple[float, float]:
    """Least and largest coordinate of a body along an axis, m."""
    if model.round:
        return pose[axis] - model.length / 2.0, pose[axis] + model.length / 2.0
    corners = rectangle_corners(pose, model.length, model.width)[:, axis]
    return float(corners.min()), float(corners.max())
