"""Goals of single robots become a plan: of all, or of those that can be reached together."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from cavalcade.coordination import PlanSettings, TeamPlan, TeamProblem, plan_team
from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.time_scaling import FollowSettings
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel
from cavalcade.world import Box, Circle, OccupancyMap, Terrain
from cavalcade.world.gaps import Body, body_at, gap_between

Pose = tuple[float, float, float]

Goals = tuple[Pose | None, ...]
"""Of each robot; None of one that stays where it is."""

_ROOM = 0.05
"""By so much robots that are obstacles are inflated, where others leave space for it, m."""

_NEXT = 0.02
"""What is near an obstacle that has come is in it, m."""


@dataclass(frozen=True, eq=False)
class Team:
    """What all plans of a team have in common.

    Attributes:
        models: Of each robot.
        terrain: Heights on the map's grid; None for flat ground.
        rate: Cycles per second.
        settings: How it is planned,
        seed: with these random numbers,
        following: and how plans are followed.
    """

    models: tuple[RobotModel, ...]
    terrain: Terrain | None
    rate: float
    settings: PlanSettings
    seed: int
    following: FollowSettings


@dataclass(frozen=True, eq=False)
class Request:
    """A plan that is asked for.

    Attributes:
        map: The ground.
        starts: `(N, 3)` where the robots stand, or will have come to rest, map frame.
        asked: The goals that are wanted,
        agreed: and those of the present plan.
        latest: All robots, the one whose goal was asked for last first.
        fixed: Robots that are nothing but obstacles.
        keep: Whether the present plan can go on.
        cancelled: Whether nobody wants the plan any more.
    """

    map: OccupancyMap
    starts: Array
    asked: Goals
    agreed: Goals
    latest: tuple[int, ...]
    fixed: frozenset[int]
    keep: bool
    cancelled: Callable[[], bool]


@dataclass(frozen=True, eq=False)
class Answer:
    """What came of a request.

    Attributes:
        goals: That are driven to.
        refused: Why other goals are not, by robot.
        fixed: Robots that the plan takes for obstacles.
        follower: Of the plan; None if the present one goes on.
    """

    goals: Goals
    refused: Mapping[int, str] = field(default_factory=dict)
    fixed: frozenset[int] = frozenset()
    follower: PlanFollower | None = None


def answer(team: Team, request: Request) -> Answer | None:
    """Plan for the goals that are asked for; None if that was cancelled.

    Where no plan leads to all of them goals are left out, one after the other: those that are new
    first, the latest of all at the head; such a robot keeps the goal that it has. If what is left
    cannot be reached any more, as the world has changed, robots stay where they are; if one stands
    where nobody can, it is an obstacle.
    """
    goals, fixed, refused = list(request.asked), set(request.fixed), dict[int, str]()
    for robot in fixed:
        goals[robot] = None
    while True:
        if request.keep and all(
            goal == former or robot in request.fixed
            for robot, (goal, former) in enumerate(zip(goals, request.agreed, strict=True))
        ):
            return Answer(request.agreed, refused)
        free = [robot for robot in range(len(goals)) if robot not in fixed]
        plan = _planned(team, request, goals, free) if free else None
        if request.cancelled():
            return None
        if plan is None or plan.solved:
            return _followed(team, request, goals, fixed, refused, free, plan)
        involved = [free[k] for k in plan.involved] or free
        concerned = [robot for robot in request.latest if robot in involved]
        new = [k for k in concerned if goals[k] is not None and goals[k] != request.agreed[k]]
        driving = [k for k in concerned if goals[k] is not None]
        if new:
            robot = new[0]
            refused[robot] = _reason(plan, robot, goals, free, fixed)
            goals[robot] = request.agreed[robot]
        elif driving:
            robot = driving[0]
            refused[robot] = _reason(plan, robot, goals, free, fixed)
            goals[robot] = None
        else:
            robot = concerned[0]
            refused[robot] = _reason(plan, robot, goals, free, fixed)
            fixed.add(robot)


def meets(map: OccupancyMap, model: RobotModel, poses: Array, before: OccupancyMap) -> int | None:
    """The first of poses `(K, 3)` at which a body meets what a map has and the one before had not.

    Its border counts, too, of maps of another size or place. Bodies are looked at in points half a
    cell apart.
    """
    same = (map.resolution, map.origin, map.size) == (before.resolution, before.origin, before.size)
    come = map.occupied & ~before.occupied if same else map.occupied
    if not len(poses) or (same and not come.any()):
        return None
    wider = 2.0 * _NEXT if same else 0.0
    spacing = 0.5 * map.resolution
    x, y = (
        np.linspace(-0.5, 0.5, math.ceil(side / spacing) + 1) * side
        for side in (model.length + wider, model.width + wider)
    )
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    if model.round:
        points = points[np.hypot(*points.T) <= 0.5 * (model.length + wider) + 1e-9]
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    at_x = poses[:, :1] + c * points[:, 0] - s * points[:, 1]
    at_y = poses[:, 1:2] + s * points[:, 0] + c * points[:, 1]
    local = map.to_local(np.stack([at_x, at_y], axis=-1).reshape(-1, 2))
    cells = np.floor(local / map.resolution).astype(int)
    inside = (cells >= 0).all(axis=1) & (cells < (map.cols, map.rows)).all(axis=1)
    hit = np.logical_and(~inside, not same)
    hit[inside] = come[cells[inside, 1], cells[inside, 0]]
    rows = np.flatnonzero(hit.reshape(len(poses), -1).any(axis=1))
    return int(rows[0]) if len(rows) else None


def _planned(team: Team, request: Request, goals: list[Pose | None], free: list[int]) -> TeamPlan:
    """The plan of robots that are no obstacles; by the plain method where the best finds none."""
    starts = [_pose(request.starts[k]) for k in free]
    ends = [goals[k] or start for k, start in zip(free, starts, strict=True)]
    models = [team.models[k] for k in free]
    near = [body_at(model, start) for model, start in zip(models, starts, strict=True)]
    bodies = [
        _inflated(body_at(team.models[k], _pose(request.starts[k])), near)
        for k in _others(free, len(goals))
    ]
    problem = TeamProblem.on_map(request.map, models, starts, ends, team.terrain, bodies)
    plan = plan_team(problem, "auto", team.settings, team.seed, request.cancelled)
    if plan.reason == "budget" and not plan.involved and not request.cancelled():
        other = plan_team(problem, "sequential", team.settings, team.seed, request.cancelled)
        plan = other if other.solved else plan
    return plan


def _followed(
    team: Team,
    request: Request,
    goals: list[Pose | None],
    fixed: set[int],
    refused: dict[int, str],
    free: list[int],
    plan: TeamPlan | None,
) -> Answer:
    starts = [_pose(pose) for pose in request.starts]
    paths = dict(zip(free, () if plan is None else plan.trajectories, strict=False))
    follower = PlanFollower(
        [paths.get(k) for k in range(len(goals))],
        team.models,
        starts,
        [goal or start for start, goal in zip(starts, goals, strict=True)],
        team.rate,
        settings=team.following,
        terrain=team.terrain,
    )
    for robot in fixed:
        follower.hold(robot)
    return Answer(tuple(goals), refused, frozenset(fixed), follower)


def _reason(
    plan: TeamPlan, robot: int, goals: list[Pose | None], free: list[int], fixed: set[int]
) -> str:
    """Why there is no plan, with the numbers that robots have in the team."""
    others = [free[k] for k in plan.involved if free[k] != robot]
    if len(plan.involved) == 2 and "goals" in plan.detail and goals[others[0]] is None:
        return f"robot {others[0]} is in its place and has no goal"
    bodies = _others(free, len(goals))

    def renamed(match: re.Match[str]) -> str:
        return match[1] + " and ".join(str(free[int(k)]) for k in match[2].split(" and "))

    text = re.sub(r"(\brobots? )(\d+(?: and \d+)?)", renamed, plan.detail)
    return re.sub(
        r"world\.obstacles\[(\d+)\]", lambda match: f"robot {bodies[int(match[1])]}", text
    )


def _others(free: list[int], count: int) -> list[int]:
    return [robot for robot in range(count) if robot not in free]


def _inflated(body: Body, near: list[Body]) -> Body:
    """A robot that is an obstacle, a little larger unless another stands beside it."""
    room = min((gap_between(body, other) for other in near), default=_ROOM)
    room = min(max(room - 0.01, 0.0), _ROOM)
    if isinstance(body, Circle):
        return Circle(body.center, body.radius + room)
    length, width = body.size
    return Box(body.center, (length + 2.0 * room, width + 2.0 * room), body.yaw)


def _pose(row: Array) -> Pose:
    x, y, yaw = row.tolist()
    return x, y, yaw
