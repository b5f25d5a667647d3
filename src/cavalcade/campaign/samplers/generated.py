"""Worlds of the seeded generators, which a team crosses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, Strict, model_validator

from cavalcade.campaign.samplers.feasibility import STEP, DiscRegions
from cavalcade.campaign.samplers.sampler import (
    Area,
    Counts,
    DataFolder,
    Instance,
    Lengths,
    Pose,
    Sampler,
    generated_world,
    rounded,
    sample_count,
    sample_length,
)
from cavalcade.campaign.samplers.teams import TeamSection, fits, sample_pose
from cavalcade.errors import InputError
from cavalcade.scenario.fields import (
    Fraction,
    Length,
    NotNegative,
    Positive,
    Size,
    expected,
)
from cavalcade.scenario.ground import KIND_OPTIONS
from cavalcade.world import GeneratedWorld, OccupancyMap, generate

Kind = Literal["clutter", "forest", "rooms", "corridor"]

LEVELS: dict[Kind, str] = {
    "clutter": "obstacles",
    "forest": "trees",
    "rooms": "width of the doors, m",
    "corridor": "width of the corridor, m",
}
"""What each kind's curve runs over."""

_CORRIDOR_STEP = 0.04
"""Distance of the nodes of the test for feasibility there, m: distances to a corridor's long walls
take time, and it is either wide enough or not."""

_TAG = 1
_ATTEMPTS = 50
_ZONE = 2.8
"""The generators' own width of the zones for start and goal, m."""

_SIDE = 4.0
"""The generator's own side of a room, m."""


class GeneratedSampler(Sampler):
    """A generator's first sample per seed; whether it can be crossed is found out, not enforced.

    Where an option takes a range, each world has a value from it. A world that leaves the team
    no place to stand is sampled again. The options are those of the kind, see
    `cavalcade.world.generators`; null is the generator's default.

    `poses: middle` starts and ends where the generator says, or nearby in the same zone where the
    team does not fit; `anywhere` samples place and yaw in the zones or, of rooms, in any two rooms
    that are at least `apart` doors from each other.
    """

    sampler: Literal["generated"]
    kind: Kind
    size: Size
    team: TeamSection
    poses: Literal["middle", "anywhere"] = "middle"
    apart: Annotated[int, Strict(), Field(ge=1, le=20)] = 2
    timeout: Positive = 180.0
    obstacles: Counts | None = None
    zone: NotNegative | None = None
    trees: Counts | None = None
    spacing: Lengths | None = None
    room: Length | None = None
    door: Lengths | None = None
    wall: Length | None = None
    extra: Fraction | None = None
    width: Lengths | None = None
    bends: Counts | None = None
    angle: NotNegative | None = None

    @model_validator(mode="after")
    def _known_options(self) -> Self:
        known = KIND_OPTIONS[self.kind]
        for name in sorted(set().union(*(KIND_OPTIONS[kind] for kind in LEVELS))):
            if name not in known and getattr(self, name) is not None:
                raise expected(f"a {self.kind} has no such option", key=name, choices=known)
        return self

    @property
    def level_name(self) -> str | None:
        """What the curve runs over."""
        return LEVELS[self.kind]

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        rng = np.random.default_rng([seed, _TAG, list(LEVELS).index(self.kind)])
        refused = InputError(f"no {self.kind} of that size has room for the team", key="team")
        for attempt in range(_ATTEMPTS):
            options = self._options(rng)
            number = int(rng.integers(2**31)) if attempt else seed
            try:
                world = generate(self.kind, self.size, number, require_feasible=False, **options)
            except InputError as error:
                refused = error
                continue
            instance = self._placed(rng, world, options, seed)
            if instance is not None:
                return instance
        raise refused

    def _options(self, rng: np.random.Generator) -> dict[str, Any]:
        """The generator's options, one value each."""
        found: dict[str, Any] = {}
        for name in KIND_OPTIONS[self.kind]:
            value = getattr(self, name)
            if isinstance(value, tuple):
                whole = isinstance(value[0], int)
                value = sample_count(rng, value) if whole else sample_length(rng, value)
            if value is not None:
                found[name] = value
        return found

    def _placed(
        self,
        rng: np.random.Generator,
        world: GeneratedWorld,
        options: Mapping[str, Any],
        seed: int,
    ) -> Instance | None:
        """The world with the team in it; None if it does not fit."""
        base = OccupancyMap.empty(world.size, world.resolution)
        step = _CORRIDOR_STEP if self.kind == "corridor" else STEP
        ground = DiscRegions(base, world.shapes, step=step)
        areas = self._areas(rng)
        start = self._pose(rng, ground, areas[0], world.start)
        goal = self._pose(rng, ground, areas[1], world.goal)
        if start is None or goal is None:
            return None
        name, said = f"{self.kind}-{seed}", generated_world(world, options)
        return Instance(
            self.team.scenario(name, said, start, goal, self.timeout, seed),
            self.team.gets_across(ground, start, goal),
            self._level(world, options),
        )

    def _pose(
        self, rng: np.random.Generator, ground: DiscRegions, area: Area, hint: Sequence[float]
    ) -> Pose | None:
        """A pose at which the team fits: the generator's own if that is wanted and will do."""
        slots = self.team.places()
        if self.poses == "anywhere":
            return sample_pose(rng, ground, slots, area)
        pose = rounded(hint)
        return pose if fits(ground, pose, slots) else sample_pose(rng, ground, slots, area, pose[2])

    def _areas(self, rng: np.random.Generator) -> tuple[Area, Area]:
        """Where the team starts and ends, m."""
        if self.kind != "rooms":
            (width, height), zone = self.size, _ZONE if self.zone is None else self.zone
            return (0.0, 0.0, zone, height), (width - zone, 0.0, width, height)
        side = _SIDE if self.room is None else self.room
        return _two_rooms(rng if self.poses == "anywhere" else None, self.size, side, self.apart)

    def _level(self, world: GeneratedWorld, options: Mapping[str, Any]) -> float | None:
        """Where the world lies on the curve."""
        if self.kind in ("clutter", "forest"):
            return float(len(world.shapes))
        value = options.get("door" if self.kind == "rooms" else "width")
        return None if value is None else float(value)


def _two_rooms(
    rng: np.random.Generator | None, size: tuple[float, float], side: float, apart: int
) -> tuple[Area, Area]:
    """Two rooms of the rooms generator at least `apart` doors from each other.

    Any two by `rng`; without it the first and the last, lower left and upper right. The generator
    fits the wanted `side` of a room, m, to the world.
    """
    cols, rows = (max(1, round(length / side)) for length in size)
    pairs = [
        (a, b)
        for a in range(rows * cols)
        for b in range(rows * cols)
        if abs(a // cols - b // cols) + abs(a % cols - b % cols) >= apart
    ]
    if not pairs:
        raise InputError(f"there are no rooms {apart} doors apart", key="apart")
    chosen = (0, rows * cols - 1) if rng is None else pairs[int(rng.integers(len(pairs)))]
    x, y = size[0] / cols, size[1] / rows
    first, last = (
        (room % cols * x, room // cols * y, (room % cols + 1) * x, (room // cols + 1) * y)
        for room in chosen
    )
    return first, last
