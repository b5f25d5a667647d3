"""The formation planner: poses in, velocity commands out, once per cycle.

Norén et al., "Role-Adaptive Collaborative Formation Planning for Team of Quadruped Robots in
Cluttered Environments", with deadlock resolution and a safety filter of our own on top.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.formation import modes
from cavalcade.formation._clearance import ObstacleBoxes, Surroundings
from cavalcade.formation._least_change import TeamState
from cavalcade.formation.dynamic_obstacles import DynamicObstacle, obstacle_boxes
from cavalcade.formation.estimation import Imperfections, StateEstimator, VelocityTracker
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.safety_filter import SafetyFilter, SafetyInputs
from cavalcade.formation.settings import (
    PRESETS,
    FormationSettings,
    default_settings,
    variant_named,
)
from cavalcade.formation.shapes import Formation
from cavalcade.formation.team import Team
from cavalcade.geometry import (
    Array,
    as_floats,
    inverse_transform_points,
    rotation,
    transform_points,
    wrap_angle,
)
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel, robot_model
from cavalcade.world import OccupancyMap
from cavalcade.world.shapes import plain_number


class FormationPlanner:
    """Drives a team in formation to one goal after another.

    Call `set_goal`, then `step` at a fixed rate with the robots' poses, and send what it returns.
    All poses are in the map's frame.

    Args:
        map: The world.
        formation: The shape; it has one slot per robot.
        robots: Number of robots.
        model: Their model or its name.
        settings: The paper's parameters, or the name of a preset; None for the variant's own.
        variant: One of `cavalcade.formation.VARIANTS`.
        rate: Cycles per second.
        seed: Of the choices that break a repeated deadlock.
        lookahead: Over the settings' look-ahead, s.
        expected: How well the robots are located and reached; None for perfectly. Variants
            with the safety filter plan for the moment when their commands arrive, and keep wider
            gaps.

    Raises:
        InputError: Malformed arguments, or slots and robots that differ in number.
    """

    def __init__(
        self,
        map: OccupancyMap,
        formation: Formation,
        robots: int | None = None,
        model: str | RobotModel = "go1",
        settings: FormationSettings | str | None = None,
        variant: str = "cavalcade",
        rate: float = 20.0,
        seed: int = 0,
        lookahead: float | None = None,
        expected: Imperfections | None = None,
    ) -> None:
        robots = formation.size if robots is None else robots
        if robots != formation.size:
            raise InputError(
                f"the shape {formation.name} has {formation.size} slots for {robots} robots",
                key="formation",
            )
        if not (np.isfinite(rate) and rate > 0.0):
            raise InputError(f"expected a rate above 0 Hz, got {rate!r}", key="rate")
        if isinstance(settings, str):
            if settings not in PRESETS:
                raise InputError(f"unknown preset {settings!r}", key="settings", choices=PRESETS)
            settings = PRESETS[settings][0]
        settings = default_settings(variant) if settings is None else settings
        self.settings = settings.with_values(lookahead=lookahead)
        self.model = robot_model(model) if isinstance(model, str) else model
        self.variant = variant_named(variant)
        self.rate = float(rate)
        self._map = map
        self._maps = PlanningMaps(map.occupied, map.resolution, self.settings)
        self._team = Team(robots, formation)
        period = 1.0 / self.rate
        self._expected = expected or Imperfections()
        self._tracker: VelocityTracker | StateEstimator = VelocityTracker(self.model, period)
        self._late = 0.0  # s from a cycle to the moment that poses are told for
        if self.variant.filter and not self._expected.none:
            self._tracker = StateEstimator(self.model, period, self._expected)
            self._late = self._expected.delay
        self._filter = SafetyFilter(self.model, period, self._expected)
        self._obstacles: tuple[DynamicObstacle, ...] = ()
        self._mode = modes.Navigator(
            self._team, self.variant, self.settings, self.model, period,
            np.random.default_rng(seed), self._expected.error(period, self.model.length / 2.0),
        )  # fmt: skip
        self._paused = False
        self._bodies: tuple[PlanningMaps, Array, PlanningMaps] | None = None
        self._status = self._make_status(np.zeros((robots, 3)))

    @property
    def status(self) -> PlannerStatus:
        """What the last cycle came to."""
        return self._status

    def set_goal(self, pose: Sequence[float] | ArrayLike) -> None:
        """Drive the formation's centre to a pose (x, y, yaw), from the next cycle on."""
        self.set_goals(as_floats(pose, "goal")[None])

    def set_goals(self, goals: Sequence[Sequence[float]] | ArrayLike) -> None:
        """Drive through poses `(G, 3)` in their order; they replace all earlier goals."""
        poses = as_floats(goals, "goal")
        if poses.size == 0:
            self.cancel()
            return
        if poses.ndim != 2 or poses.shape[1:] != (3,) or not np.isfinite(poses).all():
            raise InputError("expected finite poses (x, y, yaw)", key="goal")
        origin = np.asarray(self._map.origin, dtype=float)
        local = _into_grid(poses, origin)
        local[:, 2] = wrap_angle(local[:, 2])
        self._mode.set_goals(local)

    def cancel(self) -> None:
        """Forget all goals; the team stops."""
        self._mode.set_goals(np.empty((0, 3)))

    def pause(self) -> None:
        """Stop until `resume`; the goals stay."""
        self._paused = True
        self._tracker.commanded(np.zeros((self._team.size, 3)))

    def resume(self) -> None:
        """Go on after `pause`."""
        self._paused = False
        self._mode.go_on()

    def set_formation(self, formation: Formation) -> None:
        """Change the shape while standing or moving.

        Raises:
            InputError: Its slots are neither as many as the robots that take part nor as all.
        """
        self._team.set_formation(formation)
        self._mode.restart()

    def lose(self, robot: int) -> None:
        """Go on without a robot: the others form a smaller shape and keep clear of it."""
        self._team.lose(robot)
        self._mode.restart()

    def rejoin(self, robot: int) -> None:
        """Take a lost robot back."""
        self._team.rejoin(robot)
        self._mode.restart()

    def update_map(self, map: OccupancyMap) -> None:
        """Replace the map; where only some cells differ, only their surroundings are renewed."""
        before, after = ((m.rows, m.cols, m.resolution, *m.origin) for m in (self._map, map))
        if before == after:
            self._maps = self._maps.changed(map.occupied)
        else:
            goals = self._mode.goals
            old, new = np.asarray(self._map.origin), np.asarray(map.origin)
            self._maps = PlanningMaps(map.occupied, map.resolution, self.settings)
            if len(goals):
                there = np.column_stack([transform_points(old, goals[:, :2]), goals[:, 2] + old[2]])
                self._mode.set_goals(_into_grid(there, new), keep=True)
        self._map = map
        self._mode.refresh()

    def set_dynamic_obstacles(self, obstacles: Sequence[DynamicObstacle]) -> None:
        """Say what moves now and how fast; an empty list when nothing moves any more."""
        if len(obstacles) and not self._obstacles:
            self._mode.expect_boxes()
        self._obstacles = tuple(obstacles)

    def step(self, poses: ArrayLike, time: float, stamps: ArrayLike | None = None) -> Array:
        """One cycle.

        Args:
            poses: `(N, 3)` x, y in m and yaw in rad of all robots, as last reported.
            time: Now, s; any clock that advances.
            stamps: `(N,)` when each of them was measured, s; None where that is not known. Only
                planners that expect imperfections use it.

        Returns:
            `(N, 3)` body-frame velocities: m/s, m/s, rad/s.

        Raises:
            InputError: Poses or stamps of the wrong shape, or not finite.
        """
        poses = as_floats(poses, "poses")
        if poses.shape != (self._team.size, 3):
            raise InputError(
                f"expected ({self._team.size}, 3) poses, got {poses.shape}", key="poses"
            )
        if not np.isfinite(poses).all():
            raise InputError("expected finite poses", key="poses")
        if not math.isfinite(plain_number(time, "time")):
            raise InputError("expected a finite time", key="time")
        if stamps is not None:
            stamps = as_floats(stamps, "stamps")
            if stamps.shape != (len(poses),) or not np.isfinite(stamps).all():
                raise InputError(f"expected ({len(poses)},) finite times", key="stamps")
        origin = self._map.origin
        poses, velocities = self._tracker.update(poses, float(time), stamps)
        local = _into_grid(poses, origin) if any(origin) else poses
        if origin[2]:
            velocities[:, :2] = velocities[:, :2] @ rotation(origin[2])
        boxes = obstacle_boxes(self._obstacles, origin)
        boxes.poses[:, :2] += self._late * boxes.velocities
        if self._paused:
            wanted = np.zeros_like(local)
        else:
            routes = self._routes(local)
            wanted = self._mode.step(routes, local, velocities, float(time), boxes)
        commands = self._commands(local, velocities, wanted, boxes)
        self._tracker.commanded(commands)
        self._status = self._make_status(poses)
        return commands

    def _routes(self, local: Array) -> PlanningMaps:
        """The maps to find paths on: lost robots are obstacles there."""
        bodies = local[~self._team.present]
        if len(bodies) == 0:
            return self._maps
        known = self._bodies
        same = known is not None and known[0] is self._maps and len(known[1]) == len(bodies)
        if known is None or not same or _departed(known[1], bodies):
            maps = self._maps.with_bodies(bodies, self.model.length, self.model.width)
            self._bodies = known = (self._maps, bodies.copy(), maps)
        return known[2]

    def _commands(
        self, local: Array, velocities: Array, wanted: Array, boxes: ObstacleBoxes
    ) -> Array:
        frozen = ~self._team.present
        if self.variant.filter:
            evading = self._mode.evading()
            # In an emergency it is footprints that are kept off obstacles, not circles.
            clearances = np.where(evading, 0.0, self._mode.radius)
            rank = self._mode.rank()
            around = Surroundings(self._maps.distance, self._maps.cell, *boxes)
            team = TeamState(local, velocities, wanted, rank, frozen, evading, clearances)
            commands, _ = self._filter.apply(SafetyInputs(team, around))
        else:
            commands = self._filter.in_body(local, wanted)
            commands[frozen] = 0.0
        return commands

    def _make_status(self, poses: Array) -> PlannerStatus:
        origin = np.asarray(self._map.origin, dtype=float)
        status = self._mode.status
        goal = status.goal
        if goal is not None:
            centre = transform_points(origin, goal[None, :2])[0]
            goal = np.array([*centre, wrap_angle(goal[2] + origin[2])])
        goals = poses[:, :2].copy()
        known = np.isfinite(status.goals).all(axis=1)
        goals[known] = transform_points(origin, status.goals[known])
        paths = status.paths
        if origin.any():
            paths = tuple(transform_points(origin, path) for path in paths)
        return replace(
            status,
            state="paused" if self._paused else status.state,
            slots=np.array(self._team.formation.slots),
            goals=goals,
            goal=goal,
            paths=paths,
            connections=self._team.joined(status.roles)
            if self.variant.springs
            else status.connections,
        )


_SETTLED = 0.05  # m and rad that a lost robot may move before paths are planned anew


def _into_grid(poses: Array, origin: Sequence[float] | Array) -> Array:
    """Poses `(N, 3)` of the map's frame in that of its grid, whose origin is (x, y, yaw)."""
    return np.column_stack(
        [inverse_transform_points(origin, poses[:, :2]), poses[:, 2] - origin[2]]
    )


def _departed(before: Array, now: Array) -> bool:
    """Whether any of the poses `(K, 3)` has changed by more than `_SETTLED`."""
    change = now - before
    change[:, 2] = wrap_angle(change[:, 2])
    return bool(np.abs(change).max() > _SETTLED)
