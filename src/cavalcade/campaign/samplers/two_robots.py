"""Two robots: the paper's problem on even ground without obstacles, and exchanges in a corridor."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np

from cavalcade.campaign.samplers.individual_goals import (
    ATTEMPTS,
    Robot,
    TeamSampler,
    bodies_meet,
    discs_pass,
    models_in_turn,
)
from cavalcade.campaign.samplers.sampler import (
    SOLVED,
    UNSOLVED,
    DataFolder,
    Instance,
    Lengths,
    open_world,
    sample_length,
)
from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.robots import MODELS
from cavalcade.scenario.fields import Length, Size
from cavalcade.world import Box, Shape

_PAIRS_TAG, _PASSING_TAG = 21, 22
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
        rng = np.random.default_rng([seed, _PAIRS_TAG])
        area = (0.0, 0.0, *self.size)
        x, y = self.size[0] / 2.0, self.size[1] / 2.0
        beside = [(x, y - self.apart / 2.0, 0.0), (x, y + self.apart / 2.0, 0.0)]
        starts = None if self.starts == "random" else beside
        crowded = 0
        for _ in range(_MOST_DRAWS):
            robots = self.sample_robots(rng, seed, [(area, area)] * 2, starts=starts)
            if robots is None:
                crowded += 1
                if crowded == ATTEMPTS:
                    break
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


class PassingSampler(TeamSampler):
    """A straight corridor with a robot at each end.

    `kind`: with an `alcove`, the corridor being too narrow for two bodies beside each other, so
    that one has to wait in it; `wide` enough for two; or `narrow` without an alcove, where there
    is no plan, though that is hard to prove. `room` is what the corridor is wider than the wider
    body (`alcove`, `narrow`) or than both (`wide`), m; an alcove or narrow corridor stays
    narrower than both.
    """

    LEVEL_NAME: ClassVar = "width of the corridor, m"

    sampler: Literal["passing"]
    kind: Literal["alcove", "wide", "narrow"]
    length: Lengths = (6.0, 12.0)
    room: Lengths = (0.22, 0.3)
    alcove: Lengths = (1.4, 2.0)
    depth: Lengths = (0.8, 1.2)

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        rng = np.random.default_rng([seed, _PASSING_TAG])
        models = models_in_turn(self.models, seed, 2)
        widths = [MODELS[name].width for name in models]
        length, room = sample_length(rng, self.length), sample_length(rng, self.room)
        wide = sample_length(rng, self.alcove)
        depth = sample_length(rng, self.depth) if self.kind == "alcove" else 0.0
        place = float(rng.uniform(0.3, 0.7))
        if self.kind == "wide":
            width = round(sum(widths) + room, 3)
        else:
            width = round(min(max(widths) + room, sum(widths) - 0.01), 3)
        size = (length, round(width + depth, 3))
        solids: list[Shape] = []
        if self.kind == "alcove":
            left = round(place * (length - wide), 3)
            right = round(left + wide, 3)
            middle = width + depth / 2.0
            solids = [
                Box((left / 2.0, middle), (left, depth), 0.0),
                Box(((right + length) / 2.0, middle), (length - right, depth), 0.0),
            ]
        x, y = 0.6, round(width / 2.0, 4)
        if self.kind == "wide":
            y = round(width / 2.0 - float(rng.uniform(-0.2, 0.2)) * room, 4)
        first, last = (x, y), (round(length - x, 4), y)
        turned = round(math.pi, 6)
        robots = [
            Robot(models[0], (*first, 0.0), (*last, 0.0)),
            Robot(models[1], (*last, turned), (*first, turned)),
        ]
        passable = self.kind != "narrow"
        return Instance(
            self.scenario_of(f"{self.kind}-{seed}", open_world(size, solids), robots, seed),
            passable and discs_pass(size, solids, robots),
            width,
            SOLVED if passable else UNSOLVED,
        )
