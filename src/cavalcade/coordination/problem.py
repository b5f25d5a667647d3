"""The problem that all coordinators share: a ground, robots, and a start and a goal for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import (
    Array,
    as_floats,
    inverse_transform_points,
    rotation,
    transform_points,
)
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.robots import RobotModel, robot_model
from cavalcade.world import OccupancyMap, Shape, Terrain

if TYPE_CHECKING:
    from cavalcade.scenario import Scenario, World

Pose = tuple[float, float, float]


_CHOICES = {
    "variant": ("cavalcade", "published"),
    "constraints": ("timed", "static"),
    "conflict": ("costly", "earliest", "first"),
}


@dataclass(frozen=True)
class PlanSettings:
    """How a coordinator plans.

    Attributes:
        variant: `published`: robots are planned by the tree search of the paper, kept apart by
            the distance of their centres.
        constraints: `timed`: bodies of others count while they are there; `static`: they are
            obstacles for all time, as in the paper.
        conflict: Which conflict of a node is resolved: the `costly` one, the `earliest`, or the
            `first` in the order of the robots, as in the paper.
        leaps: Whether legged robots may leap.
        improve: Iterations spent on a better plan once there is one.
        margin: By which bodies are inflated, m; by less, or not at all, where that leaves no plan.
        distance: Between centres, m: what counts as a conflict instead of the bodies; of
            `published`.
        iterations: The budget: expansions of searches and trees.
        seconds: Limit of wall time, s; None for none. It ends a search that would have gone on; a
            plan never depends on it otherwise.

    Raises:
        InputError: A value out of range.
    """

    variant: Literal["cavalcade", "published"] = "cavalcade"
    constraints: Literal["timed", "static"] = "timed"
    conflict: Literal["costly", "earliest", "first"] = "costly"
    leaps: bool = True
    improve: int = 0
    margin: float = 0.0
    distance: float | None = None
    iterations: int = 2_000_000
    seconds: float | None = None

    def __post_init__(self) -> None:
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                value = getattr(self, name)
                raise InputError(f"unknown value {value!r}", key=f"planner.{name}", choices=choices)
        if self.improve < 0:
            raise InputError("expected 0 or more", key="planner.improve")
        if not 0.0 <= self.margin <= 1.0:
            raise InputError("expected 0 to 1 m", key="planner.margin")
        if self.distance is not None and self.variant != "published":
            raise InputError(
                "centres are kept apart by the published variant alone", key="distance"
            )


@dataclass(frozen=True)
class TeamProblem:
    """Robots on a ground, each with a start and a goal.

    Attributes:
        ground: What is in the way.
        models: Of each robot.
        starts, goals: Poses (x m, y m, yaw rad) in the ground's own frame.
        origin: Pose of the ground's frame in the map.
        shapes: Obstacles of the ground that are known as what they are, in the map frame.

    Raises:
        InputError: Not a start and a goal for each robot.
    """

    ground: Ground
    models: tuple[RobotModel, ...]
    starts: tuple[Pose, ...]
    goals: tuple[Pose, ...]
    origin: Pose = (0.0, 0.0, 0.0)
    shapes: tuple[Shape, ...] = ()

    def __post_init__(self) -> None:
        for name in ("starts", "goals"):
            poses = _poses(getattr(self, name), name).tolist()
            if len(poses) != len(self.models):
                raise InputError(f"expected {len(self.models)} poses, not {len(poses)}", key=name)
            object.__setattr__(self, name, tuple((x, y, yaw) for x, y, yaw in poses))

    @classmethod
    def on_map(
        cls,
        map: OccupancyMap,
        models: Sequence[RobotModel | str],
        starts: Sequence[Pose],
        goals: Sequence[Pose],
        terrain: Terrain | None = None,
        shapes: Sequence[Shape] = (),
    ) -> TeamProblem:
        """The problem of a team on a map, all in the map's frame.

        Args:
            map: What is in the way.
            models: Of each robot, or their names.
            starts, goals: Poses (x m, y m, yaw rad) of each robot.
            terrain: Heights on the map's grid; None for flat ground.
            shapes: Obstacles besides, which are tested as what they are, not as cells.

        Raises:
            InputError: An unknown model, or not a start and a goal for each robot.
        """
        team = tuple(robot_model(one) if isinstance(one, str) else one for one in models)

        def local(poses: Sequence[Pose], key: str) -> tuple[Pose, ...]:
            table = _poses(poses, key)
            table[:, :2] = inverse_transform_points(map.origin, table[:, :2])
            table[:, 2] -= map.origin[2]
            return tuple((x, y, yaw) for x, y, yaw in table.tolist())

        ground = make_ground(map, terrain, shapes)
        begin, end = local(starts, "starts"), local(goals, "goals")
        return cls(ground, team, begin, end, map.origin, tuple(shapes))

    def part(self, robots: Sequence[int]) -> TeamProblem:
        """The problem of these robots alone."""
        return replace(
            self,
            models=tuple(self.models[k] for k in robots),
            starts=tuple(self.starts[k] for k in robots),
            goals=tuple(self.goals[k] for k in robots),
        )

    def in_map(self, trajectory: Trajectory) -> Trajectory:
        """A trajectory of the ground's frame, seen in the map's."""
        if self.origin == (0.0, 0.0, 0.0):
            return trajectory
        position, velocity = trajectory.position.copy(), trajectory.velocity.copy()
        position[:, :2] = transform_points(self.origin, position[:, :2])
        velocity[:, :2] = velocity[:, :2] @ rotation(self.origin[2]).T
        yaw = trajectory.yaw + self.origin[2]
        return replace(trajectory, position=position, velocity=velocity, yaw=yaw)


def _poses(values: object, key: str) -> Array:
    """Finite poses `(N, 3)`."""
    table = as_floats(values, key)
    if not table.size:
        return np.empty((0, 3))
    if table.ndim != 2 or table.shape[1] != 3 or not np.isfinite(table).all():
        raise InputError("expected finite poses (x, y, yaw)", key=key)
    return table


def problem_of(scenario: Scenario, world: World) -> TeamProblem:
    """The problem that a scenario with a goal for each robot poses in its world."""
    seen, shapes = world.map_with(()), world.shapes
    return TeamProblem.on_map(
        seen, scenario.models, scenario.starts, scenario.goals, world.terrain, shapes
    )
