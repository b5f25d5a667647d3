"""The planner's states and what the team wants to do in each (Norén et al., section 2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation._clearance import Footprint, ObstacleBoxes, Surroundings
from cavalcade.formation.baselines import rigid_maps, seek_and_space, virtual_structure
from cavalcade.formation.cycle import (
    EMPTY_PATH,
    Cycle,
    by_robot,
    direction,
    distances,
    named,
    order_of,
)
from cavalcade.formation.deadlock import DeadlockMonitor
from cavalcade.formation.dynamic_avoidance import DynamicAvoidance
from cavalcade.formation.goals import (
    GoalPlan,
    descend_from,
    eta_from,
    local_path,
    partial_goals,
)
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.roles import assign_followers, assign_goals, choose_leader
from cavalcade.formation.settings import FormationSettings, Variant
from cavalcade.formation.shaping import Shaper
from cavalcade.formation.stuck_recovery import StuckRecovery
from cavalcade.formation.team import Team
from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel

_LONGER, _LATER = 1.1, 0.3  # how much longer than last cycle's, in share and s, a path may get
_PASSED = 0.25  # m from all slots at which a waypoint counts as reached
_TIGHTER = (0.25, 0.21)  # m: inflation radii tried where r_max leaves no path


class Navigator:
    """Turns goals and poses into wanted velocities. In the grid's frame throughout.

    It `plans` by itself, or goes by plans that it is given and stands while it has none.

    Attributes:
        goals: `(G, 3)` poses to drive to.
        waypoint: Index of the present one.
        plan: For it, None where there is none yet.
        following: The plan for the next one, where it is made beforehand.
        radius: Inflation of the present plan, m.
        status: What the last cycle came to; slots and connections are left out, and goals are
            nan where there are none.
    """

    def __init__(
        self,
        team: Team,
        variant: Variant,
        settings: FormationSettings,
        model: RobotModel,
        period: float,
        rng: np.random.Generator,
        error: float = 0.0,
        plans: bool = True,
    ) -> None:
        self._plans = plans
        self._team = team
        self._variant = variant
        self._settings = settings
        self._shaper = Shaper(variant, settings, model, period)
        self._footprint = Footprint.of(model.length, model.width)
        self._deadlock = DeadlockMonitor(settings.lookahead, rng)
        self._recovery = StuckRecovery(model)
        self._avoidance = DynamicAvoidance(model, self._shaper.top, error)
        self._evading: list[int] = []
        self.goals: Array = np.empty((0, 3))
        self.radius = settings.r_max
        self.waypoint = 0
        self.restart()

    def set_goals(self, goals: Array, keep: bool = False) -> None:
        """Replace the goals `(G, 3)`; `keep` says that they are the same ones, seen anew."""
        self.goals = goals
        if keep:
            self._recovery.restart()  # what they remember is in the old frame
            self._avoidance.forget()
        else:
            self.waypoint = 0
            self.restart()

    def expect_boxes(self) -> None:
        """Say that something beside the map will have to be avoided."""
        if self._variant.improved:
            self._avoidance.get_ready()

    def restart(self) -> None:
        """Begin the present goal anew: it, the shape or the team has changed."""
        self._state = "partial" if len(self.goals) else "inactive"
        self._leader = -1
        self._roles: NDArray[np.int64] = np.empty(0, np.int64)
        self._rank: NDArray[np.int64] | None = None
        self._times: dict[int, float] = {}
        self.status = self._idle()
        self._shaper.reset()
        self._deadlock.restart()
        self._recovery.restart()
        self.refresh()

    def refresh(self) -> None:
        """The maps have changed: plan anew, keep state and roles."""
        self.plan: GoalPlan | None = None
        self._planned: PlanningMaps | None = None
        self.following: GoalPlan | None = None
        self._deadlock.refresh()
        if self._state in ("stuck", "infeasible"):
            self._state = "partial"

    def rest(self) -> None:
        """The team is to stand, whatever it was doing; the time counts for nobody's patience."""
        self._evading = []
        self._shaper.forget_springs()
        self._deadlock.refresh()
        self._recovery.go_on()

    @property
    def last(self) -> bool:
        """Whether the present goal is the last one."""
        return self.waypoint >= len(self.goals) - 1

    def rank(self) -> NDArray[np.int64]:
        """Precedence `(N,)` of the robots, 0 first: those that evade before all others."""
        rank = np.arange(self._team.size) if self._rank is None else self._rank
        if not self._evading:
            return rank
        late = [k for k in np.argsort(rank, kind="stable") if k not in self._evading]
        return np.argsort([*self._evading, *late])

    def evading(self) -> NDArray[np.bool_]:
        """`(N,)` which robots get out of the way of dynamic obstacles."""
        evading = np.zeros(self._team.size, np.bool_)
        evading[self._evading] = True
        return evading

    def _idle(self) -> PlannerStatus:
        """The report of a team that nothing is known of yet."""
        count = self._team.size
        return PlannerStatus(
            state=self._state,
            roles=np.full(count, -1, dtype=np.int64),
            goals=np.full((count, 2), np.nan),
            paths=(EMPTY_PATH,) * count,
            eta=np.full(count, np.inf),
            waypoint=self.waypoint,
        )

    def step(
        self,
        maps: PlanningMaps,
        poses: Array,
        velocities: Array,
        time: float,
        boxes: ObstacleBoxes,
    ) -> Array:
        """Wanted velocities `(N, 3)`: m/s, m/s, rad/s; the limits of eq. 7 hold for them."""
        self._evading = []
        team, active = self._team, self._team.active
        wanted = np.zeros((len(poses), 3))
        if self._state == "inactive" or len(active) == 0:
            self.status = self._idle()
            return wanted
        points = np.ascontiguousarray(poses[:, :2])
        if self._plans and (self.plan is None or self._planned is not maps):
            goal, slots = self.goals[self.waypoint], team.formation.slots
            self.adopt(self.plan_goal(maps, goal, slots, points[active]), maps)
        plan = self.plan
        if plan is None:
            self.status = self._idle()
            return wanted
        cycle = Cycle(plan, team, poses, points, active, time)
        if self._state == "infeasible":
            self._state = "partial"  # for a path may be free again
        message = ""
        involved: tuple[int, ...] = ()
        if len(plan.cut_off) > 0:
            self._state = "infeasible"
            involved = tuple(int(active[k]) for k in plan.cut_off)
            why = f": {plan.problem}" if plan.problem else ""
            message = f"no path to the goal for {named(involved)}{why}"
        elif self._state == "stuck":
            message, involved = self.status.message, self.status.involved
            cycle.roles = self._roles if len(self._roles) else cycle.roles
        elif self._variant.rigid or not self._variant.common_plan:
            self._follow_baseline(cycle)
        else:
            message, involved = self._follow_plan(cycle)
        if cycle.velocity is not None:
            wanted[:, :2] = cycle.velocity
            wanted[:, 2] = self._shaper.yaw_rates(cycle)
        if self._variant.improved and len(boxes.poses):
            around = Surroundings(maps.distance, maps.cell, *boxes)
            self._evading = self._avoidance.apply(
                wanted, poses, velocities, active, around, self.radius
            )
        self.status = cycle.status(self._state, self._leader, self.waypoint, message, involved)
        self._advance_waypoint(cycle)
        return wanted

    def plan_goal(self, maps: PlanningMaps, goal: Array, slots: Array, points: Array) -> GoalPlan:
        """The plan for a goal `(3,)` and robots at `points` `(S, 2)`, in any thread."""
        used = rigid_maps(maps, slots) if self._variant.rigid else maps
        plan = GoalPlan(used, goal, slots, points, self._footprint)
        for radius in _TIGHTER if self._variant.improved else ():
            if len(plan.cut_off) == 0 or radius >= self._settings.r_max:
                break
            other = GoalPlan(maps.tightened(radius), goal, slots, points, self._footprint)
            if len(other.cut_off) == 0:
                plan = other
        return plan

    def adopt(self, plan: GoalPlan | None, maps: PlanningMaps) -> None:
        """Go on with a plan of the present goal, shape and team, on these maps."""
        self.plan, self._planned = plan, maps
        if plan is not None:
            self.radius = min(plan.maps.radius, self._settings.r_max)

    def _follow_plan(self, cycle: Cycle) -> tuple[str, tuple[int, ...]]:
        """The paper's two states, and ours for deadlocks. Returns message and robots involved."""
        for k in cycle.active:
            cycle.eta[k] = eta_from(cycle.plan.field, cycle.points[k])
        self._rank = order_of(cycle.eta)
        if self._state == "partial":
            if self._variant.adaptive_roles or self._leader < 0:
                self._leader = choose_leader(cycle.eta, self._leader, self._settings.d_switch)
            if self._leader >= 0 and cycle.eta[self._leader] < self._settings.lookahead:
                self._state = "final"
                self._deadlock.refresh()
        if self._variant.recovery:
            self._state = self._deadlock.next_state(self._state, cycle, self._roles)
        if self._state == "stuck":
            cycle.roles = self._roles if len(self._roles) else cycle.roles
            late = self._deadlock.late
            return f"deadlock of {named(late)}", late
        if self._state == "resolving":
            self._resolve(cycle)
        elif self._state == "final":
            self._final(cycle)
        elif self._leader >= 0:
            self._partial(cycle)
        return "", ()

    def _partial(self, cycle: Cycle) -> None:
        """Steps 3 to 8: the leader follows its path, the others their partial goals."""
        plan, points, slots = cycle.plan, cycle.points, cycle.team.formation.slots
        path = descend_from(plan.field, points[self._leader])
        if len(path.points) == 0:
            cycle.roles = self._roles if len(self._roles) else cycle.roles
            return  # no free ground within reach: the team stands
        course = direction(path.points)
        heading = float(np.arctan2(course[1], course[0]))
        if self._variant.adaptive_roles or len(self._roles) == 0:
            self._roles = assign_followers(points, self._leader, heading, slots, cycle.active)
        anchor = points[self._leader]
        if self._variant.lookahead:
            anchor, heading = path.ahead(self._settings.lookahead)
        goals = partial_goals(plan.maps, anchor, heading, slots, self._settings.w_min_partial)
        cycle.targets = by_robot(goals, self._roles)
        self._drive(cycle, {self._leader: path.points})

    def _final(self, cycle: Cycle) -> None:
        """Step 7: everyone to the nearest slots at the goal."""
        if self._variant.adaptive_roles or len(self._roles) == 0:
            self._roles = assign_goals(cycle.points, cycle.plan.places, cycle.active)
        cycle.go_to_slots(self._roles)
        if self._variant.recovery and self._recovery.update(cycle):
            self._deadlock.refresh()
        self._drive(cycle, {})

    def _resolve(self, cycle: Cycle) -> None:
        """One by one along each robot's own field."""
        if not self._slot_fields_are_there(cycle):
            self._deadlock.refresh()
            cycle.roles = self._roles if len(self._roles) else cycle.roles
            return  # the team stands until they are
        single = self._deadlock.single_file(cycle)
        self._roles, self._rank = single.roles, single.rank
        cycle.go_to_slots(self._roles)
        if self._recovery.update(cycle, single.paths):
            self._deadlock.refresh()
        paths, courses = list(single.paths), single.courses
        for k, place in cycle.detours.items():
            paths[k], _ = local_path(cycle.plan.maps, cycle.points[k], place)
            courses[k] = direction(paths[k])
        cycle.paths = tuple(paths)
        self._shaper.shape(cycle, courses * self._shaper.top, springs=False)

    def _slot_fields_are_there(self, cycle: Cycle) -> bool:
        """Whether all of them are; those that are not are going to be made."""
        points = cycle.points[cycle.active]
        known = [cycle.plan.has_slot_field(k, points) for k in range(len(cycle.plan.places))]
        return all(known)

    def _drive(self, cycle: Cycle, known: dict[int, Array]) -> None:
        """Desired velocities along paths (local ones but for `known`), then steps 9 to 11."""
        maps, points, targets = cycle.plan.maps, cycle.points, cycle.targets
        cycle.roles = self._roles
        paths = [EMPTY_PATH] * len(points)
        desired = np.zeros((len(points), 2))
        slots, places = self._roles.tolist(), points[cycle.active]
        for k in cycle.active:
            path = known.get(int(k))
            if int(k) in cycle.detours:
                path, _ = local_path(maps, points[k], cycle.detours[int(k)])
            elif path is None and cycle.final and cycle.plan.has_slot_field(slots[k], places):
                field = cycle.plan.slot_field(slots[k], places)
                path = descend_from(field, points[k]).points
            elif path is None:
                guess = _LONGER * self._times.get(int(k), np.inf) + _LATER
                path, self._times[int(k)] = local_path(maps, points[k], targets[k], guess)
            paths[k] = path
            desired[k] = self._shaper.top * direction(paths[k])
        cycle.paths = tuple(paths)
        self._shaper.shape(cycle, desired, springs=True)

    def _follow_baseline(self, cycle: Cycle) -> None:
        if self._leader < 0:
            self._leader = int(cycle.active[0])
        if len(self._roles) == 0:
            self._roles = assign_goals(cycle.points, cycle.plan.places, cycle.active)
        cycle.roles = self._roles
        behave = virtual_structure if self._variant.rigid else seek_and_space
        desired = behave(cycle, self._settings.lookahead, self._shaper.top)
        self._state = "final" if cycle.final else "partial"
        if cycle.final:
            cycle.away = distances(cycle.points, by_robot(cycle.plan.places, self._roles))
        self._shaper.shape(cycle, desired, springs=False)

    def _advance_waypoint(self, cycle: Cycle) -> None:
        if self.last or not cycle.final or cycle.away[cycle.active].max() >= _PASSED:
            return
        if self._plans or self.following is not None:
            self.waypoint += 1
            status, following, maps = self.status, self.following, self._planned
            self.restart()
            if following is not None and maps is not None:
                self.adopt(following, maps)
            self.status = replace(status, state="partial", arrived=False)
