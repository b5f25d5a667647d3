"""A scenario's robots in simulation that anybody may command, each by itself; knows no ROS."""

from __future__ import annotations

import heapq
import math
import threading
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cavalcade.errors import InputError
from cavalcade.execution.fleets import ideal_fleet, physics_fleet, tracking_model, with_own_robots
from cavalcade.fleet import FallingFleet, IdealFleet
from cavalcade.fleet.mujoco import MujocoFleet
from cavalcade.geometry import Array
from cavalcade.live.contacts import ContactWatch
from cavalcade.live.laser import RAYS, REACH, scan_team
from cavalcade.robots import body_of
from cavalcade.scenario import Scenario, World, build_world, resolve_scenario

STEP = 0.01
"""Commands are heard, and the clock told, so often, s."""

SILENCE = 0.5
"""Robots that hear nothing for so long stop by themselves, s."""

_FORGET = 10.0
"""Physics keeps its samples for so long, s; nobody asks for older ones here."""

_STRIDE, _SWING, _FASTEST = 2.0, 0.25, 0.5
"""Of ideal robots' legs, which only look like a trot: Hz, rad, and m/s at which they swing so."""


class PoseNews(NamedTuple):
    """A robot's pose as it is reported: x, y in m, yaw in rad, measured at `stamp` s."""

    robot: int
    pose: Array
    stamp: float


class Simulation:
    """The robots of a scenario at their starts, one after another told what to do.

    Ideal robots or robots in MuJoCo, as the scenario's backend says. Its noise lies on the
    reported poses; commands and reports are late and get lost as its delay says. Its events do
    not happen, and its goals are nobody's. A robot that hears nothing for 0.5 s stops by itself.

    Args:
        scenario: With all that was said over it.

    Attributes:
        scenario, world: Resolved, and its ground.

    Raises:
        InputError: The scenario cannot be used, its backend is no simulation, or MuJoCo is
            missing.
    """

    def __init__(self, scenario: Scenario) -> None:
        backend = scenario.execution.backend
        if backend not in ("ideal", "mujoco"):
            raise InputError(
                f"{backend} robots are not simulated",
                key="execution.backend",
                choices=("ideal", "mujoco"),
            )
        calm = scenario.execution.model_copy(update={"events": ()})
        scenario = scenario.model_copy(update={"execution": calm})
        if backend == "mujoco":
            scenario = with_own_robots(scenario)
        self.scenario = resolve_scenario(scenario)
        self.world: World = build_world(self.scenario)
        self.models = tuple(self.scenario.models)
        self._fleet = self._make_fleet()
        self._lock = threading.Lock()
        self._wanted = np.zeros((self.size, 3))
        self._fresh = np.zeros(self.size, dtype=bool)
        self._heard = np.full(self.size, -math.inf)
        self._moving = np.zeros(self.size, dtype=bool)
        self._random = np.random.default_rng(self.scenario.seed)
        self._late: list[tuple[float, int, PoseNews]] = []
        self._reports = 0
        self._told = 0
        self._steps = 0
        self._contacts = ContactWatch(self.world, self.models)
        self._mechanisms = [body_of(model) for model in self.models]
        self._bodies = np.array([model.body for model in self.models], dtype=float)
        self._gait = 0.0
        area = self.world.map
        self._place = np.array([*area.origin, area.resolution])
        self.scan()  # compiles it

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.models)

    @property
    def time(self) -> float:
        """Simulated time, s from 0."""
        return round(self._steps * STEP, 9)

    def command(self, robot: int, velocity: Sequence[float]) -> None:
        """Tell a robot its body-frame velocity: m/s, m/s, rad/s; from any thread.

        What is not finite is as if it had not been heard.
        """
        if not all(map(math.isfinite, velocity)):
            return
        with self._lock:
            self._wanted[robot] = velocity
            self._fresh[robot] = True

    def step(self) -> list[str]:
        """Let `STEP` s pass; what happened, a line each."""
        news = []
        with self._lock:
            wanted, fresh = self._wanted.copy(), self._fresh.copy()
            self._fresh[:] = False
        now = self.time
        if fresh.any():
            self._heard[fresh] = now
            self._moving[fresh] = wanted[fresh].any(axis=1)
            self._fleet.send(wanted, fresh)
        for robot in np.flatnonzero(now - self._heard > SILENCE - 1e-9):
            if self._heard[robot] > -math.inf:
                self._fleet.halt(int(robot))
                self._heard[robot] = -math.inf
                if self._moving[robot]:
                    news.append(f"robot {robot} stops: it heard no command for {SILENCE:g} s")
        self._fleet.advance(STEP)
        self._steps += 1
        self._gait += STEP * _STRIDE * 2.0 * math.pi
        news += self._contacts.look(self.time, self.poses())
        if isinstance(self._fleet, FallingFleet):
            falls = self._fleet.falls
            news += [f"robot {fall.robot} fell ({fall.cause})" for fall in falls[self._told :]]
            self._told = len(falls)
        if isinstance(self._fleet, MujocoFleet) and not self._steps % round(_FORGET / STEP):
            self._fleet.forget()
        return news

    def measure(self) -> None:
        """Measure all poses; those that are lost are told to nobody."""
        now, delay = self.time, self.scenario.execution.delay
        seen = self._fleet.observe()
        late = delay.mean + delay.jitter * self._random.standard_normal(self.size)
        for robot in np.flatnonzero(seen.stamps >= self._fleet.time - 0.5 * STEP).tolist():
            self._reports += 1
            news = PoseNews(robot, seen.poses[robot], now)
            heapq.heappush(self._late, (now + max(float(late[robot]), 0.0), self._reports, news))

    def reports(self) -> list[PoseNews]:
        """The measured poses that arrive by now."""
        told = []
        while self._late and self._late[0][0] <= self.time + 1e-9:
            told.append(heapq.heappop(self._late)[2])
        return told

    def poses(self) -> Array:
        """`(N, 3)` true poses, map frame."""
        return self._fleet.true_poses()

    def body_velocities(self) -> Array:
        """`(N, 3)` true velocities in the bodies' frames: m/s, m/s, rad/s."""
        velocities = self._fleet.true_velocities()
        yaw = self.poses()[:, 2]
        c, s = np.cos(yaw), np.sin(yaw)
        vx, vy, rate = velocities.T
        return np.column_stack([c * vx + s * vy, c * vy - s * vx, rate])

    def trunks(self) -> Array:
        """`(N, 7)` the trunks' frames: x, y, z in m and the quaternion x, y, z, w, map frame."""
        if isinstance(self._fleet, MujocoFleet):
            return self._fleet.simulator.qpos[:, [0, 1, 2, 4, 5, 6, 3]]
        poses = self.poses()
        heights = np.array(
            [
                0.5 * model.height if body is None else body.stand_height
                for model, body in zip(self.models, self._mechanisms, strict=True)
            ]
        )
        if self.world.terrain is not None:
            heights = heights + self.world.terrain.heights_at(poses[:, :2])
        half, none = 0.5 * poses[:, 2], np.zeros(self.size)
        return np.column_stack([poses[:, :2], heights, none, none, np.sin(half), np.cos(half)])

    def joints(self) -> list[tuple[Array, Array] | None]:
        """Angles and rates `(12,)` of each robot's legs, rad and rad/s; None for one without.

        Ideal robots stand, or move their legs as in a trot; those rates are zero.
        """
        if isinstance(self._fleet, MujocoFleet):
            simulator = self._fleet.simulator
            return list(zip(simulator.qpos[:, 7:], simulator.qvel[:, 6:], strict=True))
        speeds = np.abs(self._fleet.true_velocities()) @ (1.0, 1.0, 0.3)
        swings = _SWING * np.minimum(speeds / _FASTEST, 1.0)
        pairs = np.array([0.0, math.pi, math.pi, 0.0]) + self._gait
        found: list[tuple[Array, Array] | None] = []
        for body, swing in zip(self._mechanisms, swings, strict=True):
            if body is None:
                found.append(None)
                continue
            legs = np.reshape(body.standing, (4, 3)).copy()
            legs[:, 1] += swing * np.sin(pairs)
            legs[:, 2] -= swing * np.maximum(np.cos(pairs), 0.0)
            found.append((legs.ravel(), np.zeros(12)))
        return found

    def scan(self) -> Array:
        """`(N, RAYS)` ranges of a scanner in the middle of each robot, m; inf beyond `REACH`."""
        occupied = self.world.map.occupied
        return scan_team(occupied, self._place, self.poses(), self._bodies, RAYS, REACH)

    def _make_fleet(self) -> IdealFleet | MujocoFleet:
        scenario = self.scenario
        if scenario.execution.backend == "mujoco":
            # As robots do that carry plans out, which turn on the spot.
            return physics_fleet(scenario, self.world, 4.0 if scenario.goals else None)
        if scenario.goals:
            models = [tracking_model(model, False) for model in scenario.models]
            return ideal_fleet(scenario.with_models(models))
        return ideal_fleet(scenario)
