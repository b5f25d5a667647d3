"""Many robots at random among boxes, each with a goal of its own."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Strict

from cavalcade.campaign.samplers.data import DataFolder
from cavalcade.campaign.samplers.individual_goals import Robot, TeamSampler, discs_pass, sample_team
from cavalcade.campaign.samplers.sampler import Count, Instance, Lengths, sample_length
from cavalcade.errors import InputError
from cavalcade.scenario.fields import Size
from cavalcade.world import Box, shape_to_mapping

_TAG = 23
_ATTEMPTS = 50

TeamSize = Annotated[int, Strict(), Field(ge=1, le=64)]


class BoxesSampler(TeamSampler):
    """As many `robots` as the list says, in turn by the seed, among `boxes` with sides of `side` m.

    Starts and goals are clear of the boxes at any yaw, and discs of half the bodies' width get
    from each start to its goal: worlds without that are sampled again.
    """

    sampler: Literal["boxes"]
    robots: Annotated[tuple[TeamSize, ...], Field(min_length=1)] = (2, 5, 10, 15, 20)
    size: Size = (20.0, 20.0)
    boxes: Count = 10
    side: Lengths = (0.5, 2.0)

    @property
    def level_name(self) -> str | None:
        """What the curve runs over."""
        return "robots"

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`.

        Raises:
            InputError: The boxes leave no place.
        """
        rng = np.random.default_rng([seed, _TAG])
        count = self.robots[seed % len(self.robots)]
        models = self.models_of(seed, count)
        areas = [(0.0, 0.0, *self.size)] * count
        for _ in range(_ATTEMPTS):
            boxes = [self._box(rng) for _ in range(self.boxes)]
            starts = sample_team(rng, models, areas, self.gap, boxes, border=self.border)
            goals = sample_team(rng, models, areas, self.gap, boxes, border=self.border)
            if starts is None or goals is None:
                continue
            robots = [Robot(*row) for row in zip(models, starts, goals, strict=True)]
            if not discs_pass(self.size, boxes, robots):
                continue
            world: dict[str, Any] = {"empty": {"size": list(self.size)}}
            if boxes:
                world["obstacles"] = [shape_to_mapping(box) for box in boxes]
            scenario = self.scenario_of(f"crowd-{count}-{seed}", world, robots, seed)
            return Instance(scenario, True, float(count))
        raise InputError(f"the boxes leave no place for {count} robots", key="boxes")

    def _box(self, rng: np.random.Generator) -> Box:
        x, y = (round(float(rng.uniform(0.0, side)), 3) for side in self.size)
        sides = (sample_length(rng, self.side), sample_length(rng, self.side))
        return Box((x, y), sides, round(float(rng.uniform(0.0, math.pi)), 4))
