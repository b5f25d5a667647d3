"""Problems without a plan, by their construction."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from cavalcade.campaign.samplers.data import DataFolder
from cavalcade.campaign.samplers.individual_goals import (
    Robot,
    TeamSampler,
    rounded,
    sample_team,
)
from cavalcade.campaign.samplers.sampler import INFEASIBLE, REFUSED, Instance, Pose
from cavalcade.errors import InputError
from cavalcade.robots import MODELS
from cavalcade.world import Box, Circle, Shape, shape_to_mapping

_TAG = 25
_SIZE = (12.0, 8.0)
_ATTEMPTS = 50

Kind = Literal[
    "goals-overlap",
    "goals-equal",
    "goal-off-the-map",
    "goal-in-an-obstacle",
    "goal-in-a-hole",
    "goal-walled-in",
    "starts-overlap",
]


class InfeasibleSampler(TeamSampler):
    """Three robots, of which one or two ask for what cannot be.

    They cross 12 x 8 m, with a gap of 0.4 m where the goal is in a hole. Overlapping starts are
    bad input; all else is infeasible, and can be proven to be.
    """

    sampler: Literal["infeasible"]
    kind: Kind

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`.

        Raises:
            InputError: There is no place, which does not happen.
        """
        rng = np.random.default_rng([seed, _TAG])
        models = self.models_of(seed, 3)
        width, height = _SIZE
        left, right = (0.0, 0.0, 4.5, height), (width - 4.5, 0.0, width, height)
        for _ in range(_ATTEMPTS):
            starts = sample_team(rng, models, [left] * 3, 0.3, border=self.border)
            goals = sample_team(rng, models, [right] * 3, 0.3, border=self.border)
            if starts is None or goals is None:
                continue
            first, second = (int(k) for k in rng.permutation(3)[:2])
            made = self._spoilt(rng, models, starts, goals, first, second)
            if made is None:
                continue
            robots = [Robot(*row) for row in zip(models, starts, goals, strict=True)]
            scenario = self.scenario_of(f"{self.kind}-{seed}", made, robots, seed)
            expected = REFUSED if self.kind == "starts-overlap" else INFEASIBLE
            return Instance(scenario, False, expected=expected)
        raise InputError("there is no place", key="kind")

    def _spoilt(
        self,
        rng: np.random.Generator,
        models: list[str],
        starts: list[Pose],
        goals: list[Pose],
        first: int,
        second: int,
    ) -> dict[str, Any] | None:
        """The world, after starts or goals have been changed in place; None where it would not do.

        Args:
            rng: Source of all randomness.
            models: Of the robots.
            starts, goals: Of the robots.
            first, second: Robots that are made to ask for what cannot be.
        """
        free = {"empty": {"size": list(_SIZE)}}
        x, y, yaw = goals[first]
        if self.kind in ("goals-overlap", "starts-overlap"):
            poses = goals if self.kind == "goals-overlap" else starts
            x, y, yaw = poses[first]
            reach, angle = rng.uniform(0.02, 0.9 * MODELS["go1"].width), rng.uniform(0.0, math.tau)
            turned = rng.uniform(-math.pi, math.pi)
            # Nearer than a width, the discs inside of both bodies overlap.
            x, y = x + reach * math.cos(angle), y + reach * math.sin(angle)
            poses[second] = rounded((x, y, turned))
            return free
        if self.kind == "goals-equal":
            goals[second] = goals[first]
            return free
        if self.kind == "goal-off-the-map":
            goals[first] = rounded((_SIZE[0] + rng.uniform(0.0, 2.0), y, yaw))
            return free
        if self.kind == "goal-in-a-hole":
            hole = _SIZE[0] / 2.0
            goals[first] = rounded((hole + rng.uniform(-0.1, 0.1), y, yaw))
            return {"generate": {"kind": "gap", "size": list(_SIZE), "width": 0.4}}
        solids: list[Shape]
        if self.kind == "goal-in-an-obstacle":
            radius = round(float(rng.uniform(0.3, 0.6)), 3)
            solids = [Circle((x, y), radius)]
        else:
            side, thick = round(float(rng.uniform(1.2, 1.6)), 3), 0.2
            solids = [
                Box(_ahead((x, y, yaw), side / 2.0, k * math.pi / 2.0), (thick, side + thick),
                    round(yaw + k * math.pi / 2.0, 6))
                for k in range(4)
            ]  # fmt: skip
        for k, pose in enumerate([*starts, *goals]):
            if k != 3 + first and _near(solids, pose):
                return None
        return free | {"obstacles": [shape_to_mapping(shape) for shape in solids]}


def _ahead(pose: Pose, distance: float, turned: float) -> tuple[float, float]:
    """The place `distance` m from a pose, in that direction from where it looks."""
    x, y, yaw = pose
    angle = yaw + turned
    return round(x + distance * math.cos(angle), 4), round(y + distance * math.sin(angle), 4)


def _near(solids: list[Shape], pose: Pose) -> bool:
    place = np.array([pose[:2]])
    return any(float(shape.distance(place)[0]) < 0.5 for shape in solids)
