"""Many robots at random among boxes, each with a goal of its own."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, Strict

from cavalcade.campaign.samplers.data import DataFolder
from cavalcade.campaign.samplers.individual_goals import ATTEMPTS, TeamSampler, discs_pass
from cavalcade.campaign.samplers.sampler import Count, Instance, Lengths, open_world, sample_length
from cavalcade.errors import InputError
from cavalcade.scenario.fields import Size
from cavalcade.world import Box

_TAG = 23

TeamSize = Annotated[int, Strict(), Field(ge=1, le=64)]


class BoxesSampler(TeamSampler):
    """As many `robots` as the list says, in turn by the seed, among `boxes` with sides of `side` m.

    Starts and goals are clear of the boxes at any yaw, and discs of half the bodies' width get
    from each start to its goal: worlds without that are sampled again.
    """

    LEVEL_NAME: ClassVar = "robots"

    sampler: Literal["boxes"]
    robots: Annotated[tuple[TeamSize, ...], Field(min_length=1)] = (2, 5, 10, 15, 20)
    size: Size = (20.0, 20.0)
    boxes: Count = 10
    side: Lengths = (0.5, 2.0)

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        rng = np.random.default_rng([seed, _TAG])
        count = self.robots[seed % len(self.robots)]
        area = (0.0, 0.0, *self.size)
        for _ in range(ATTEMPTS):
            boxes = [self._box(rng) for _ in range(self.boxes)]
            robots = self.sample_robots(rng, seed, [(area, area)] * count, boxes)
            if robots is not None and discs_pass(self.size, boxes, robots):
                world = open_world(self.size, boxes)
                scenario = self.scenario_of(f"crowd-{count}-{seed}", world, robots, seed)
                return Instance(scenario, True, float(count))
        raise InputError(f"the boxes leave no place for {count} robots", key="boxes")

    def _box(self, rng: np.random.Generator) -> Box:
        x, y = (round(float(rng.uniform(0.0, side)), 3) for side in self.size)
        sides = (sample_length(rng, self.side), sample_length(rng, self.side))
        return Box((x, y), sides, round(float(rng.uniform(0.0, math.pi)), 4))
