from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.geometry import transform_points, wrap_angle
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Scenario, parse_scenario

HALF = 0.5


class StraightPlanner:
    """Every robot goes straight to its slot: enough of a planner to exercise the loop."""

    def __init__(self, slots: Any, goals: Sequence[Any]) -> None:
        self.slots = np.array(slots, dtype=float)
        self.calls: list[tuple[Any, ...]] = []
        self.paused = False
        self.lost: set[int] = set()
        self.steps = 0
        self.set_goals(goals)
        size = len(self.slots)
        self.status = PlannerStatus(
            state="inactive",
            leader=-1,
            roles=np.arange(size),
            slots=self.slots,
            goals=np.zeros((size, 2)),
            goal=None,
            paths=(),
            connections=np.array([(k, k + 1) for k in range(size - 1)]).reshape(-1, 2),
            eta=np.full(size, np.inf),
            arrived=False,
            waypoint=0,
            goal_moved=0.0,
            involved=(),
            message="",
        )

    def set_goals(self, goals: Sequence[Any]) -> None:
        self.calls.append(("set_goals", tuple(map(tuple, goals))))
        self.goals = [np.array(goal, dtype=float) for goal in goals]
        self.waypoint = 0

    def step(self, poses: np.ndarray, time: float, stamps: np.ndarray | None = None) -> np.ndarray:
        self.steps += 1
        goal = self.goals[self.waypoint]
        targets = transform_points(goal, self.slots)
        active = [k for k in range(len(poses)) if k not in self.lost]
        away = targets - poses[:, :2]
        if np.hypot(*away[active].T).max() < 0.2 and self.waypoint < len(self.goals) - 1:
            self.waypoint += 1
        yaw = poses[:, 2]
        vx = np.cos(yaw) * away[:, 0] + np.sin(yaw) * away[:, 1]
        vy = np.cos(yaw) * away[:, 1] - np.sin(yaw) * away[:, 0]
        roles = np.array([-1 if k in self.lost else k for k in range(len(poses))])
        self.status = replace(
            self.status,
            state="final",
            leader=0,
            roles=roles,
            goals=targets,
            goal=goal,
            paths=tuple(np.linspace(p[:2], t, 60) for p, t in zip(poses, targets, strict=True)),
            eta=np.hypot(*away.T) / HALF,
            waypoint=self.waypoint,
        )
        return np.column_stack([2 * vx, 2 * vy, 2 * wrap_angle(goal[2] - yaw)])

    def pause(self) -> None:
        self.paused = True
        self.calls.append(("pause",))

    def resume(self) -> None:
        self.paused = False
        self.calls.append(("resume",))

    def lose(self, robot: int) -> None:
        self.lost.add(robot)
        self.calls.append(("lose", robot))

    def rejoin(self, robot: int) -> None:
        self.lost.discard(robot)
        self.calls.append(("rejoin", robot))

    def set_formation(self, formation: Any) -> None:
        self.slots = np.array(formation.slots)
        self.calls.append(("set_formation", formation))

    def update_map(self, map: Any) -> None:
        self.calls.append(("update_map", map))

    def set_dynamic_obstacles(self, obstacles: Sequence[Any]) -> None:
        self.calls.append(("set_dynamic_obstacles", list(obstacles)))

    def called(self, name: str) -> list[Any]:
        return [call[1:] for call in self.calls if call[0] == name]


SLOTS = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))


@pytest.fixture
def make_scenario() -> Callable[..., Scenario]:
    """Four robots on free ground of 8 x 6 m; keyword arguments go over parts of it."""

    def make(
        *,
        robots: int = 4,
        goal: tuple[float, float, float] = (5.0, 3.0, 0.0),
        world: dict[str, Any] | None = None,
        planner: dict[str, Any] | None = None,
        **execution: Any,
    ) -> Scenario:
        starts = [(2.0 + x, 3.0 + y, 0.0) for x, y in SLOTS[:robots]]
        return parse_scenario(
            {
                "version": 1,
                "name": "straight",
                "world": {"empty": {"size": [8, 6]}, **(world or {})},
                "robots": [{"start": list(start)} for start in starts],
                "task": {
                    "formation": {"shape": "custom", "slots": [list(s) for s in SLOTS[:robots]]},
                    "goals": [list(goal)],
                },
                "planner": planner or {},
                "execution": {"timeout": 30, **execution},
            }
        )

    return make


@pytest.fixture
def straight() -> Callable[[Scenario, Any], StraightPlanner]:
    """Makes a planner as `run(planner=...)` wants it."""

    def make(scenario: Scenario, world: Any) -> StraightPlanner:
        slots = SLOTS[: len(scenario.robots)]
        return StraightPlanner(slots, scenario.task.goals)

    return make


@pytest.fixture
def go(make_scenario: Callable[..., Scenario], straight: Any) -> Callable[..., Any]:
    """Runs the straight planner; `change` may alter it first."""
    from cavalcade.jobs.running import run

    def run_it(out: Path | None = None, change: Any = None, **options: Any) -> Any:
        fleet = options.pop("fleet", None)
        sinks = options.pop("sinks", ())
        seed = options.pop("seed", None)

        def planner(scenario: Scenario, world: Any) -> Any:
            made = straight(scenario, world)
            return change(made) or made if change is not None else made

        return run(
            make_scenario(**options),
            out,
            planner=planner,
            fleet=fleet,
            sinks=sinks,
            seed=seed,
            figures=False,
            replay=False,
        )

    return run_it
