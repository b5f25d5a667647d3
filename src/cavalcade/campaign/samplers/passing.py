"""Two robots that exchange the ends of a corridor."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np

from cavalcade.campaign.samplers.data import DataFolder
from cavalcade.campaign.samplers.individual_goals import (
    Robot,
    TeamSampler,
    discs_pass,
    models_in_turn,
)
from cavalcade.campaign.samplers.sampler import (
    SOLVED,
    UNSOLVED,
    Instance,
    Lengths,
    open_world,
    sample_length,
)
from cavalcade.robots import MODELS
from cavalcade.world import Box, Shape

_TAG = 22


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
        rng = np.random.default_rng([seed, _TAG])
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
