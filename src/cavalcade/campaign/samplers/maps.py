"""Maps that real robots have made, crossed from anywhere to anywhere."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from cavalcade.campaign.samplers.data import DataFolder
from cavalcade.campaign.samplers.distances import distances_from
from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.sampler import Instance, Lengths, Pose, Sampler
from cavalcade.campaign.samplers.teams import TeamSection, fits, placed, scenario_data
from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.scenario.fields import Positive, Section, expected
from cavalcade.world import MapWarning, load_map

_TAG = 3
_STARTS, _GOALS = 400, 100
"""How many poses are tried; of starts, and of goals per start."""

_NEARLY = 1.0
"""How much longer or shorter than wanted a way may be, m."""

_GRACE, _SLOWEST = 60.0, 0.1
"""Seconds allowed for any way, and m/s for its length."""


class MapChoice(Section):
    """One of the maps.

    `file` lies below the folder of data. `weight` says how often it is taken. `teams` stand in
    for those of the sampler and `way` for its bounds, where the map is too small for them.
    """

    file: Path
    weight: Positive = 1.0
    teams: tuple[TeamSection, ...] | None = None
    way: Lengths | None = None


class MapsSampler(Sampler):
    """Random poses of a team at which it fits, `way` m apart for a robot's disc.

    Map, team, start and goal are sampled by the seed; the team gets from start to goal.
    """

    sampler: Literal["maps"]
    maps: Annotated[tuple[MapChoice, ...], Field(min_length=1)]
    teams: tuple[TeamSection, ...] = ()
    way: Lengths = (4.0, 40.0)

    @model_validator(mode="after")
    def _teams(self) -> Self:
        for index, choice in enumerate(self.maps):
            if not (choice.teams or self.teams):
                raise expected("no team for this map", key=f"maps[{index}].teams")
        return self

    @property
    def level_name(self) -> str | None:
        """What the curve runs over."""
        return "length of the way, m"

    def missing(self, data: DataFolder) -> str | None:
        """The first map that is not there."""
        for choice in self.maps:
            if data.path is None or not (data.path / choice.file).is_file():
                return data.lack(choice.file)
        return None

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`.

        Raises:
            InputError: A map is absent or malformed, or no such way is found on it.
        """
        rng = np.random.default_rng([seed, _TAG])
        weights = np.array([choice.weight for choice in self.maps])
        choice = self.maps[int(rng.choice(len(weights), p=weights / weights.sum()))]
        teams = choice.teams or self.teams
        team = teams[int(rng.integers(len(teams)))]
        file = data.file(choice.file)
        with warnings.catch_warnings():
            # Whoever makes the map is warned of its thresholds then.
            warnings.simplefilter("ignore", MapWarning)
            base = load_map(file, unknown="occupied")
        ground = DiscRegions(base)
        found = _crossing(rng, ground, team.places(), choice.way or self.way)
        if found is None:
            raise InputError(f"no way for a {team.shape} is found", file=file, key="way")
        start, goal, way = found
        data_ = scenario_data(
            f"{file.parent.name}-{file.stem}-{seed}",
            {"map": str(file)},
            team,
            start,
            goal,
            round(_GRACE + way / _SLOWEST),
            seed,
        )
        slots = team.places()
        feasible = ground.connect(placed(start, slots), placed(goal, slots))
        return Instance(data_, feasible, round(way, 2))


def _crossing(
    rng: np.random.Generator, ground: DiscRegions, slots: Array, bounds: tuple[float, float]
) -> tuple[Pose, Pose, float] | None:
    """Start, goal and the length of the way between their centres' nodes, m."""
    clear = np.flatnonzero(ground.labels)
    for _ in range(_STARTS if len(clear) else 0):
        cell, start = _pose(rng, ground, clear)
        if not _stands(ground, start, slots, cell):
            continue
        distances = distances_from(ground, cell, bounds[1])
        same = clear[ground.labels.flat[clear] == ground.labels[cell]]
        length = distances.to(np.stack(np.unravel_index(same, ground.labels.shape), axis=1))
        longest = length[np.isfinite(length)].max()
        if longest < bounds[0]:
            continue
        # Any length is as likely as any other, or most paths would be short ones.
        wanted = rng.uniform(bounds[0], longest)
        near = same[(np.abs(length - wanted) <= _NEARLY) & (length >= bounds[0])]
        for _ in range(_GOALS if len(near) else 0):
            end, goal = _pose(rng, ground, near)
            if _stands(ground, goal, slots, cell):
                return start, goal, float(distances.to([end])[0])
    return None


def _pose(
    rng: np.random.Generator, ground: DiscRegions, clear: NDArray[np.int64]
) -> tuple[tuple[int, int], Pose]:
    """A pose on one of the nodes, and the node."""
    row, col = divmod(int(clear[int(rng.integers(len(clear)))]), ground.labels.shape[1])
    x, y = ground.nodes([[row, col]])[0]
    yaw = rng.uniform(-math.pi, math.pi)
    return (row, col), (round(float(x), 4), round(float(y), 4), round(float(yaw), 4))


def _stands(ground: DiscRegions, pose: Pose, slots: Array, cell: tuple[int, int]) -> bool:
    """Whether the team fits at a pose, all of it in the same region as a node."""
    name = int(ground.labels[cell])
    return fits(ground, pose, slots, None) and all(
        name in ground.regions(place) for place in placed(pose, slots)
    )
