"""One to three robots across generated terrain."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Strict

from cavalcade.campaign.samplers.data import DataFolder
from cavalcade.campaign.samplers.individual_goals import ATTEMPTS, TeamSampler
from cavalcade.campaign.samplers.sampler import Area, Instance, Lengths, open_world, sample_length
from cavalcade.errors import InputError
from cavalcade.scenario.fields import Length, Size

_TAG = 24
_VALUES = {"gap": "width", "step": "height", "slope": "angle", "rough": "height"}
"""The generator's option that `value` is, by kind."""


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
        rng = np.random.default_rng([seed, _TAG])
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
