"""Teams of many sizes and shapes in clutter that grows with them."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.sampler import (
    Counts,
    DataFolder,
    Instance,
    Lengths,
    Sampler,
    generated_world,
    sample_length,
)
from cavalcade.campaign.samplers.teams import OWN_COUNT, Slots, TeamSection, sample_pose
from cavalcade.errors import InputError
from cavalcade.scenario.fields import Length, NotNegative, Positive, expected
from cavalcade.world import OccupancyMap, generate

Shape = Literal["square", "triangle", "line", "column", "wedge", "circle", "custom"]

_TAG = 4
_ATTEMPTS = 50
_AROUND = 1.0
"""Ground around the team in its zones, m."""


class CrowdSampler(Sampler):
    """Every shape with every number of robots that it takes, in turn by the seed.

    The team crosses a band of `band` m with `density` obstacles per square metre, as high as it
    takes to turn the shape in it. `spacing` is the least distance between two slots; those of the
    custom shape, `slots`, are scaled to it.
    """

    LEVEL_NAME: ClassVar = "robots"

    sampler: Literal["crowd"]
    robots: Counts = (2, 16)
    shapes: Annotated[tuple[Shape, ...], Field(min_length=1)] = (
        "square",
        "triangle",
        "line",
        "column",
        "wedge",
        "circle",
    )
    slots: Slots | None = None
    spacing: Lengths = (0.9, 1.1)
    band: Length = 8.0
    density: NotNegative = 0.2
    timeout: Positive = 300.0

    @model_validator(mode="after")
    def _some(self) -> Self:
        if self.robots[0] < 1 or self.robots[1] > 64:
            raise expected("expected teams of 1 to 64", key="robots")
        if ("custom" in self.shapes) != (self.slots is not None):
            raise expected("slots and the shape custom go together", key="slots")
        if self.slots is not None and _closest(self.slots) == 0.0:
            raise expected("two of them are the same", key="slots")
        if not self._teams():
            raise expected("no shape takes that many", key="robots")
        return self

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        rng = np.random.default_rng([seed, _TAG])
        teams = self._teams()
        shape, robots = teams[seed % len(teams)]
        team = self._team(shape, robots, sample_length(rng, self.spacing))
        slots = team.places()
        reach = float(np.hypot(slots[:, 0], slots[:, 1]).max())
        zone = round(2.0 * (reach + _AROUND), 2)
        size = (round(self.band + 2.0 * zone, 2), round(max(2.0 * reach + 4.0, 7.0), 2))
        count = round(self.density * self.band * size[1])
        for _ in range(_ATTEMPTS):
            options: dict[str, Any] = {"obstacles": count, "zone": zone}
            number = int(rng.integers(2**31))
            world = generate("clutter", size, number, require_feasible=False, **options)
            ground = DiscRegions(OccupancyMap.empty(size), world.shapes)
            start = sample_pose(rng, ground, slots, (0.0, 0.0, zone, size[1]))
            goal = sample_pose(rng, ground, slots, (size[0] - zone, 0.0, *size))
            if start is None or goal is None:
                continue
            name, said = f"{shape}-{robots}-{seed}", generated_world(world, options)
            return Instance(
                team.scenario(name, said, start, goal, self.timeout, seed),
                team.gets_across(ground, start, goal),
                float(robots),
            )
        raise InputError(f"the obstacles leave no place for {robots} robots", key="density")

    def _teams(self) -> list[tuple[Shape, int]]:
        """Shapes with numbers of robots, the smaller teams first."""
        own = OWN_COUNT | ({"custom": len(self.slots)} if self.slots else {})
        return [
            (shape, robots)
            for robots in range(self.robots[0], self.robots[1] + 1)
            for shape in self.shapes
            if own.get(shape, robots) == robots
        ]

    def _team(self, shape: Shape, robots: int, spacing: float) -> TeamSection:
        """The team with neighbouring slots `spacing` m apart."""
        if shape in OWN_COUNT:
            return TeamSection(shape=shape, side=spacing)
        if self.slots is not None and shape == "custom":
            # Rounded to whole millimetres.
            scale = spacing / _closest(self.slots) if robots > 1 else 1.0
            slots = tuple((round(scale * x, 3), round(scale * y, 3)) for x, y in self.slots)
            return TeamSection(shape=shape, slots=slots)
        if shape == "circle":
            radius = spacing / (2.0 * math.sin(math.pi / robots)) if robots > 1 else spacing
            return TeamSection(shape=shape, radius=round(radius, 3), robots=robots)
        return TeamSection(shape=shape, spacing=spacing, robots=robots)


def _closest(slots: Slots) -> float:
    return min((math.dist(p, q) for p, q in combinations(slots, 2)), default=math.inf)
