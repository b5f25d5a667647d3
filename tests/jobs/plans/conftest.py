from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cavalcade.coordination.result import TeamPlan
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, WALK, Trajectory
from cavalcade.jobs.planning import make_plan
from cavalcade.robots import RobotModel
from cavalcade.scenario import Scenario, World, build_world, parse_scenario, resolve_scenario

STEP = 0.025


def straight(start: Sequence[float], goal: Sequence[float], wait: float = 0.0) -> Trajectory:
    """Straight ahead with trapezoid speed (1 m/s², 0.75 m/s) after `wait` s; the yaws agree."""
    start, goal = np.array(start, dtype=float), np.array(goal, dtype=float)
    way = goal[:2] - start[:2]
    length = float(np.hypot(*way))
    top = min(0.75, np.sqrt(length))
    moving = length / top + top
    edges = np.array([0.0, wait, wait + top, wait + moving - top, wait + moving])
    parts = [
        np.linspace(a, b, int(np.ceil((b - a) / STEP)) + 1)[1:]
        for a, b in pairwise(edges)
        if b - a > 1e-9
    ]
    time = np.concatenate([[0.0], *parts])
    t = np.clip(time - wait, 0.0, moving)
    along = np.where(t < top, 0.5 * t**2, top * (t - 0.5 * top))
    along = np.where(t > moving - top, length - 0.5 * (moving - t) ** 2, along)
    speed = np.minimum(np.minimum(t, moving - t), top)
    ahead = way / length
    return Trajectory(
        time,
        np.column_stack([start[:2] + along[:, None] * ahead, np.full(len(time), 0.3)]),
        np.column_stack([speed[:, None] * ahead, np.zeros(len(time))]),
        np.full(len(time), start[2]),
        np.full(len(time), WALK, dtype=np.int8),
    )


def with_leap(path: Trajectory) -> Trajectory:
    """The same way with a leap in its middle, 0.15 s in the air."""
    middle = 0.5 * path.duration
    time = path.time
    phase = np.full(len(time), WALK, dtype=np.int8)
    for name, a, b in ((TAKE_OFF, -0.3, -0.075), (FLIGHT, -0.075, 0.075), (LANDING, 0.075, 0.3)):
        phase[(time >= middle + a - 1e-9) & (time < middle + b - 1e-9)] = name
    air = np.flatnonzero(phase == FLIGHT)
    first, last = time[air[0]], time[air[-1] + 1]
    t = np.clip(time - first, 0.0, last - first)
    position = path.position.copy()
    position[:, 2] += 0.5 * 9.81 * t * (last - first - t)
    return Trajectory(time, position, path.velocity, path.yaw, phase)


@pytest.fixture
def straight_way() -> Callable[..., Trajectory]:
    """Straight from a pose to another after a wait."""
    return straight


@pytest.fixture(scope="session")
def crowd() -> Callable[[int], tuple[list[Trajectory], list[RobotModel]]]:
    """Plans of six Go1s that cross 6 x 6 m from places to places drawn at random."""

    @cache
    def make(seed: int) -> tuple[list[Trajectory], list[RobotModel]]:
        scenario = crowd_scenario(seed)
        made = make_plan(scenario, build_world(scenario))
        assert made.solved
        return [path for path in made.trajectories if path is not None], list(scenario.models)

    return make


def crowd_scenario(seed: int, robots: int = 6, size: float = 6.0) -> Scenario:
    rng = np.random.default_rng(seed)
    places: list[list[float]] = []
    for last in (robots, 2 * robots):
        first = len(places)
        while len(places) < last:
            x, y = np.round(rng.uniform(0.6, size - 0.6, 2), 2).tolist()
            if all(np.hypot(x - u, y - v) > 1.0 for u, v, _ in places[first:]):
                places.append([x, y, round(float(rng.uniform(-3.0, 3.0)), 2)])
    return resolve_scenario(
        parse_scenario(
            {
                "version": 1,
                "name": "crowd",
                "world": {"empty": {"size": [size, size]}},
                "robots": [
                    {"model": "go1", "start": start, "goal": goal}
                    for start, goal in zip(places[:robots], places[robots:], strict=True)
                ],
                "task": {"goals": "individual"},
            }
        )
    )


@pytest.fixture
def make_scenario() -> Callable[..., Scenario]:
    """Two robots whose ways cross on free ground of 8 x 6 m; arguments go over its parts."""

    def make(
        robots: Sequence[tuple[Sequence[float], Sequence[float]]] | None = None,
        model: str = "spirit",
        world: dict[str, Any] | None = None,
        **planner: Any,
    ) -> Scenario:
        ways = robots or [
            ((1.0, 3.0, 0.0), (7.0, 3.0, 0.0)),
            ((4.0, 1.0, np.pi / 2), (4.0, 5.0, np.pi / 2)),
        ]
        return parse_scenario(
            {
                "version": 1,
                "name": "crossing",
                "world": world or {"empty": {"size": [8, 6]}},
                "robots": [
                    {"model": model, "start": list(start), "goal": list(goal)}
                    for start, goal in ways
                ],
                "task": {"goals": "individual"},
                "planner": planner,
                "execution": {"timeout": 40},
            }
        )

    return make


@pytest.fixture
def straight_team() -> Callable[..., Callable[[Scenario, World], TeamPlan]]:
    """Makes a coordinator: all go straight, each after its `waits`; `leaping` robots leap."""

    def make(
        waits: Sequence[float] = (0.0, 4.0), leaping: Sequence[int] = ()
    ) -> Callable[[Scenario, World], TeamPlan]:
        def coordinate(scenario: Scenario, world: World) -> TeamPlan:
            paths = []
            for robot, (start, goal) in enumerate(
                zip(scenario.starts, scenario.goals, strict=True)
            ):
                wait = waits[robot] if robot < len(waits) else 0.0
                path = straight(start, goal, wait)
                paths.append(with_leap(path) if robot in leaping else path)
            return TeamPlan("solved", "", (), tuple(paths), "cbs", 7, 0.25, {"nodes": 3})

        return coordinate

    return make


@pytest.fixture
def no_plan() -> Callable[[Scenario, World], TeamPlan]:
    """A coordinator that finds a proof that there is no plan."""

    def coordinate(scenario: Scenario, world: World) -> TeamPlan:
        none = (None,) * len(scenario.robots)
        return TeamPlan("infeasible", "the goal of robot 1 is shut off", (1,), none, "cbs", 0, 0.01)

    return coordinate
