"""Problems without a plan, by their construction."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from cavalcade.campaign.samplers.individual_goals import ATTEMPTS, Robot, TeamSampler
from cavalcade.campaign.samplers.sampler import (
    INFEASIBLE,
    REFUSED,
    DataFolder,
    Instance,
    Pose,
    open_world,
    rounded,
)
from cavalcade.errors import InputError
from cavalcade.robots import MODELS
from cavalcade.world import Box, Circle, Shape

_TAG = 25
_SIZE = (12.0, 8.0)

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
        """World number `seed`."""
        rng = np.random.default_rng([seed, _TAG])
        width, height = _SIZE
        left, right = (0.0, 0.0, 4.5, height), (width - 4.5, 0.0, width, height)
        for _ in range(ATTEMPTS):
            robots = self.sample_robots(rng, seed, [(left, right)] * 3, gap=0.3)
            world = None if robots is None else self._spoilt(rng, robots)
            if robots is not None and world is not None:
                scenario = self.scenario_of(f"{self.kind}-{seed}", world, robots, seed)
                expected = REFUSED if self.kind == "starts-overlap" else INFEASIBLE
                return Instance(scenario, False, expected=expected)
        raise InputError("there is no place", key="kind")

    def _spoilt(self, rng: np.random.Generator, robots: list[Robot]) -> dict[str, Any] | None:
        """The world, after a robot or two have been changed in place; None if it would not do."""
        first, second = (int(k) for k in rng.permutation(3)[:2])
        one, other = robots[first], robots[second]
        x, y, yaw = one.goal
        solids: list[Shape] = []
        if self.kind == "goals-overlap":
            robots[second] = replace(other, goal=_overlapping(rng, one.goal))
        elif self.kind == "starts-overlap":
            robots[second] = replace(other, start=_overlapping(rng, one.start))
        elif self.kind == "goals-equal":
            robots[second] = replace(other, goal=one.goal)
        elif self.kind == "goal-off-the-map":
            robots[first] = replace(one, goal=rounded((_SIZE[0] + rng.uniform(0.0, 2.0), y, yaw)))
        elif self.kind == "goal-in-a-hole":
            hole = _SIZE[0] / 2.0 + rng.uniform(-0.1, 0.1)
            robots[first] = replace(one, goal=rounded((hole, y, yaw)))
            return {"generate": {"kind": "gap", "size": list(_SIZE), "width": 0.4}}
        elif self.kind == "goal-in-an-obstacle":
            radius = round(float(rng.uniform(0.3, 0.6)), 3)
            solids = [Circle((x, y), radius)]
        else:
            side, thick = round(float(rng.uniform(1.2, 1.6)), 3), 0.2
            solids = [
                Box(_ahead((x, y, yaw), side / 2.0, k * math.pi / 2.0), (thick, side + thick),
                    round(math.remainder(yaw + k * math.pi / 2.0, 2.0 * math.pi), 6))
                for k in range(4)
            ]  # fmt: skip
        free = [robot.start for robot in robots] + [r.goal for r in robots if r is not one]
        return None if any(_near(solids, pose) for pose in free) else open_world(_SIZE, solids)


def _overlapping(rng: np.random.Generator, pose: Pose) -> Pose:
    """A pose nearer than a width, so that the discs inside of both bodies overlap."""
    reach, angle = rng.uniform(0.02, 0.9 * MODELS["go1"].width), rng.uniform(0.0, math.tau)
    turned = rng.uniform(-math.pi, math.pi)
    return rounded((pose[0] + reach * math.cos(angle), pose[1] + reach * math.sin(angle), turned))


def _ahead(pose: Pose, distance: float, turned: float) -> tuple[float, float]:
    """The place `distance` m from a pose, in that direction from where it looks."""
    x, y, yaw = pose
    angle = yaw + turned
    return round(x + distance * math.cos(angle), 4), round(y + distance * math.sin(angle), 4)


def _near(solids: list[Shape], pose: Pose) -> bool:
    place = np.array([pose[:2]])
    return any(float(shape.distance(place)[0]) < 0.5 for shape in solids)
