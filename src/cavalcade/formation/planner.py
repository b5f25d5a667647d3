"""The formation planner: poses in, velocity commands out, once per cycle.

Norén et al., "Role-Adaptive Collaborative Formation Planning for Team of Quadruped Robots in
Cluttered Environments", with deadlock resolution and a safety filter of our own on top.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from threading import RLock

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.eikonal import surface_distance
from cavalcade.errors import InputError
from cavalcade.formation import modes
from cavalcade.formation._clearance import ObstacleBoxes, Surroundings
from cavalcade.formation._least_change import TeamState
from cavalcade.formation.cycle import named
from cavalcade.formation.cycle_clock import LATEST, CycleClock
from cavalcade.formation.dynamic_obstacles import DynamicObstacle, obstacle_boxes
from cavalcade.formation.estimation import Imperfections, StateEstimator, VelocityTracker
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.preparation import Ground, Preparation, Prepared, Request, ahead
from cavalcade.formation.ramp import Ramp
from cavalcade.formation.robot_monitor import AgeMonitor, FollowingMonitor
from cavalcade.formation.safety_filter import SafetyFilter, SafetyInputs, filtered
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
    inverse_transform_points,
    rotation,
    transform_points,
    wrap_angle,
)
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel, robot_model
from cavalcade.robots.motion import check_holonomic
from cavalcade.values import (
    described,
    instance_of,
    instances_of,
    number_array,
    number_in,
    whole_number,
)
from cavalcade.world import OccupancyMap


class FormationPlanner:
    """Drives a team in formation to one goal after another.

    Call `set_goal`, then `step` at a fixed rate with the robots' poses, and send what it returns.
    All poses are in the map's frame.

    Args:
        map: The world.
        formation: The shape; it has one slot per robot.
        robots: Number of robots.
        model: Their model or its name.
        settings: The parameters, or the name of a preset; None for the variant's own, from which
            `default_settings(variant).with_values(...)` sets some.
        variant: One of `cavalcade.formation.VARIANTS`.
        rate: Cycles per second, 0.1 to 1000.
        seed: Of the choices that break a repeated deadlock.
        lookahead: Over the settings' look-ahead, s.
        expected: How well the robots are located and reached; None for perfectly. Variants
            with the safety filter plan for the moment when their commands arrive, and keep wider
            gaps.
        live: For robots that do not wait. Goals, shapes and maps come into effect with the cycle
            in which all that follows from them has been worked out, in a thread beside; until then
            the team goes on as it was, or stands. Paused, robots brake within their limits of
            acceleration, and resumed they set off within them. What happens when depends on wall
            time then; otherwise it never does.

    Every method may be called from any thread. A call waits for the cycle in progress at most, and
    a cycle sees all of its effect or nothing.

    Raises:
        InputError: Malformed arguments, slots and robots that differ in number, or a model that
            does not move sideways or accelerates without limit.
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
        live: bool = False,
    ) -> None:
        instance_of(map, OccupancyMap, "map")
        instance_of(formation, Formation, "formation")
        robots = formation.size if robots is None else whole_number(robots, "robots")
        if robots != formation.size:
            raise InputError(
                f"the shape {formation.name} has {formation.size} slots for {robots} robots",
                key="formation",
            )
        self.variant = variant_named(variant)
        self.settings = _settings(settings, variant).with_values(lookahead=lookahead)
        self.model = robot_model(model)
        check_holonomic(self.model)
        self.rate = number_in(rate, "rate", 0.1, 1000.0, "Hz")
        whole_number(seed, "seed", 0)
        self._lock = RLock()
        self._map = map
        self._maps = self._maps_of(map)
        self._ground = Ground(map, self._maps.distance)
        self._team = Team(robots, formation)
        self._preparation = Preparation() if instance_of(live, bool, "live") else None
        # What has been asked for; it may be in effect only later.
        self._asked_team = self._team.copy() if live else self._team
        self._goals: Array = np.empty((0, 3))
        period = 1.0 / self.rate
        self._expected = Imperfections() if expected is None else expected
        instance_of(self._expected, Imperfections, "expected")
        self._tracker: VelocityTracker | StateEstimator = VelocityTracker(self.model, period)
        self._late = 0.0  # s from a cycle to the moment that poses are told for
        if self.variant.filter and not self._expected.none:
            self._tracker = StateEstimator(self.model, period, self._expected)
            self._late = self._expected.delay
        self._clock = CycleClock(period)
        self._ages = AgeMonitor(self._expected.max_age)
        self._following = FollowingMonitor(self.model, robots, period, self._expected)
        self._filter = SafetyFilter(self.model, period, self._expected)
        self._obstacles: tuple[DynamicObstacle, ...] = ()
        self._mode = modes.Navigator(
            self._team, self.variant, self.settings, self.model, period,
            np.random.default_rng(seed), self._expected.error(period, self.model.length / 2.0),
            plans=not live,
        )  # fmt: skip
        self._paused = False
        self._ramp = Ramp(self.model, period, robots) if live else None
        self._bodies: tuple[PlanningMaps, Array, PlanningMaps] | None = None
        self._status = self._make_status(np.zeros((robots, 3)))

    @property
    def status(self) -> PlannerStatus:
        """What the last cycle came to."""
        return self._status

    @property
    def map(self) -> OccupancyMap:
        """The world as it was told last."""
        return self._map

    @property
    def robots(self) -> int:
        """Number of robots, lost ones too."""
        return self._team.size

    @property
    def expected(self) -> Imperfections:
        """How well the robots are located and reached."""
        return self._expected

    def limit_age(self, max_age: float) -> None:
        """Have poses count as stale from this age on, s, in the place of `expected.max_age`.

        A supervisor sets its own limit so, that there is one.
        """
        self._expected = replace(self._expected, max_age=max_age)
        self._ages = AgeMonitor(max_age)
        if isinstance(self._tracker, StateEstimator):
            self._tracker.max_age = max_age

    def set_goal(self, pose: Sequence[float] | ArrayLike) -> None:
        """Drive the formation's centre to a pose (x, y, yaw), from the next cycle on."""
        self.set_goals(number_array(pose, "goal", (3,), "a pose (x, y, yaw)")[None])

    def set_goals(self, goals: Sequence[Sequence[float]] | ArrayLike) -> None:
        """Drive through poses `(G, 3)` in their order; they replace all earlier goals."""
        if isinstance(goals, (tuple, list)) and len(goals) == 0:
            goals = np.empty((0, 3))
        if isinstance(goals, np.ndarray) and goals.size == 0:
            self.cancel()
            return
        poses = number_array(goals, "goal", (None, 3), "poses (x, y, yaw)")
        with self._lock:
            self._goals = poses
            self._change(
                lambda: self._mode.set_goals(_goals_in_grid(poses, self._map.origin)), goals=True
            )

    def cancel(self) -> None:
        """Forget all goals; the team stops."""
        with self._lock:
            self._goals = np.empty((0, 3))
            if self._preparation is not None:
                self._preparation.drop_goals()
            self._mode.set_goals(self._goals)

    def pause(self) -> None:
        """Stop until `resume`; the goals stay."""
        with self._lock:
            self._paused = True
            if self._ramp is None:
                self._tracker.commanded(np.zeros((self._team.size, 3)))
            else:
                self._ramp.begin()

    def resume(self) -> None:
        """Go on after `pause`."""
        with self._lock:
            self._paused = False
            self._clock.expect_gap()
            self._following.forget()
            self._mode.rest()
            self._change(self._mode.refresh)

    def set_formation(self, formation: Formation) -> None:
        """Change the shape while standing or moving.

        Raises:
            InputError: Its slots are neither as many as the robots that take part nor as all.
        """
        self._reform(lambda team: team.set_formation(formation))

    def lose(self, robot: int) -> None:
        """Go on without a robot: the others form a smaller shape and keep clear of it."""
        self._reform(lambda team: team.lose(robot))

    def rejoin(self, robot: int) -> None:
        """Take a lost robot back."""
        self._reform(lambda team: team.rejoin(robot))

    def update_map(self, map: OccupancyMap) -> None:
        """Replace the map; where only some cells differ, only their surroundings are renewed.

        From the next cycle on the safety filter keeps clear of what stands on it, also of a live
        planner, whose paths take it into account a moment later.
        """
        instance_of(map, OccupancyMap, "map")
        if self._preparation is not None:
            ground = self._ground_of(map)  # not a cycle waits for it, only the caller
            with self._lock:
                self._ground = ground
                self._change(lambda: None)
            return
        with self._lock:
            same = _geometry(self._map) == _geometry(map)
            self._use_map(map, self._maps.changed(map.occupied) if same else self._maps_of(map))

    def set_dynamic_obstacles(self, obstacles: Sequence[DynamicObstacle]) -> None:
        """Say what moves now and how fast; an empty list when nothing moves any more."""
        what = "a list of DynamicObstacle(shape, velocity)"
        obstacles = instances_of(obstacles, DynamicObstacle, "obstacles", what)
        with self._lock:
            if obstacles and not self._obstacles:
                self._mode.expect_boxes()
            self._obstacles = obstacles

    def step(self, poses: ArrayLike, time: float, stamps: ArrayLike | None = None) -> Array:
        """One cycle.

        Args:
            poses: `(N, 3)` x, y in m and yaw in rad of all robots, as last reported.
            time: Now, s; any clock that advances. A time that repeats, is set back or jumps counts
                as one cycle; the status says so.
            stamps: `(N,)` when each of them was measured, s, by the same clock; None where that
                is not known. While one of them is older than `expected.max_age` all robots are
                commanded to stop; the status, `stale`, names those that are.

        Returns:
            `(N, 3)` body-frame velocities: m/s, m/s, rad/s.

        Raises:
            InputError: Poses or stamps of the wrong shape, or not finite; a clock that advances as
                if it counted something else than seconds.
        """
        with self._lock:
            return self._step(poses, time, stamps)

    def _step(self, poses: ArrayLike, time: float, stamps: ArrayLike | None) -> Array:
        count = self._team.size
        reported = number_array(poses, "poses", (count, 3), f"({count}, 3) poses")
        time = number_in(time, "time", -LATEST, LATEST, "s")
        if stamps is not None:
            stamps = number_array(stamps, "stamps", (count,), f"({count},) times in s", LATEST)
        now = self._clock.advance(time, lambda then: self._tracker.foresees(reported, then))
        if self._preparation is not None:
            self._take_up(self._preparation)
        if self._ramp is not None and self._ramp.left_out(now):
            self._tracker.commanded(np.zeros((count, 3)))
        if stamps is not None:
            stamps = self._clock.placed(stamps)
        self._ages.update(stamps, now, np.nonzero(self._present())[0])
        if stamps is not None:
            stamps = np.minimum(stamps, now)
        self._following.update(reported, now)
        origin = self._map.origin
        poses, velocities = self._tracker.update(reported, now, stamps)
        local = _into_grid(poses, origin) if any(origin) else poses
        if origin[2]:
            velocities[:, :2] = velocities[:, :2] @ rotation(origin[2])
        boxes = self._boxes(origin)
        wanted = np.zeros_like(local)
        plan = self._mode.plan
        if self._ages.stale:
            self._mode.rest()
            commands = wanted  # the filter would move robots apart that are too near
        else:
            if not self._paused:
                wanted = self._mode.step(self._routes(local), local, velocities, now, boxes)
            if self._ramp is not None:
                wanted = self._ramp.limited(wanted, local[:, 2], self._paused)
            commands = self._commands(local, velocities, wanted, boxes)
        self.commanded(commands)
        if self._ramp is not None:
            self._ramp.commanded(commands, now)
        if self._preparation is not None:
            if plan is not self._mode.plan:
                self._preparation.discard(plan)
            self._prepare(self._preparation, poses, local)
        self._status = self._make_status(poses)
        return commands

    def commanded(self, commands: Array) -> None:
        """Say what `(N, 3)` was really sent after the last `step`, where it is something else.

        As under a supervisor with a cap of its own, so that slow robots are expected to be slow.
        """
        with self._lock:
            self._tracker.commanded(commands)
            self._following.commanded(commands.copy())

    def _present(self) -> NDArray[np.bool_]:
        """`(N,)` robots that take part and are not about to be left out."""
        return self._team.present & self._asked_team.present

    def _change(self, act: Callable[[], None], goals: bool = False) -> None:
        """Let a change come into effect: now, or live once what follows from it is prepared."""
        if self._preparation is None:
            act()
        else:
            self._preparation.add(act, goals)
            self._preparation.discard(self._mode.following)
            self._mode.following = None

    def _reform(self, change: Callable[[Team], None]) -> None:
        """Change the team; what is refused is refused at once."""

        def act() -> None:
            if self._team is not self._asked_team:
                change(self._team)
            self._mode.restart()

        with self._lock:
            change(self._asked_team)
            self._change(act)

    def _use_map(self, map: OccupancyMap, maps: PlanningMaps) -> None:
        if _geometry(self._map) != _geometry(map):
            goals = self._mode.goals
            old, new = np.asarray(self._map.origin), np.asarray(map.origin)
            if len(goals):
                self._mode.set_goals(_into_grid(_out_of_grid(goals, old), new), keep=True)
        self._map, self._maps = map, maps
        if self._preparation is None:
            self._ground = Ground(map, maps.distance)
        self._mode.refresh()

    def _ground_of(self, map: OccupancyMap) -> Ground:
        """A map with its distances; where it differs little from the last one, found quickly."""
        with self._lock:
            known, maps, current = self._ground, self._maps, self._map
        if _geometry(known.map) == _geometry(map) == _geometry(current):
            former = known.map.occupied, known.distance
            return Ground(map, maps.distance_after(map.occupied, former))
        return Ground(map, surface_distance(map.occupied, map.resolution))

    def _take_up(self, preparation: Preparation) -> None:
        """Let changes come into effect whose preparation is over."""
        prepared = preparation.take()
        if prepared is None:
            return
        preparation.discard(prepared)
        request = prepared.request
        if request.goals is not self._goals:
            return  # they were replaced meanwhile
        if request.ahead:
            if request.number == preparation.number:
                self._mode.following = prepared.plan
            return
        if not preparation.goals_waiting and request.waypoint != self._mode.waypoint:
            return
        preparation.discard(self._maps, self._bodies, self._mode.plan, self._mode.following)
        for change in preparation.due(request.number):
            change.act()
        if request.ground.map is not self._map:
            self._use_map(request.ground.map, prepared.maps)
        self._maps, self._bodies = prepared.maps, (prepared.maps, prepared.bodies, prepared.routes)
        self._mode.adopt(prepared.plan, prepared.routes)

    def _prepare(self, preparation: Preparation, poses: Array, local: Array) -> None:
        """Begin what has to be prepared next, unless something is being prepared."""
        if not preparation.idle:
            return
        plan, mode = self._mode.plan, self._mode
        waypoint = 0 if preparation.goals_waiting else mode.waypoint
        known = self._maps if self._ground.map is self._map else None
        request = Request(
            preparation.number, self._ground, known, self._asked_team.copy(), self._goals,
            waypoint, poses.copy(),
        )  # fmt: skip
        bodies = local[~self._team.present]
        moved = self._bodies is not None and len(bodies) and _departed(self._bodies[1], bodies)
        if preparation.waiting or moved:
            preparation.start(lambda: self._prepared(request))
        elif plan is not None and plan.missing:
            slot, cells = plan.missing.popitem()
            preparation.start(lambda: plan.make_missing(slot, cells))
        elif plan is not None and not mode.last and mode.following is None:
            preparation.start(lambda: self._prepared(ahead(request)))
        elif preparation.cluttered:
            preparation.start(lambda: None)

    def _prepared(self, request: Request) -> Prepared:
        """Work out what follows from a request; it alone and what never changes is read here."""
        ground, team = request.ground, request.team
        if request.maps is not None:
            maps = request.maps.twin()
        else:
            maps = self._maps_of(ground.map, ground.distance)
        local = _into_grid(request.poses, ground.map.origin)
        bodies, active = local[~team.present], team.active
        routes = maps
        if len(bodies):
            routes = maps.with_bodies(bodies, self.model.length, self.model.width)
        plan = None
        if len(request.goals) and len(active):
            goals = _goals_in_grid(request.goals, ground.map.origin)
            points = np.ascontiguousarray(local[active, :2])
            slots = team.formation.slots
            plan = self._mode.plan_goal(routes, goals[request.waypoint], slots, points)
            plan.march_beside()
        return Prepared(request, maps, routes, bodies, plan)

    def _maps_of(self, map: OccupancyMap, distance: Array | None = None) -> PlanningMaps:
        half = self.model.width / 2.0
        return PlanningMaps(
            map.occupied, map.resolution, self.settings, distance=distance, half_width=half
        )

    def _routes(self, local: Array) -> PlanningMaps:
        """The maps to find paths on: lost robots are obstacles there."""
        bodies = local[~self._team.present]
        if len(bodies) == 0:
            return self._maps
        known = self._bodies
        if self._preparation is not None and known is not None:
            return known[2]
        same = known is not None and known[0] is self._maps and len(known[1]) == len(bodies)
        if known is None or not same or _departed(known[1], bodies):
            maps = self._maps.with_bodies(bodies, self.model.length, self.model.width)
            self._bodies = known = (self._maps, bodies.copy(), maps)
        return known[2]

    def _boxes(self, origin: Sequence[float]) -> ObstacleBoxes:
        """Dynamic obstacles as they will be when commands arrive."""
        boxes = obstacle_boxes(self._obstacles, origin)
        boxes.poses[:, :2] += self._late * boxes.velocities
        return boxes

    def _commands(
        self, local: Array, velocities: Array, wanted: Array, boxes: ObstacleBoxes
    ) -> Array:
        frozen = ~self._present()
        ground = self._ground
        if ground.map.origin != self._map.origin:
            # The newest map is in effect here already, and its grid lies elsewhere.
            old, new = self._map.origin, ground.map.origin
            turn = rotation(new[2] - old[2])
            local = _into_grid(_out_of_grid(local, old), new)
            velocities, wanted = velocities.copy(), wanted.copy()
            velocities[:, :2], wanted[:, :2] = velocities[:, :2] @ turn, wanted[:, :2] @ turn
            boxes = self._boxes(new)
        if self.variant.filter:
            evading = self._mode.evading()
            # In an emergency it is footprints that are kept off obstacles, not circles.
            clearances = np.where(evading, 0.0, self._mode.radius)
            rank = self._mode.rank()
            around = Surroundings(ground.distance, ground.map.resolution, *boxes)
            team = TeamState(local, velocities, wanted, rank, frozen, evading, clearances)
            commands, _ = filtered(SafetyInputs(team, around), self._filter.parameters)
        else:
            commands = self._filter.in_body(local, wanted)
            commands[frozen] = 0.0
        return commands

    def _doubt(self) -> tuple[str, str, tuple[int, ...]] | None:
        """State, message and robots of a status, where something is wrong with what is told."""
        state = self._mode.status.state
        if self._ages.stale:
            return "stale", self._ages.message, self._ages.stale
        if self._mode.status.message:
            return None
        if self._following.deaf:
            deaf = self._following.deaf
            return state, f"{named(deaf)}: no motion as commanded", deaf
        if self._clock.message:
            return state, self._clock.message, ()
        return None

    def _make_status(self, poses: Array) -> PlannerStatus:
        origin = np.asarray(self._map.origin, dtype=float)
        status = self._mode.status
        goal, paths = status.goal, status.paths
        goals = poses[:, :2].copy()
        known = np.isfinite(status.goals).all(axis=1)
        goals[known] = status.goals[known]
        if origin.any():
            goals[known] = transform_points(origin, goals[known])
            paths = tuple(transform_points(origin, path) for path in paths)
        if goal is not None:
            x, y = transform_points(origin, goal[None, :2])[0] if origin.any() else goal[:2]
            goal = np.array([x, y, wrap_angle(goal[2] + origin[2])])
        doubt = self._doubt()
        state, message, involved = doubt or (status.state, status.message, status.involved)
        waiting = self._preparation is not None and self._preparation.waiting
        coming = self._preparation is not None and self._preparation.goals_waiting
        if (waiting and state in ("stuck", "infeasible")) or (coming and state != "stale"):
            state, message, involved = "partial", "the way is being planned", ()
        return replace(
            status,
            state="paused" if self._paused else state,
            message=message,
            involved=involved,
            arrived=status.arrived and not (self._ages.stale or coming),
            slots=np.array(self._team.formation.slots),
            goals=goals,
            goal=goal,
            paths=paths,
            connections=self._team.joined(status.roles)
            if self.variant.springs
            else status.connections,
        )


_SETTLED = 0.05  # m and rad that a lost robot may move before paths are planned anew


def _settings(given: FormationSettings | str | None, variant: str) -> FormationSettings:
    """The parameters given by themselves or by the name of a preset, or those of the variant."""
    if given is None:
        return default_settings(variant)
    if isinstance(given, str):
        if given not in PRESETS:
            raise InputError(f"unknown preset {described(given)}", key="settings", choices=PRESETS)
        return PRESETS[given][0]
    return instance_of(given, FormationSettings, "settings", "FormationSettings or a preset's name")


def _geometry(map: OccupancyMap) -> tuple[float, ...]:
    """What makes cells of the same index the same place."""
    return map.rows, map.cols, map.resolution, *map.origin


def _goals_in_grid(goals: Array, origin: Sequence[float]) -> Array:
    local = _into_grid(goals, np.asarray(origin, dtype=float))
    local[:, 2] = wrap_angle(local[:, 2])
    return local


def _out_of_grid(poses: Array, origin: Sequence[float] | Array) -> Array:
    """The way back from `_into_grid`."""
    return np.column_stack([transform_points(origin, poses[:, :2]), poses[:, 2] + origin[2]])


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
