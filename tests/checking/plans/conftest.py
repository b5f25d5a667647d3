"""Plans made by hand: straight walks, turns, waits and leaps, with footholds, and their scenario.

Walks have trapezoid profiles; the forces of a leap are F(t) = 4 m g f t (T - t) / T², which its
velocities and positions integrate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cavalcade.checking import Report, judge_plan
from cavalcade.robots import MODELS, RobotModel
from cavalcade.scenario import Scenario, parse_scenario

G = 9.81
WALK, TAKE_OFF, FLIGHT, LANDING = range(4)

State = tuple[Any, Any, Any, Any, Any]
"""Way and speed along the heading, height and vertical speed, yaw: `(T,)` each."""


class PlanMaker:
    """One robot's plan, piece after piece, from rest at a pose."""

    def __init__(self, start: Sequence[float], height: float = 0.3, dt: float = 0.03) -> None:
        self.x, self.y, self.yaw = start
        self.dt, self.height, self.time = dt, height, 0.0
        self.rows: list[np.ndarray] = []
        self.phases: list[int] = []
        self.last: np.ndarray | None = None

    def piece(self, duration: float, motion: Callable[..., State], phase: int = WALK) -> PlanMaker:
        """Motion over a duration, from `motion(t)` along the present heading."""
        count = max(math.ceil(duration / self.dt - 1e-9), 1)
        t = np.linspace(0.0, duration, count + 1)
        way, speed, height, rise, yaw = (
            np.broadcast_to(np.asarray(v, float), t.shape) for v in motion(t)
        )
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        rows = np.column_stack(
            (
                self.time + t,
                self.x + c * way,
                self.y + s * way,
                height,
                c * speed,
                s * speed,
                rise,
                self.yaw + yaw,
            )
        )
        self.rows += list(rows[:-1])
        self.phases += [phase] * count
        self.last = rows[-1]
        self.time, self.x, self.y = float(rows[-1, 0]), float(rows[-1, 1]), float(rows[-1, 2])
        self.height, self.yaw = float(rows[-1, 3]), float(rows[-1, 7])
        return self

    def wait(self, duration: float) -> PlanMaker:
        return self.piece(duration, lambda t: (0.0, 0.0, self.height, 0.0, 0.0))

    def turn(self, angle: float, rate: float = 1.0) -> PlanMaker:
        sign, height = math.copysign(1.0, angle), self.height
        duration = abs(angle) / rate
        return self.piece(duration, lambda t: (0.0, 0.0, height, 0.0, sign * rate * t))

    def ramp(self, before: float, after: float, acceleration: float = 1.0) -> PlanMaker:
        """From one speed to another."""
        duration, height = abs(after - before) / acceleration, self.height
        a = math.copysign(acceleration, after - before)
        return self.piece(
            duration, lambda t: (before * t + a * t * t / 2, before + a * t, height, 0.0, 0.0)
        )

    def cruise(self, speed: float, length: float) -> PlanMaker:
        height = self.height
        return self.piece(length / abs(speed), lambda t: (speed * t, speed, height, 0.0, 0.0))

    def walk(self, length: float, speed: float = 0.75, acceleration: float = 1.0) -> PlanMaker:
        """From rest to rest."""
        speed = min(speed, 0.99 * math.sqrt(length * acceleration))
        rest = length - speed * speed / acceleration
        self.ramp(0.0, speed, acceleration).cruise(speed, rest)
        return self.ramp(speed, 0.0, acceleration)

    def sink(self, height: float, speed: float, duration: float = 0.4) -> PlanMaker:
        """Walk on while the body sinks or rises, smoothly."""
        before, change = self.height, height - self.height

        def motion(t: Any) -> State:
            u = t / duration
            z = before + change * u**3 * (10 - 15 * u + 6 * u * u)
            rise = change * 30 * u * u * (1 - u) ** 2 / duration
            return speed * t, speed, z, rise, 0.0

        return self.piece(duration, motion)

    def push(
        self, phase: int, speed: float, rise: float, force: float, duration: float
    ) -> PlanMaker:
        """A stance of a leap, from a vertical speed, with a peak force in body weights."""
        before = self.height

        def motion(t: Any) -> State:
            up = G * force * (2 * t**2 / duration - 4 * t**3 / (3 * duration**2)) - G * t
            high = G * force * (2 * t**3 / (3 * duration) - t**4 / (3 * duration**2))
            z = before + rise * t + high - G * t * t / 2
            return speed * t, speed, z, rise + up, 0.0

        return self.piece(duration, motion, phase)

    def leap(self, speed: float = 0.75, force: float = 3.0, duration: float = 0.2) -> PlanMaker:
        """Crouch, take off, fly, land and rise, at an even speed."""
        before, start = self.time, self.height
        dt, self.dt = self.dt, duration / 10
        self.sink(0.17, speed)
        rise = G * duration * (2 * force / 3 - 1)
        self.push(TAKE_OFF, speed, 0.0, force, duration)
        high = self.height
        flight = 2 * rise / G
        self.piece(
            flight,
            lambda t: (speed * t, speed, high + rise * t - G * t * t / 2, rise - G * t, 0.0),
            FLIGHT,
        )
        self.push(LANDING, speed, -rise, force, duration)
        self.sink(start, speed)
        self.dt = dt
        assert self.time > before
        return self

    def arrays(self, robot: int = 0, model: RobotModel = MODELS["go1"]) -> dict[str, np.ndarray]:
        """As in `plan.npz`."""
        assert self.last is not None
        table = np.array([*self.rows, self.last])
        phase = np.array([*self.phases, WALK], dtype=np.int8)
        feet = np.zeros((0, 6))
        if model.legs is not None:
            feet = trot(table, phase, model)
        return {
            f"t_{robot}": table[:, 0],
            f"position_{robot}": table[:, 1:4],
            f"velocity_{robot}": table[:, 4:7],
            f"yaw_{robot}": table[:, 7],
            f"phase_{robot}": phase,
            f"footholds_{robot}": feet,
        }


def trot(table: np.ndarray, phase: np.ndarray, model: RobotModel) -> np.ndarray:
    """Diagonal pairs in turns while walking, all feet in take-off and landing."""
    legs = model.legs
    hips = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * (legs.hip_x, legs.hip_y)
    time, rows, pair = table[:, 0], [], 0
    edges = [0, *(np.flatnonzero(np.diff(phase)) + 1), len(phase) - 1]
    for a, b in pairwise(edges):
        if phase[a] == FLIGHT or b == a:
            continue
        windows = 1 if phase[a] else max(math.ceil((time[b] - time[a]) / 0.25), 1)
        ends = np.linspace(time[a], time[b], windows + 1)
        for down, up in pairwise(ends):
            x, y, yaw = (np.interp((down + up) / 2, time, table[:, k]) for k in (1, 2, 7))
            c, s = math.cos(yaw), math.sin(yaw)
            for leg in range(4) if phase[a] else ((0, 3), (1, 2))[pair]:
                u, v = hips[leg]
                rows.append((down, up, leg, x + c * u - s * v, y + s * u + c * v, 0.0))
            pair = 1 - pair
    return np.array(rows)


def words(
    robots: Sequence[dict[str, Any]],
    obstacles: Sequence[dict[str, Any]] = (),
    world: dict[str, Any] | None = None,
    planner: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """A scenario's content, 20 x 20 m of free ground unless said otherwise."""
    ground = world or {"empty": {"size": [20, 20]}}
    return {
        "version": 1,
        "name": "by-hand",
        "world": {**ground, "obstacles": list(obstacles)},
        "robots": [{"model": "go1", **robot} for robot in robots],
        "task": {"goals": "individual"},
        "planner": planner or {},
    }


def summary_of(arrays: dict[str, np.ndarray], robots: int) -> dict[str, Any]:
    """What a plan says of itself when it is solved."""
    lengths, durations = [], []
    for k in range(robots):
        if f"t_{k}" in arrays:
            steps = np.diff(arrays[f"position_{k}"], axis=0)
            lengths.append(round(float(np.sqrt((steps**2).sum(axis=1)).sum()), 6))
            durations.append(round(float(arrays[f"t_{k}"][-1]), 6))
        else:
            lengths.append(None)
            durations.append(None)
    known = [d for d in durations if d is not None]
    return {
        "success": True,
        "path_length_m": lengths,
        "duration_s": durations,
        "makespan_s": max(known, default=None),
    }


class Judged:
    """A team's plans with the scenario that they solve, to be tampered with and judged."""

    def __init__(self, makers: Sequence[PlanMaker], models: Sequence[str], **world: Any) -> None:
        self.arrays: dict[str, np.ndarray] = {}
        robots = []
        for k, (maker, name) in enumerate(zip(makers, models, strict=True)):
            own = maker.arrays(k, MODELS[name])
            self.arrays |= own
            first, last = own[f"position_{k}"][0], own[f"position_{k}"][-1]
            yaw = own[f"yaw_{k}"]
            start = [float(first[0]), float(first[1]), float(yaw[0])]
            goal = [float(last[0]), float(last[1]), float(yaw[-1])]
            robots.append({"model": name, "start": start, "goal": goal})
        self.words = words(robots, **world)
        self.summary = summary_of(self.arrays, len(robots))

    @property
    def scenario(self) -> Scenario:
        return parse_scenario(self.words)

    def report(self) -> Report:
        return judge_plan(self.scenario, self.arrays, self.summary)


@pytest.fixture
def maker() -> type[PlanMaker]:
    return PlanMaker


@pytest.fixture
def team() -> Callable[..., Judged]:
    """From makers to a judged team."""

    def make(*makers: PlanMaker, models: Sequence[str] | None = None, **world: Any) -> Judged:
        return Judged(makers, models or ["go1"] * len(makers), **world)

    return make


@pytest.fixture
def walker(maker: type[PlanMaker], team: Callable[..., Judged]) -> Judged:
    """One robot that turns and walks 3 m along x."""
    return team(maker((5.0, 5.0, -0.5)).wait(0.3).turn(0.5).walk(3.0).wait(0.5))


@pytest.fixture
def leaper(maker: type[PlanMaker], team: Callable[..., Judged]) -> Judged:
    """One robot that leaps on its way."""
    plan = maker((5.0, 5.0, 0.0)).ramp(0.0, 0.75).cruise(0.75, 0.6).leap()
    return team(plan.cruise(0.75, 0.6).ramp(0.75, 0.0))


@pytest.fixture(scope="module")
def module_maker() -> type[PlanMaker]:
    """`maker`, for property tests, which take no function's fixtures."""
    return PlanMaker


@pytest.fixture(scope="module")
def module_team() -> Callable[..., Judged]:
    """`team` likewise."""

    def make(*makers: PlanMaker, **world: Any) -> Judged:
        return Judged(makers, ["go1"] * len(makers), **world)

    return make
