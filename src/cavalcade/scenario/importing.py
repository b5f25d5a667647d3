"""Problem files of other projects as scenarios.

So far those of db-CBS (Moldagalieva et al., 2023; github.com/IMRCLab/db-CBS) and of db-LaCAM,
which has the same format: boxes in a rectangle, robots of a type with start and goal states. The
rectangle bounds the robots' centres there; our ground bounds bodies. It is wider by the largest
body, so that every centre may be where it may be there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cavalcade.errors import ScenarioError
from cavalcade.geometry import CLEARANCE
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
    "unicycle1_v0": ("unicycle", ("x", "y", "yaw")),
    "unicycle1_sphere_v0": ("unicycle-sphere", ("x", "y", "yaw")),
    "unicycle2_v0": ("unicycle-2", ("x", "y", "yaw", "v", "w")),
    "integrator2_2d_v0": ("double-integrator", ("x", "y", "vx", "vy")),
}
"""Their robots, by the names of db-CBS and of db-LaCAM: our model and what their states hold."""

_LEAST_TIME, _TIME_PER_METRE = 180.0, 20.0
_STILL = 1e-6

Corner = tuple[float, float]
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
    for k, (_, *ends) in enumerate(robots):
        for end, pose in zip(("start", "goal"), ends, strict=True):
            if any(not low[i] - _STILL <= pose[i] <= high[i] + _STILL for i in (0, 1)):
                text = "expected a centre within environment.min and environment.max"
                raise ScenarioError(text, key=f"robots[{k}].{end}")
    bodies = [model for model, _, _ in robots]
    origin, size = _ground(low, high, max(_radius(model) for model in bodies))
    farthest = max(math.dist(start[:2], goal[:2]) for _, start, goal in robots)
    empty: dict[str, Any] = {"size": size}
    if origin != (0.0, 0.0):
        empty["origin"] = list(origin)
    return {
        "version": 1,
        "name": name,
        "description": f"db-CBS problem of {len(robots)} robots{_about_bounds(low, high, bodies)}",
        "world": {"empty": empty, "resolution": RESOLUTION, "obstacles": boxes},
        "robots": [
            {"model": model.name, "start": list(start), "goal": list(goal)}
            for model, start, goal in robots
        ],
        "task": {"goals": "individual"},
        "execution": {"timeout": max(_LEAST_TIME, 60.0 + _TIME_PER_METRE * farthest)},
    }


def _corner(environment: dict[str, Any], name: str) -> Corner:
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


def _radius(model: RobotModel) -> float:
    """How far a body reaches from its centre at most, m."""
    return model.length / 2.0 if model.round else math.hypot(model.length, model.width) / 2.0


def _about_bounds(low: Corner, high: Corner, models: Sequence[RobotModel]) -> str:
    """What is said of the ground; by how much centres of narrow bodies may leave the bounds."""
    text = f"; centres there within x {low[0]:g} to {high[0]:g}, y {low[1]:g} to {high[1]:g} m"
    radius = max(_radius(model) for model in models)
    beyond = radius - min(min(model.length, model.width) for model in models) / 2.0
    text += f", so the ground is {radius:.3g} m wider on each side"
    if beyond > RESOLUTION:
        text += f"; narrow bodies can leave the bounds by {beyond:.2g} m"
    return text


def _ground(low: Corner, high: Corner, radius: float) -> tuple[Corner, Corner]:
    """Origin and size, m, of whole cells on which centres reach the published bounds."""
    origin, size = [], []
    for first, last in zip(low, high, strict=True):
        # Outwards to whole cells; what rounding added to an even number is taken off again.
        start = math.floor((first - radius - CLEARANCE) / RESOLUTION + 1e-6)
        stop = math.ceil((last + radius + CLEARANCE) / RESOLUTION - 1e-6)
        origin.append(round(start * RESOLUTION, 6))
        size.append(round((stop - start) * RESOLUTION, 6))
    return (origin[0], origin[1]), (size[0], size[1])
