"""What the samplers of robots with individual goals have in common."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.sampler import Area, Pose, Sampler, rounded
from cavalcade.geometry import Array
from cavalcade.robots import MODELS, RobotModel
from cavalcade.scenario.fields import NotNegative
from cavalcade.scenario.settings import Budget
from cavalcade.world import OccupancyMap, Shape

Legged = Literal["spirit", "go1", "go2"]
Models = Annotated[tuple[Legged, ...], Field(min_length=1, max_length=64)]

_GRAIN = 0.05
"""Distance of the nodes of the test for feasibility, m; the gaps here are much wider."""

_TRIES = 300
"""Poses that are tried for each robot."""

ATTEMPTS = 50
"""Worlds that are sampled until one has room for all robots."""


class TeamSampler(Sampler):
    """Sets robots down at random, each with a goal of its own; `budget` is the planner's.

    Footprints keep `gap` m from each other, and `border` m from the border, however they are
    turned.
    """

    budget: Budget = Budget()
    models: Models = ("spirit",)
    gap: NotNegative = 0.05
    border: NotNegative = 0.01

    @property
    def individual_goals(self) -> bool:
        """Each robot has a goal of its own."""
        return True

    def scenario_of(
        self, name: str, world: Mapping[str, Any], robots: Sequence[Robot], seed: int
    ) -> dict[str, Any]:
        """A scenario as its file says it."""
        scenario: dict[str, Any] = {
            "version": 1,
            "name": name,
            "world": dict(world),
            "robots": [
                {"model": robot.model, "start": list(robot.start), "goal": list(robot.goal)}
                for robot in robots
            ],
            "task": {"goals": "individual"},
            "execution": {"seed": seed},
        }
        budget = self.budget.model_dump(mode="json", exclude_none=True)
        return scenario | {"planner": {"budget": budget}} if budget else scenario

    def sample_robots(
        self,
        rng: np.random.Generator,
        seed: int,
        zones: Sequence[tuple[Area, Area]],
        solids: Sequence[Shape] = (),
        *,
        starts: list[Pose] | None = None,
        gap: float | None = None,
    ) -> list[Robot] | None:
        """A robot for each pair of areas, to start in the first and end in the second one.

        Their models come in turn by `seed`, their poses from `rng` unless `starts` are given.
        `gap` stands in for the sampler's own. None where no place is found.
        """
        models = models_in_turn(self.models, seed, len(zones))
        gap = self.gap if gap is None else gap
        here, there = zip(*zones, strict=True)
        if starts is None:
            starts = self._sample_poses(rng, models, here, solids, gap)
        goals = self._sample_poses(rng, models, there, solids, gap)
        if starts is None or goals is None:
            return None
        return [Robot(*row) for row in zip(models, starts, goals, strict=True)]

    def _sample_poses(
        self,
        rng: np.random.Generator,
        models: Sequence[str],
        areas: Sequence[Area],
        solids: Sequence[Shape],
        gap: float,
    ) -> list[Pose] | None:
        """A pose for each robot in its area; None where none is found."""
        found: list[tuple[str, Pose]] = []
        for name, area in zip(models, areas, strict=True):
            # Solids and the border of the area are kept off at any yaw.
            reach = math.hypot(MODELS[name].length, MODELS[name].width) / 2.0 + self.border
            for _ in range(_TRIES):
                x = rng.uniform(area[0] + reach, max(area[2] - reach, area[0] + reach))
                y = rng.uniform(area[1] + reach, max(area[3] - reach, area[1] + reach))
                pose = rounded((x, y, rng.uniform(-math.pi, math.pi)))
                free = all(
                    float(shape.distance(np.array([pose[:2]]))[0]) >= reach + gap
                    for shape in solids
                )
                if free and keeps_apart(name, pose, found, gap):
                    found.append((name, pose))
                    break
            else:
                return None
        return [pose for _, pose in found]


@dataclass(frozen=True)
class Robot:
    """A robot's model, start and goal; poses x, y, yaw in m and rad, map frame."""

    model: str
    start: Pose
    goal: Pose


def models_in_turn(models: Sequence[str], seed: int, robots: int) -> list[str]:
    """A model for each robot, in turn by the seed and by the robot."""
    return [models[(seed + k) % len(models)] for k in range(robots)]


def bodies_meet(one: RobotModel, at: Array, other: RobotModel, there: Array) -> NDArray[np.bool_]:
    """Whether the footprints of two robots overlap at poses `(K, 3)`: `(K,)`.

    Rectangles are apart if and only if they are along a side of one of them.
    """
    return _separation(one, at, other, there) < 0.0


def _separation(one: RobotModel, at: Array, other: RobotModel, there: Array) -> Array:
    """The widest gap along the sides `(K,)`, negative where bodies overlap, m."""
    off = there[:, :2] - at[:, :2]
    turn = there[:, 2] - at[:, 2]
    c, s = np.abs(np.cos(turn)), np.abs(np.sin(turn))
    found = np.full(len(at), -np.inf)
    for mine, his, yaw in ((one, other, at[:, 2]), (other, one, there[:, 2])):
        along = np.abs(np.cos(yaw) * off[:, 0] + np.sin(yaw) * off[:, 1])
        across = np.abs(np.cos(yaw) * off[:, 1] - np.sin(yaw) * off[:, 0])
        along -= (mine.length + c * his.length + s * his.width) / 2.0
        across -= (mine.width + s * his.length + c * his.width) / 2.0
        found = np.maximum(found, np.maximum(along, across))
    return found


def keeps_apart(model: str, pose: Pose, others: Sequence[tuple[str, Pose]], gap: float) -> bool:
    """Whether a footprint keeps at least `gap` m from all others, for certain."""
    one, here = MODELS[model], np.array([pose])
    # Most that do not are found out at once: the discs inside of both bodies are too near.
    for name, there in others:
        inside = _inner_radius(one) + _inner_radius(MODELS[name])
        if math.hypot(there[0] - pose[0], there[1] - pose[1]) < inside + gap:
            return False
    return all(
        _separation(one, here, MODELS[name], np.array([there]))[0] >= gap for name, there in others
    )


def _inner_radius(model: RobotModel) -> float:
    """Of the disc in the middle of a footprint, m."""
    return min(model.length, model.width) / 2.0


def discs_pass(size: tuple[float, float], solids: Sequence[Shape], robots: Sequence[Robot]) -> bool:
    """Whether a disc of half its body's width gets each robot from its start to its goal."""
    regions: dict[float, DiscRegions] = {}
    for robot in robots:
        radius = MODELS[robot.model].width / 2.0
        if radius not in regions:
            base = OccupancyMap.empty(size)
            regions[radius] = DiscRegions(base, solids, radius=radius, step=_GRAIN)
        if not regions[radius].connect([robot.start[:2]], [robot.goal[:2]]):
            return False
    return True
