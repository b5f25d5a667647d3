"""The planner's states and what the team wants to do in each (Norén et al., section 2)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation import _kernels
from cavalcade.formation.baselines import behave, rigid_ground
from cavalcade.formation.evasion import evade
from cavalcade.formation.goals import GoalPlan, descend_from, partial_goals
from cavalcade.formation.ground import Ground
from cavalcade.formation.roles import assign_followers, assign_goals, choose_leader
from cavalcade.formation.settings import FormationSettings
from cavalcade.formation.standoff import ProgressMonitor, Resolver
from cavalcade.formation.team import Team
from cavalcade.formation.variants import Variant
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel

_TURN_GAIN = 2.5  # rad/s of yaw rate per rad of heading error
_FIRST = 6  # points of a path (half a cell apart) that give its initial direction
_BRISK = 0.6  # of d_slowdown: where our variant slows down before its slots
_HELD_BACK = 0.5  # of the top speed: what springs may take from a robot on its way
_NEAR = 0.30  # m from its slot at which a robot turns to the goal's heading
_DOCKING = 0.60  # m from its final slot at which a robot goes straight for it
_PASSED = 0.25  # m from all slots at which a waypoint counts as reached
_TIGHTER = (0.25, 0.21)  # m: inflation radii tried where r_max leaves no way
_ATTEMPTS = 6  # at resolving before a team is reported as stuck


@dataclass(frozen=True)
class View:
    """What the planner reports of a cycle; see `PlannerStatus`. In the grid's frame."""

    state: str = "inactive"
    leader: int = -1
    roles: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    targets: Array | None = None
    goal: Array | None = None
    paths: tuple[Array, ...] = ()
    eta: Array = field(default_factory=lambda: np.empty(0))
    arrived: bool = False
    waypoint: int = 0
    goal_moved: float = 0.0
    involved: tuple[int, ...] = ()
    message: str = ""


class Navigator:
    """Turns goals and poses into wanted velocities. In the grid's frame throughout."""

    def __init__(
        self,
        variant: Variant,
        settings: FormationSettings,
        model: RobotModel,
        period: float,
        rng: np.random.Generator,
    ) -> None:
        self._variant = variant
        self._settings = settings
        self._period = period
        self._rng = rng
        self._top_x = min(settings.v_max_x, model.max_speed_x)
        self._top_y = min(settings.v_max_y, model.max_speed_y)
        self._turn = model.max_yaw_rate
        self.goals: Array = np.empty((0, 3))
        self.radius = settings.r_max
        self._waypoint = 0
        self._monitor = ProgressMonitor()
        self.restart()

    def set_goals(self, goals: Array, keep: bool = False) -> None:
        """Replace the goals `(G, 3)`; `keep` says that they are the same ones, seen anew."""
        self.goals = goals
        if not keep:
            self._waypoint = 0
            self.restart()

    def restart(self) -> None:
        """Begin the present goal anew: it, the shape or the team has changed."""
        self._state = "partial" if len(self.goals) else "inactive"
        self._leader = -1
        self._roles: NDArray[np.int64] = np.empty(0, np.int64)
        self._resolver: Resolver | None = None
        self._attempts = 0
        self._resolved_from = np.inf
        self._lengths: Array = np.empty(0)
        self._joined: NDArray[np.int64] = np.empty((0, 2), np.int64)
        self._rank: NDArray[np.int64] | None = None
        self._view = View(state=self._state)
        self.refresh()

    def refresh(self) -> None:
        """The ground has changed: plan anew, keep state and roles."""
        self._plan: GoalPlan | None = None
        self._planned: Ground | None = None
        self._monitor.reset()
        if self._state in ("stuck", "infeasible"):
            self._state = "partial"
            self._attempts = 0

    def rank(self, robots: int) -> NDArray[np.int64]:
        """Precedence of the robots, 0 first."""
        return np.arange(robots) if self._rank is None else self._rank

    def view(self, team: Team, poses: Array | None) -> View:
        """What the last cycle came to."""
        if len(self._view.roles) == team.size:
            return self._view
        empty = np.empty((0, 2))
        return View(
            state=self._state,
            roles=np.full(team.size, -1, dtype=np.int64),
            paths=(empty,) * team.size,
            eta=np.full(team.size, np.inf),
            waypoint=self._waypoint,
        )

    def step(
        self,
        ground: Ground,
        team: Team,
        poses: Array,
        velocities: Array,
        time: float,
        movers: Array,
        mover_speeds: Array,
    ) -> Array:
        """Wanted velocities `(N, 3)`: m/s, m/s, rad/s; the limits of eq. 7 hold for them."""
        active = team.active
        wanted = np.zeros((len(poses), 3))
        if self._state == "inactive" or len(active) == 0:
            self._view = View()
            return wanted
        points = np.ascontiguousarray(poses[:, :2])
        plan = self._planned_for(ground, team, points, active)
        cycle = _Cycle(plan, team, poses, points, active, time)
        if len(plan.cut_off) > 0:
            self._state = "infeasible"
            cycle.report(self._roles_or_none(team), ())
            robots = tuple(int(active[k]) for k in plan.cut_off)
            self._view = cycle.view(
                self, message=f"no way to the goal for {_named(robots)}", involved=robots
            )
        elif self._variant.rigid or not self._variant.common_plan:
            self._follow_baseline(cycle)
        elif self._state == "stuck":
            cycle.report(self._roles, ())
            self._view = cycle.view(self, message=self._view.message, involved=self._view.involved)
        else:
            self._follow_plan(cycle)
        if cycle.velocity is not None:
            wanted[:, :2] = cycle.velocity
            wanted[:, 2] = self._yaw_rates(cycle)
        if self._variant.improved and len(movers):
            evade(wanted, poses, active, movers, mover_speeds, plan.ground, self._top_x)
        self._advance_waypoint(cycle, velocities)
        return wanted

    def _planned_for(
        self, ground: Ground, team: Team, points: Array, active: NDArray[np.int64]
    ) -> GoalPlan:
        if self._plan is not None and self._planned is ground:
            return self._plan
        goal, slots = self.goals[self._waypoint], team.formation.slots
        used = rigid_ground(ground, team.formation) if self._variant.rigid else ground
        plan = GoalPlan(used, goal, slots, points[active])
        if self._variant.improved:
            for radius in _TIGHTER:
                if len(plan.cut_off) == 0:
                    break
                tighter = GoalPlan(ground.tightened(radius), goal, slots, points[active])
                if len(tighter.cut_off) == 0:
                    plan = tighter
        self.radius = plan.ground.radius
        self._plan, self._planned = plan, ground
        return plan

    def _follow_plan(self, cycle: _Cycle) -> None:
        """The paper's two states, and ours for stand-offs."""
        plan, points, active = cycle.plan, cycle.points, cycle.active
        eta = np.full(len(points), np.inf)
        for k in active:
            eta[k] = self._eta(plan, points[k])
        cycle.eta = eta
        if self._state == "partial":
            if self._variant.adaptive_roles or self._leader < 0:
                self._leader = choose_leader(eta, self._leader, self._settings.d_switch)
            if self._leader >= 0 and eta[self._leader] < self._settings.lookahead:
                self._state = "final"
                self._monitor.reset()
        if self._variant.improved:
            self._watch(cycle)
        if self._state == "partial":
            self._partial(cycle)
        elif self._state == "final":
            self._final(cycle)
        elif self._state == "resolving":
            self._resolve(cycle)
        else:
            cycle.report(self._roles_or_none(cycle.team), ())
        self._view = cycle.view(self, self._view.message, self._view.involved)

    def _partial(self, cycle: _Cycle) -> None:
        plan, points, team = cycle.plan, cycle.points, cycle.team
        way = descend_from(plan.field, points[self._leader])
        heading = _direction(way.points)
        if self._variant.adaptive_roles or len(self._roles) == 0:
            self._roles = assign_followers(
                points, self._leader, heading, team.formation.slots, cycle.active
            )
        if self._variant.lookahead:
            anchor, there = way.ahead(self._settings.lookahead)
        else:
            anchor, there = points[self._leader], heading
        goals = partial_goals(
            plan.ground, anchor, there, team.formation.slots, self._settings.w_min_partial
        )
        targets = _by_robot(goals, self._roles)
        paths = [np.empty((0, 2))] * len(points)
        paths[self._leader] = way.points
        self._drive(cycle, targets, paths, np.full(len(points), np.inf))
        self._rank = _order(cycle.eta)

    def _final(self, cycle: _Cycle) -> None:
        plan, points = cycle.plan, cycle.points
        if self._variant.adaptive_roles or len(self._roles) == 0:
            self._roles = assign_goals(points, plan.places, cycle.active)
        targets = _by_robot(plan.places, self._roles)
        away = _distance(points, targets)
        self._drive(cycle, targets, [np.empty((0, 2))] * len(points), away)
        self._rank = _order(cycle.eta)
        cycle.final = True

    def _resolve(self, cycle: _Cycle) -> None:
        plan, points = cycle.plan, cycle.points
        if self._resolver is None:
            roles = assign_goals(points, plan.places, cycle.active)
            self._resolver = Resolver(roles)
        single = self._resolver.plan(plan, points, cycle.active, cycle.eta, cycle.time)
        self._roles, self._rank = single.roles, single.rank
        targets = _by_robot(plan.places, self._roles)
        velocity = np.zeros((len(points), 2))
        for k in cycle.active:
            velocity[k] = self._top_x * _unit(single.ways[k].points)
        away = _distance(points, targets)
        self._shape(cycle, velocity, away, springs=False)
        cycle.report(self._roles, tuple(way.points for way in single.ways), targets)
        cycle.away, cycle.final = away, True

    def _drive(self, cycle: _Cycle, targets: Array, paths: list[Array], away: Array) -> None:
        """Desired velocities along local paths, then steps 9 to 11 of the cycle."""
        ground, points = cycle.plan.ground, cycle.points
        velocity = np.zeros((len(points), 2))
        for k in cycle.active:
            if len(paths[k]) == 0:
                paths[k] = _local_way(ground, points[k], targets[k])
            velocity[k] = self._top_x * _unit(paths[k])
        self._shape(cycle, velocity, away, self._variant.springs)
        cycle.report(self._roles, tuple(paths), targets)
        cycle.away = away

    def _shape(self, cycle: _Cycle, velocity: Array, away: Array, springs: bool) -> None:
        settings, ground, points = self._settings, cycle.plan.ground, cycle.points
        cycle.intent = velocity.copy()
        if springs and len(cycle.team.rest):
            pairs = cycle.team.pairs(self._roles)
            previous = self._lengths
            if pairs.shape != self._joined.shape:
                previous = np.full(len(pairs), np.nan)
            elif (pairs != self._joined).any():
                previous = np.where((pairs == self._joined).all(axis=1), previous, np.nan)
            self._lengths = _kernels.add_springs(
                velocity, points, pairs, cycle.team.rest, cycle.team.laws, previous, self._period
            )
            self._joined = pairs
            if self._variant.improved:
                _spare_pace(velocity, cycle.intent, _HELD_BACK * self._top_x)
        if self._variant.avoidance:
            _kernels.avoid_obstacles(
                velocity, points, ground.speed_b, ground.cell, settings.d_safe_b,
                settings.w_min_avoid,
            )  # fmt: skip
            if self._variant.improved:
                # A slot may lie close to an obstacle; there the last filter is enough.
                docking = away < _DOCKING
                velocity[docking] = cycle.intent[docking]
        _kernels.limit_speeds(
            velocity, cycle.poses[:, 2], ground.speed_at(points), away,
            np.array([self._top_x, self._top_y, settings.v_min, settings.d_slowdown * (_BRISK if self._variant.improved else 1.0)]),
        )  # fmt: skip
        velocity[~cycle.team.present] = 0.0
        cycle.velocity = velocity

    def _follow_baseline(self, cycle: _Cycle) -> None:
        if self._leader < 0:
            self._leader = int(cycle.active[0])
        if len(self._roles) == 0:
            self._roles = assign_goals(cycle.points, cycle.plan.places, cycle.active)
        velocity, targets, paths, final = behave(
            self._variant, cycle.plan, cycle.team, cycle.points, self._roles,
            self._settings, self._top_x,
        )  # fmt: skip
        self._state = "final" if final else "partial"
        places = _by_robot(cycle.plan.places, self._roles)
        cycle.away = _distance(cycle.points, places) if final else np.full(len(places), np.inf)
        self._shape(cycle, velocity, cycle.away, springs=False)
        cycle.report(self._roles, paths, targets)
        cycle.final = final
        self._view = cycle.view(self)

    def _watch(self, cycle: _Cycle) -> None:
        """Notice stand-offs, resolve them, and return to the shape when they are over."""
        plan, points, active = cycle.plan, cycle.points, cycle.active
        ahead = float(cycle.eta[active].min())
        total = float(np.minimum(cycle.eta[active], 1e3).sum())
        if self._state == "final" or (self._state == "resolving" and ahead < 1.0):
            targets = _by_robot(plan.places, self._roles) if len(self._roles) else points
            away = _distance(points, targets)[active]
            if away.max() < 0.08:
                self._monitor.reset()
                return
            measure = float(away.sum())
        else:
            measure = total / len(active)
        if self._state == "resolving":
            gained = self._resolved_from - float(np.median(cycle.eta[active]))
            if gained > 2.0 * (1 + self._attempts) and ahead > self._settings.lookahead:
                self._state, self._resolver = "partial", None
                self._monitor.reset()
                return
        if self._monitor.stalled(measure, cycle.time):
            self._monitor.reset()
            self._attempts += 1
            if self._attempts > _ATTEMPTS:
                away = _distance(points, _by_robot(plan.places, self._roles))
                late = tuple(int(k) for k in active if away[k] > 0.1)
                self._state = "stuck"
                self._view = View(message=f"stand-off of {_named(late)}", involved=late)
                return
            self._state, self._resolver = "resolving", None
            self._resolved_from = float(np.median(cycle.eta[active]))

    def _yaw_rates(self, cycle: _Cycle) -> Array:
        """Turn to the direction of motion; near its final slot, to the goal's heading."""
        poses, velocity = cycle.poses, cycle.velocity
        assert velocity is not None
        aim = np.arctan2(velocity[:, 1], velocity[:, 0])
        moving = np.hypot(velocity[:, 0], velocity[:, 1]) > 0.02
        aim = np.where(moving, aim, poses[:, 2])
        if cycle.final:
            aim = np.where(cycle.away < _NEAR, cycle.plan.pose[2], aim)
        rate = _TURN_GAIN * wrap_angle(aim - poses[:, 2])
        rate[~cycle.team.present] = 0.0
        return np.clip(rate, -self._turn, self._turn)

    def _advance_waypoint(self, cycle: _Cycle, velocities: Array) -> None:
        if not cycle.final or self._waypoint >= len(self.goals) - 1:
            return
        if cycle.away[cycle.active].max() < _PASSED:
            self._waypoint += 1
            self.restart()
            self._view = cycle.view(self)

    def _eta(self, plan: GoalPlan, point: Array) -> float:
        eta = plan.field.eta(point)
        if np.isfinite(eta):
            return eta
        near = plan.field.nearest_reached(point, reach=1.5)
        return (
            np.inf
            if near is None
            else plan.field.eta(near) + 10.0 * float(np.hypot(*(near - point)))
        )

    def _roles_or_none(self, team: Team) -> NDArray[np.int64]:
        return self._roles if len(self._roles) else np.full(team.size, -1, dtype=np.int64)


@dataclass
class _Cycle:
    """What one cycle knows and finds out."""

    plan: GoalPlan
    team: Team
    poses: Array
    points: Array
    active: NDArray[np.int64]
    time: float
    eta: Array = field(default_factory=lambda: np.empty(0))
    velocity: Array | None = None
    intent: Array | None = None
    away: Array = field(default_factory=lambda: np.empty(0))
    final: bool = False
    roles: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    paths: tuple[Array, ...] = ()
    targets: Array | None = None

    def report(
        self, roles: NDArray[np.int64], paths: tuple[Array, ...], targets: Array | None = None
    ) -> None:
        self.roles, self.targets = roles, targets
        self.paths = paths or (np.empty((0, 2)),) * len(self.poses)

    def view(self, navigator: Navigator, message: str = "", involved: tuple[int, ...] = ()) -> View:
        arrived = self.final and bool(self.away[self.active].max() < 0.05)
        eta = self.eta if len(self.eta) else np.full(len(self.poses), np.inf)
        leads = navigator._state == "partial"
        return View(
            state=navigator._state,
            leader=navigator._leader if leads else -1,
            roles=self.roles.copy(),
            targets=self.targets,
            goal=self.plan.pose,
            paths=self.paths,
            eta=eta,
            arrived=arrived,
            waypoint=navigator._waypoint,
            goal_moved=self.plan.moved,
            involved=involved,
            message=message,
        )


def _by_robot(places: Array, roles: NDArray[np.int64]) -> Array:
    """Places of slots `(S, 2)` as places of robots `(N, 2)`, nan for those without a slot."""
    padded = np.vstack([places, [np.nan, np.nan]])
    return padded[roles]


def _distance(points: Array, targets: Array) -> Array:
    """Distances `(N,)`; inf where there is no target."""
    offset = points - targets
    return np.nan_to_num(np.hypot(offset[:, 0], offset[:, 1]), nan=np.inf)


def _unit(path: Array) -> Array:
    """Initial direction of a path as a unit vector; zero without one."""
    if len(path) < 2:
        return np.zeros(2)
    step = path[min(_FIRST, len(path) - 1)] - path[0]
    length = float(np.hypot(step[0], step[1]))
    return step / length if length > 1e-9 else np.zeros(2)


def _spare_pace(velocity: Array, intent: Array, most: float) -> None:
    """Let springs slow a robot on its way by `most` m/s at the utmost; what turns it stays."""
    pace = np.hypot(intent[:, 0], intent[:, 1])
    course = intent / np.maximum(pace, 1e-9)[:, None]
    back = -((velocity - intent) * course).sum(axis=1)
    velocity += np.maximum(back - most, 0.0)[:, None] * course


def _order(eta: Array) -> NDArray[np.int64]:
    """Precedence `(N,)`: 0 for the least time."""
    rank = np.empty(len(eta), dtype=np.int64)
    rank[np.argsort(eta, kind="stable")] = np.arange(len(eta))
    return rank


def _direction(path: Array) -> float:
    step = _unit(path)
    return float(np.arctan2(step[1], step[0]))


def _local_way(ground: Ground, start: Array, goal: Array) -> Array:
    """The local path on W_B; from the inflated zone first to the nearest free ground."""
    grid = ground.follower
    if not grid.is_free(start):
        out = grid.nearest_free(start, reach=1.5)
        if out is None:
            return np.empty((0, 2))
        rest, _ = grid.local_path(out, goal)
        return np.vstack([start, out]) if len(rest) == 0 else np.vstack([start, rest])
    return grid.local_path(start, goal)[0]


def _named(robots: tuple[int, ...]) -> str:
    names = ", ".join(str(k) for k in robots)
    return f"robot {names}" if len(robots) == 1 else f"robots {names}"
