"""Maps that real robots have made, crossed from anywhere to anywhere."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from cavalcade.campaign.samplers.feasibility import RADIUS, DiscRegions
from cavalcade.campaign.samplers.sampler import (
    DataFolder,
    Instance,
    Lengths,
    Pose,
    Sampler,
    rounded,
)
from cavalcade.campaign.samplers.teams import TeamSection, fits
from cavalcade.errors import InputError
from cavalcade.geometry import Array, transform_points
from cavalcade.scenario.fields import Positive, Section, expected
from cavalcade.world import MapWarning, load_map

_TAG = 3
_STARTS, _GOALS = 400, 100
"""How many poses are tried; of starts, and of goals per start."""

_NEARLY = 1.0
"""How much longer or shorter than wanted a way may be, m."""

_GRACE, _SLOWEST = 60.0, 0.1
"""Seconds allowed for any way, and m/s for its length."""

_GRAIN = RADIUS / 2.0
"""Side of the blocks by which distances are measured, m. For the disc's centre walls are at least
two radii thick, so that blocks of half a radius never join what they part."""


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

    LEVEL_NAME: ClassVar = "length of the way, m"

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

    def missing(self, data: DataFolder) -> str | None:
        """The first map that is not there."""
        for choice in self.maps:
            if data.path is None or not (data.path / choice.file).is_file():
                return data.lack(choice.file)
        return None

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
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
        name, timeout = f"{file.parent.name}-{file.stem}-{seed}", round(_GRACE + way / _SLOWEST)
        return Instance(
            team.scenario(name, {"map": str(file)}, start, goal, timeout, seed),
            team.gets_across(ground, start, goal),
            round(way, 2),
        )


def _crossing(
    rng: np.random.Generator, ground: DiscRegions, slots: Array, bounds: tuple[float, float]
) -> tuple[Pose, Pose, float] | None:
    """Start, goal and the length of the way between their centres' nodes, m."""
    clear = np.flatnonzero(ground.labels)
    for _ in range(_STARTS if len(clear) else 0):
        cell, start = _pose(rng, ground, clear)
        if not _stands(ground, start, slots, cell):
            continue
        distances = Distances(ground, cell, bounds[1])
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
    return (row, col), rounded((x, y, yaw))


def _stands(ground: DiscRegions, pose: Pose, slots: Array, cell: tuple[int, int]) -> bool:
    """Whether the team fits at a pose, all of it in the same region as a node."""
    name = int(ground.labels[cell])
    return fits(ground, pose, slots) and all(
        name in ground.regions(place) for place in transform_points(pose, slots)
    )


class Distances:
    """Lengths of a disc's paths from one place to all others, over blocks of nodes.

    Attributes:
        length: `(rows, cols)` m, at most 8 % too long; inf where the disc does not get.

    Args:
        ground: Where the disc may be.
        cell: The place: a clear node (row, col).
        most: Longer paths are not looked for, m.
    """

    def __init__(self, ground: DiscRegions, cell: Sequence[int], most: float) -> None:
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra

        self._block = block = max(1, math.floor(_GRAIN / ground.step))
        free = _blocks(ground.labels == ground.labels[tuple(cell)], block)
        index = np.full(free.shape, -1, dtype=np.int64)
        index[free] = np.arange(np.count_nonzero(free))
        side = block * ground.step
        tails, heads, lengths = [], [], []
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            here, there = index[: len(index) - down], index[down:]
            if right:
                here, there = (
                    (here[:, :-1], there[:, 1:]) if right > 0 else (here[:, 1:], there[:, :-1])
                )
            joined = (here >= 0) & (there >= 0)
            tails.append(here[joined])
            heads.append(there[joined])
            lengths.append(np.full(len(tails[-1]), side * math.hypot(down, right)))
        count = int(index.max()) + 1
        ends = (np.concatenate(tails), np.concatenate(heads))
        graph = csr_array((np.concatenate(lengths), ends), shape=(count, count))
        source = int(index[cell[0] // block, cell[1] // block])
        found = dijkstra(graph, directed=False, indices=source, limit=most)
        self.length: Array = np.full(free.shape, np.inf)
        self.length[free] = found

    def to(self, cells: ArrayLike) -> Array:
        """Lengths `(N,)` of the paths to nodes `(N, 2)` given as [row, col], m."""
        rows, cols = np.asarray(cells, dtype=int).T // self._block
        found: Array = self.length[rows, cols]
        return found


def _blocks(nodes: NDArray[np.bool_], block: int) -> NDArray[np.bool_]:
    """Whether any node of each block `(rows, cols)` is set."""
    for axis, side in enumerate(nodes.shape):
        nodes = np.logical_or.reduceat(nodes, np.arange(0, side, block), axis=axis)
    return nodes
