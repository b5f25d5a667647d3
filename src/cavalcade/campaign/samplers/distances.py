"""How far a disc has to go from one place to all others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.campaign.samplers.feasibility import RADIUS, DiscRegions
from cavalcade.geometry import Array

GRAIN = RADIUS / 2.0
"""Side of the blocks by which distances are measured, m. For the disc's centre walls are at least
two radii thick, so that blocks of half a radius never join what they part."""


@dataclass(frozen=True)
class Distances:
    """Lengths of paths from one place over blocks of nodes.

    Attributes:
        length: `(rows, cols)` m, at most 8 % too long; inf where the disc does not get.
        block: Side of a block in nodes.
    """

    length: Array
    block: int

    def to(self, cells: ArrayLike) -> Array:
        """Lengths `(N,)` of the paths to nodes `(N, 2)` given as [row, col], m."""
        rows, cols = np.asarray(cells, dtype=int).T // self.block
        found: Array = self.length[rows, cols]
        return found


def distances_from(ground: DiscRegions, cell: Sequence[int], most: float) -> Distances:
    """Distances of at most `most` m from the node `cell` (row, col), which is clear."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    block = max(1, math.floor(GRAIN / ground.step))
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
    length = np.full(free.shape, np.inf)
    length[free] = found
    return Distances(length, block)


def _blocks(nodes: NDArray[np.bool_], block: int) -> NDArray[np.bool_]:
    """Whether any node of each block `(rows, cols)` is set."""
    rows, cols = (-(-side // block) for side in nodes.shape)
    padded = np.zeros((rows * block, cols * block), dtype=bool)
    padded[: nodes.shape[0], : nodes.shape[1]] = nodes
    return np.asarray(padded.reshape(rows, block, cols, block).any(axis=(1, 3)), dtype=bool)
