"""What one planner cycle knows, finds out and reports. In the grid's frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array, wrap_angle
from cavalcade.recording.status import PlannerStatus

if TYPE_CHECKING:
    from cavalcade.formation.goals import GoalPlan
    from cavalcade.formation.team import Team

_THERE = 0.09  # m and
_TURNED = 0.13  # rad from its final pose within which a robot has arrived
_FIRST = 0.15  # m of a path that give its initial direction
_AHEAD = 0.40  # m of a path that give the heading to take up
EMPTY_PATH: Array = np.empty((0, 2))


@dataclass
class Cycle:
    """The working state of one cycle.

    Attributes:
        plan: Of the present goal.
        team: Who takes part.
        poses, points: `(N, 3)` and `(N, 2)`.
        active: Robots that take part.
        time: Now, s.
        eta: `(N,)` times to the goal, s.
        velocity: `(N, 2)` wanted, m/s; None where nobody is to move.
        away: `(N,)` distances to the final slots, m; inf unless `final`.
        final: Robots drive to their final slots.
        roles, paths: As reported.
        targets: `(N, 2)` the robots' present goals, nan for none, m.
        detours: Places `(2,)` where stuck robots go to turn, by robot, m.
        facing: `(N,)` headings that robots are to take up or keep, rad; nan for as usual.
    """

    plan: GoalPlan
    team: Team
    poses: Array
    points: Array
    active: NDArray[np.int64]
    time: float
    eta: Array = field(init=False)
    velocity: Array | None = None
    away: Array = field(init=False)
    final: bool = False
    roles: NDArray[np.int64] = field(init=False)
    paths: tuple[Array, ...] = ()
    targets: Array = field(init=False)
    detours: dict[int, Array] = field(default_factory=dict)
    facing: Array = field(init=False)

    def __post_init__(self) -> None:
        count = len(self.poses)
        self.facing = np.full(count, np.nan)
        self.targets = np.full((count, 2), np.nan)
        self.eta = np.full(count, np.inf)
        self.away = np.full(count, np.inf)
        self.roles = np.full(count, -1, dtype=np.int64)
        self.paths = (EMPTY_PATH,) * count

    def go_to_slots(self, roles: NDArray[np.int64]) -> None:
        """Take up final slots `(N,)`."""
        self.final, self.roles = True, roles
        self.targets = by_robot(self.plan.places, roles)
        self.away = distances(self.points, self.targets)

    def headings(self) -> Array:
        """Directions of motion `(N,)`, rad; the present heading of a robot that stands."""
        velocity = np.zeros_like(self.points) if self.velocity is None else self.velocity
        aim = np.arctan2(velocity[:, 1], velocity[:, 0])
        moving = np.hypot(velocity[:, 0], velocity[:, 1]) > 0.02
        return np.where(moving, aim, self.poses[:, 2])

    def plan_distances(self, roles: NDArray[np.int64]) -> Array:
        """Distances `(A,)` of the active robots to their final slots, m."""
        if len(roles) == 0:
            return np.full(len(self.active), np.inf)
        return distances(self.points, by_robot(self.plan.places, roles))[self.active]

    def status(
        self,
        state: str,
        leader: int,
        waypoint: int,
        message: str = "",
        involved: tuple[int, ...] = (),
    ) -> PlannerStatus:
        """The report of this cycle in the grid's frame; goals are nan where there are none."""
        turned = np.abs(wrap_angle(self.poses[:, 2] - self.plan.pose[2])) < _TURNED
        there = (self.away < _THERE) & turned
        return PlannerStatus(
            state=state,
            leader=leader if state == "partial" else -1,
            roles=self.roles.copy(),
            goals=self.targets,
            goal=self.plan.pose,
            paths=self.paths,
            eta=self.eta,
            arrived=self.final and bool(there[self.active].all()),
            waypoint=waypoint,
            goal_moved=self.plan.moved,
            involved=involved,
            message=message,
        )


def by_robot(places: Array, roles: NDArray[np.int64]) -> Array:
    """Places of slots `(S, 2)` as places of robots `(N, 2)`, nan for those without a slot."""
    return np.vstack([places, [np.nan, np.nan]])[roles]


def distances(points: Array, targets: Array) -> Array:
    """Distances `(N,)`; inf where there is no target."""
    offset = points - targets
    away = np.hypot(offset[:, 0], offset[:, 1])
    away[np.isnan(away)] = np.inf
    return away


def direction(path: Array, reach: float = _FIRST) -> Array:
    """Unit vector from a path's start to its point `reach` m on; zero without a path."""
    if len(path) < 2:
        return np.zeros(2)
    x, y = path[0].tolist()
    second = path[1].tolist()
    spacing = max(float(np.hypot(second[0] - x, second[1] - y)), 1e-3)
    there = path[min(max(int(reach / spacing + 0.5), 1), len(path) - 1)].tolist()
    dx, dy = there[0] - x, there[1] - y
    length = float(np.hypot(dx, dy))
    return np.array([dx / length, dy / length]) if length > 1e-9 else np.zeros(2)


def path_heading(path: Array) -> float | None:
    """Direction of the path ahead in rad, None without one."""
    course = direction(path, _AHEAD)
    return float(np.arctan2(course[1], course[0])) if course.any() else None


def order_of(eta: Array) -> NDArray[np.int64]:
    """Precedence `(N,)`: 0 for the least time."""
    return np.argsort(np.argsort(eta, kind="stable"))


def named(robots: tuple[int, ...]) -> str:
    """`robot 2` or `robots 1, 3`."""
    names = ", ".join(str(k) for k in robots)
    return f"robot {names}" if len(robots) == 1 else f"robots {names}"
