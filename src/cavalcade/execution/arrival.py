"""When a team has arrived: every robot in its slot, turned right and standing, for a while."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from cavalcade.geometry import Array, transform_points, wrap_angle
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Scenario


@dataclass(frozen=True)
class ArrivalTolerance:
    """How near is near enough: m, rad, m/s, and for how many seconds.

    Trunks of walking robots sway: with `mean`, the limit of the speed is one of the mean velocity
    over these seconds, not of every moment's.
    """

    position: float = 0.10
    heading: float = 0.15
    speed: float = 0.02
    hold: float = 0.5
    mean: bool = False


IDEAL = ArrivalTolerance()
PHYSICS = ArrivalTolerance(position=0.15, heading=0.2, speed=0.05, mean=True)
LIVE = replace(PHYSICS, mean=False)  # robots that are only located say mean velocities anyway


def tolerance_of(scenario: Scenario) -> ArrivalTolerance:
    """What counts as arrived for the robots of a scenario."""
    return {"ideal": IDEAL, "mujoco": PHYSICS}.get(scenario.execution.backend, LIVE)


def slot_poses(status: PlannerStatus) -> Array | None:
    """Poses `(N, 3)` of each robot's slot at the goal or of its own goal, None without a goal.

    Robots without a slot get rows of infinity.
    """
    if status.targets is not None:
        return status.targets
    goal = status.goal
    if goal is None:
        return None
    result = np.full((len(status.roles), 3), np.inf)
    has_slot = (status.roles >= 0) & (status.roles < len(status.slots))
    places = transform_points(goal, status.slots)
    result[has_slot, :2] = places[status.roles[has_slot]]
    result[has_slot, 2] = goal[2]
    return result


def has_goal(status: PlannerStatus) -> bool:
    """Whether the team, or each of its robots, has a goal."""
    return status.goal is not None or status.targets is not None


class ArrivalMonitor:
    """Judges true poses cycle by cycle.

    A planner may forget its goal once it thinks that it has arrived, so the last goal and roles
    that it named stay in force until it names others.
    """

    def __init__(self, tolerance: ArrivalTolerance = IDEAL) -> None:
        self._tolerance = tolerance
        self._since: float | None = None
        self._places: deque[tuple[float, Array]] = deque()
        self._status: PlannerStatus | None = None

    def update(
        self,
        time: float,
        poses: Array,
        velocities: Array,
        status: PlannerStatus,
        last_waypoint: int,
    ) -> bool:
        """Whether the team has arrived at its last goal, of index `last_waypoint`.

        Poses and velocities are the true ones at `time` s, `(N, 3)`, map frame.
        """
        if has_goal(status):
            self._status = status
        latest = self._status
        if latest is None or latest.waypoint < last_waypoint:
            self._since = None
            return False
        targets = slot_poses(latest)
        if targets is None or not self._near(poses, velocities, targets):
            self._since = None
            return False
        if self._since is None:
            self._since = time
            self._places.clear()
        held = time - self._since >= self._tolerance.hold - 1e-9
        if self._tolerance.mean:
            held &= self._slow(time, poses[np.isfinite(targets).all(axis=1), :2])
        return held

    def _slow(self, time: float, places: Array) -> bool:
        """Whether no robot got on faster than it may since `hold` s ago; places `(K, 2)`, m."""
        kept = self._places
        kept.append((time, places.copy()))
        while kept[0][0] <= time - self._tolerance.hold + 1e-9:
            kept.popleft()
        before, there = kept[0]
        if before >= time or there.shape != places.shape:
            return False
        moved = np.hypot(*(places - there).T)
        return bool((moved <= self._tolerance.speed * (time - before)).all())

    def _near(self, poses: Array, velocities: Array, targets: Array) -> bool:
        active = np.isfinite(targets).all(axis=1)
        if not active.any():
            return False
        off = poses[active] - targets[active]
        limit = self._tolerance
        return bool(
            (np.hypot(off[:, 0], off[:, 1]) <= limit.position).all()
            and (np.abs(wrap_angle(off[:, 2])) <= limit.heading).all()
            and (limit.mean or (np.hypot(*velocities[active, :2].T) < limit.speed).all())
        )
