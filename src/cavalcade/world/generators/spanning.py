"""Random spanning trees of a grid of places: what mazes and rooms are connected by."""

from __future__ import annotations

import numpy as np

Cell = tuple[int, int]
"""row, col"""

Passage = tuple[Cell, Cell]
"""Two neighbouring cells, the lower one first."""


def walls_between(rows: int, cols: int) -> list[Passage]:
    """All pairs of neighbouring cells, in a fixed order."""
    beside = [((r, c), (r, c + 1)) for r in range(rows) for c in range(cols - 1)]
    above = [((r, c), (r + 1, c)) for r in range(rows - 1) for c in range(cols)]
    return beside + above


def spanning_tree(rows: int, cols: int, rng: np.random.Generator) -> frozenset[Passage]:
    """Passages of a random spanning tree by depth-first search: long winding ways."""
    visited = {(0, 0)}
    stack: list[Cell] = [(0, 0)]
    passages: set[Passage] = set()
    while stack:
        row, col = stack[-1]
        around = [(row, col + 1), (row + 1, col), (row, col - 1), (row - 1, col)]
        fresh = [
            (r, c) for r, c in around if 0 <= r < rows and 0 <= c < cols and (r, c) not in visited
        ]
        if not fresh:
            stack.pop()
            continue
        chosen = fresh[int(rng.integers(len(fresh)))]
        first, second = sorted([(row, col), chosen])
        passages.add((first, second))
        visited.add(chosen)
        stack.append(chosen)
    return frozenset(passages)
