"""Maze: passages of one width, a single way between any two places unless loops are asked for."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.errors import InputError
from cavalcade.world.generators.model import Draw, Pose, Size, number
from cavalcade.world.generators.spanning import Passage, spanning_tree, walls_between
from cavalcade.world.shapes import Box


def maze(
    size: Size,
    rng: np.random.Generator,
    *,
    passage: float = 1.2,
    wall: float = 0.2,
    loops: float = 0.0,
) -> Draw:
    """A maze that fills the world; start at the lower left, goal at the upper right.

    Args:
        size: Width and height of the world, m.
        rng: Source of all randomness.
        passage: Least width of the passages, m; they are widened to fill the world evenly.
        wall: Thickness of the walls, m.
        loops: Fraction from 0 to 1 of the remaining walls that are taken away.
    """
    passage = number("passage", passage, 0.5)
    wall = number("wall", wall, 0.02)
    loops = number("loops", loops, 0.0, 1.0)
    cols, rows = (math.floor((side + wall) / (passage + wall) + 1e-9) for side in size)
    if rows < 1 or cols < 1:
        raise InputError(f"is too small for passages of {passage:g} m", key="size")
    if rows * cols > 10_000:
        raise InputError(f"makes {rows} x {cols} places, too many", key="passage")
    pitch = ((size[0] + wall) / cols, (size[1] + wall) / rows)
    tree = spanning_tree(rows, cols, rng)
    standing = [
        pair for pair in walls_between(rows, cols) if pair not in tree and rng.uniform() >= loops
    ]
    boxes = [_box(run, pitch, wall, size) for run in _runs(standing)]

    def place(row: int, col: int) -> Pose:
        free = (pitch[0] - wall, pitch[1] - wall)
        return (col * pitch[0] + free[0] / 2.0, row * pitch[1] + free[1] / 2.0, 0.0)

    return Draw(tuple(boxes), place(0, 0), place(rows - 1, cols - 1))


def _runs(walls: list[Passage]) -> list[tuple[Passage, Passage]]:
    """Walls in one line and without a gap, as pairs of their first and last piece."""
    upright = sorted(((a[1], a[0]), (a, b)) for a, b in walls if a[0] == b[0])
    level = sorted(((a[0], a[1]), (a, b)) for a, b in walls if a[1] == b[1])
    runs: list[tuple[Passage, Passage]] = []
    for pieces in (upright, level):
        previous: tuple[int, int] | None = None
        for key, pair in pieces:
            if previous is not None and key == (previous[0], previous[1] + 1):
                runs[-1] = (runs[-1][0], pair)
            else:
                runs.append((pair, pair))
            previous = key
    return runs


def _box(run: tuple[Passage, Passage], pitch: tuple[float, float], wall: float, size: Size) -> Box:
    """The box of a run of walls, with the corner pieces at both of its ends."""
    (first, beyond), (last, _) = run
    if first[0] == beyond[0]:
        x0, x1 = (first[1] + 1) * pitch[0] - wall, (first[1] + 1) * pitch[0]
        y0, y1 = first[0] * pitch[1] - wall, (last[0] + 1) * pitch[1]
    else:
        x0, x1 = first[1] * pitch[0] - wall, (last[1] + 1) * pitch[0]
        y0, y1 = (first[0] + 1) * pitch[1] - wall, (first[0] + 1) * pitch[1]
    x0, x1 = max(x0, 0.0), min(x1, size[0])
    y0, y1 = max(y0, 0.0), min(y1, size[1])
    return Box(((x0 + x1) / 2.0, (y0 + y1) / 2.0), (x1 - x0, y1 - y0))
