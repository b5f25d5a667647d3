"""The problem that all coordinators share: a ground, robots, and a start and a goal for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array, inverse_transform_points, rotation, transform_points
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.lattice.ground import Ground, check_ground, make_ground
from cavalcade.robots import RobotModel, robot_model
from cavalcade.values import (
    described,
    instance_of,
    instances_of,
    number_array,
    number_in,
    plain_number,
    pose_of,
    whole_number,
)
from cavalcade.world import Box, Circle, OccupancyMap, Polygon, Shape, Terrain

if TYPE_CHECKING:
    from cavalcade.scenario import Scenario, World

Pose = tuple[float, float, float]


_CHOICES = {
    "variant": ("cavalcade", "published"),
    "constraints": ("timed", "static"),
    "conflict": ("costly", "earliest", "first"),
}


def _poses(poses: object, key: str) -> Array:
    """Poses `(N, 3)`, of which there may be none."""
    if isinstance(poses, (list, tuple)) and len(poses) == 0:
        return np.empty((0, 3))
    return number_array(poses, key, (None, 3), "poses (x, y, yaw)")


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
            value = getattr(self, name)
            if not isinstance(value, str) or value not in choices:
                raise InputError(
                    f"unknown value {described(value)}", key=f"planner.{name}", choices=choices
                )
        whole_number(self.improve, "planner.improve", 0)
        whole_number(self.iterations, "planner.budget.iterations")
        if not 0.0 <= plain_number(self.margin, "planner.margin") <= 1.0:
            raise InputError("expected 0 to 1 m", key="planner.margin")
        instance_of(self.leaps, bool, "planner.leaps", "True or False")
        if self.seconds is not None:
            plain_number(self.seconds, "planner.budget.seconds")  # its bounds: in `plan_team`
        if self.distance is not None:
            number_in(self.distance, "distance", 0.0, unit="m")
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
        check_ground(self.ground)
        object.__setattr__(self, "models", instances_of(self.models, RobotModel, "models"))
        object.__setattr__(self, "origin", pose_of(self.origin, "origin"))
        for name in ("starts", "goals"):
            poses = _poses(getattr(self, name), name)
            if len(poses) != len(self.models):
                raise InputError(f"expected {len(self.models)} poses, not {len(poses)}", key=name)
            object.__setattr__(self, name, tuple((x, y, yaw) for x, y, yaw in poses.tolist()))

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
        solids = instances_of(shapes, Box | Circle | Polygon, "shapes", "a list of shapes")
        ground = make_ground(map, terrain, solids)
        what = "a list of RobotModel or their names"
        team = tuple(
            robot_model(one) for one in instances_of(models, str | RobotModel, "models", what)
        )

        def local(poses: Sequence[Pose], key: str) -> tuple[Pose, ...]:
            table = _poses(poses, key)
            table[:, :2] = inverse_transform_points(map.origin, table[:, :2])
            table[:, 2] -= map.origin[2]
            return tuple((x, y, yaw) for x, y, yaw in table.tolist())

        return cls(ground, team, local(starts, "starts"), local(goals, "goals"), map.origin, solids)

    def part(self, robots: Sequence[int]) -> TeamProblem:
        """The problem of these robots alone."""
        chosen = instances_of(robots, int | np.integer, "robots", "a list of robots' numbers")
        robots = [whole_number(k, "robots", 0, len(self.models) - 1) for k in chosen]
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


def problem_of(scenario: Scenario, world: World) -> TeamProblem:
    """The problem that a scenario with a goal for each robot poses in its world."""
    seen, shapes = world.map_with(()), world.shapes
    return TeamProblem.on_map(
        seen, scenario.models, scenario.starts, scenario.goals, world.terrain, shapes
    )
