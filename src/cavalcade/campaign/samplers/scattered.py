"""Robots set down at random, each with a goal of its own: among boxes, or on generated terrain."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, Strict

from cavalcade.campaign.samplers.individual_goals import ATTEMPTS, TeamSampler, discs_pass
from cavalcade.campaign.samplers.sampler import (
    Area,
    Count,
    DataFolder,
    Instance,
    Lengths,
    open_world,
    sample_length,
)
from cavalcade.errors import InputError
from cavalcade.scenario.fields import Length, Size
from cavalcade.world import Box

_BOXES_TAG, _TERRAIN_TAG = 23, 24
_VALUES = {"gap": "width", "step": "height", "slope": "angle", "rough": "height"}
"""The generator's option of terrain that `value` is, by kind."""

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
        rng = np.random.default_rng([seed, _BOXES_TAG])
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


class TerrainSampler(TeamSampler):
    """The robots start within `zone` m of the left edge at random, and end so at the right one.

    With `against`, every third robot goes the other way. `kind` with `value`: a `gap` of that
    width, a `step` of that height, `rough` ground with features of that height, m; a `slope` of
    that angle, rad; `flat` takes none. Every such ground can be crossed by its construction: the
    zones are level, and in between there is one thing to be crossed, across the whole width.
    """

    sampler: Literal["terrain"]
    kind: Literal["flat", "gap", "step", "slope", "rough"]
    value: Lengths | None = None
    size: Size = (9.0, 4.0)
    zone: Length = 2.5
    robots: Annotated[int, Strict(), Field(ge=1, le=16)] = 1
    against: Annotated[bool, Strict()] = True

    @property
    def level_name(self) -> str | None:
        """What the curve runs over, where it is sampled from a range."""
        if self.value is None or self.value[0] == self.value[1]:
            return None
        return "angle of the slope, rad" if self.kind == "slope" else f"{self.kind}, m"

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        rng = np.random.default_rng([seed, _TERRAIN_TAG])
        value = None if self.value is None else sample_length(rng, self.value)
        left: Area = (0.0, 0.0, self.zone, self.size[1])
        right: Area = (self.size[0] - self.zone, 0.0, *self.size)
        zones = [
            (right, left) if self.against and k % 3 == 2 else (left, right)
            for k in range(self.robots)
        ]
        for _ in range(ATTEMPTS):
            robots = self.sample_robots(rng, seed, zones)
            if robots is not None:
                world = self._world(value, seed)
                scenario = self.scenario_of(f"{self.kind}-{seed}", world, robots, seed)
                return Instance(scenario, True, None if self.level_name is None else value)
        raise InputError(f"no place for {self.robots} robots", key="zone")

    def _world(self, value: float | None, seed: int) -> dict[str, Any]:
        if self.kind == "flat":
            return open_world(self.size)
        source: dict[str, Any] = {"kind": self.kind, "size": list(self.size)}
        if self.kind == "rough":
            source |= {"seed": seed, "zone": self.zone}
        if value is not None:
            source[_VALUES[self.kind]] = value
        return {"generate": source}
