"""Two robots on even ground without obstacles, the paper's problem."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from cavalcade.campaign.samplers.data import DataFolder
from cavalcade.campaign.samplers.individual_goals import Robot, TeamSampler, bodies_meet
from cavalcade.campaign.samplers.sampler import Instance, open_world
from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.robots import MODELS
from cavalcade.scenario.fields import Length, Size

_TAG = 21
_MOST_DRAWS = 2000
_CLOCK = 0.02
"""Between two looks at whether bodies meet, s."""


class PairsSampler(TeamSampler):
    """Starts and goals of two robots.

    `starts`: `random`, or `side-by-side` in the middle of the ground, `apart` m from centre to
    centre and looking along x. `keep`: only pairs whose straight plans, each robot planned as if
    it were alone by the default planner, are `colliding` or `free` of collisions, or `any`.
    """

    sampler: Literal["pairs"]
    size: Size = (10.0, 10.0)
    starts: Literal["random", "side-by-side"] = "random"
    apart: Length = 1.0
    keep: Literal["any", "colliding", "free"] = "any"

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        rng = np.random.default_rng([seed, _TAG])
        area = (0.0, 0.0, *self.size)
        x, y = self.size[0] / 2.0, self.size[1] / 2.0
        beside = [(x, y - self.apart / 2.0, 0.0), (x, y + self.apart / 2.0, 0.0)]
        starts = None if self.starts == "random" else beside
        for _ in range(_MOST_DRAWS):
            robots = self.sample_robots(rng, seed, [(area, area)] * 2, starts=starts)
            if robots is None:
                continue
            if self.keep == "any" or self._collide(robots) == (self.keep == "colliding"):
                name, world = f"pair-{self.keep}-{seed}", open_world(self.size)
                return Instance(self.scenario_of(name, world, robots, seed), True)
        raise InputError("no such pair is found on that ground", key="size")

    def _collide(self, robots: list[Robot]) -> bool:
        """Whether the robots meet if each goes its own way."""
        one, other = (MODELS[robot.model] for robot in robots)
        paths = [_alone(robot, self.size) for robot in robots]
        count = max(len(path) for path in paths)
        at, there = (path[np.minimum(np.arange(count), len(path) - 1)] for path in paths)
        return bool(bodies_meet(one, at, other, there).any())


def _alone(robot: Robot, size: tuple[float, float]) -> Array:
    """Poses `(K, 3)` of a robot that is alone, every `_CLOCK` s."""
    from cavalcade.coordination import TeamProblem, plan_team
    from cavalcade.lattice.ground import make_ground
    from cavalcade.world import OccupancyMap

    ground = make_ground(OccupancyMap.empty(size), None)
    problem = TeamProblem(ground, (MODELS[robot.model],), (robot.start,), (robot.goal,))
    path = plan_team(problem).trajectories[0]
    if path is None:
        raise InputError(f"a {robot.model} alone finds no way on that ground", key="size")
    last = math.ceil(path.duration / _CLOCK)
    times = np.linspace(0.0, last * _CLOCK, last + 1)
    return path.poses_at(times)
