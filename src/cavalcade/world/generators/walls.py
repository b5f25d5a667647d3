"""Mazes and rooms: places in a grid, joined along a random spanning tree, with walls between."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.errors import InputError
from cavalcade.world.generators.model import Draw, Size, number
from cavalcade.world.shapes import Box

_MARGIN = 0.10
"""Least wall between a door and the end of its room, m."""

Cell = tuple[int, int]
"""row, col"""

Pair = tuple[Cell, Cell]
"""Two neighbouring cells, the lower one first; the wall between them."""


def maze(
    size: Size,
    rng: np.random.Generator,
    *,
    passage: float = 1.2,
    wall: float = 0.2,
    loops: float = 0.0,
) -> Draw:
    """A maze that fills the world; start at the lower left, goal at the upper right.

    Its passages have one width; between any two places there is a single way unless loops are
    asked for.

    Args:
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
    px, py = (size[0] + wall) / cols, (size[1] + wall) / rows
    tree = _spanning_tree(rows, cols, rng)
    standing = [
        pair for pair in _neighbours(rows, cols) if pair not in tree and rng.uniform() >= loops
    ]
    # Walls in one line become one box, with the corner pieces at both of its ends.
    upright = _runs([(lower[1], lower[0]) for lower, upper in standing if lower[0] == upper[0]])
    level = _runs([lower for lower, upper in standing if lower[1] == upper[1]])
    boxes = [
        _box((col + 1) * px - wall, low * py - wall, (col + 1) * px, (high + 1) * py, size)
        for col, low, high in upright
    ]
    boxes += [
        _box(low * px - wall, (row + 1) * py - wall, (high + 1) * px, (row + 1) * py, size)
        for row, low, high in level
    ]
    start, goal = (
        (col * px + (px - wall) / 2.0, row * py + (py - wall) / 2.0, 0.0)
        for row, col in ((0, 0), (rows - 1, cols - 1))
    )
    return Draw(tuple(boxes), start, goal)


def rooms(
    size: Size,
    rng: np.random.Generator,
    *,
    room: float = 4.0,
    door: float = 1.2,
    wall: float = 0.2,
    extra: float = 0.3,
) -> Draw:
    """Rooms in a grid; doors along a random spanning tree, and some more.

    Start is the room at the lower left, goal the one at the upper right.

    Args:
        room: Wanted side of a room, wall included, m; sides are fitted to the world.
        door: Width of the doors, at least 1.0 m.
        wall: Thickness of the walls, m.
        extra: Fraction from 0 to 1 of the remaining walls that get a door as well.
    """
    door = number("door", door, 1.0)
    wall = number("wall", wall, 0.02)
    room = number("room", room, 0.5)
    extra = number("extra", extra, 0.0, 1.0)
    cols, rows = (max(1, round(side / room)) for side in size)
    if rows * cols > 10_000:
        raise InputError(f"makes {rows} x {cols} rooms, too many", key="room")
    pitch = (size[0] / cols, size[1] / rows)
    if min(pitch) < door + wall + 2.0 * _MARGIN:
        raise InputError(f"doors of {door:g} m don't fit rooms of {min(pitch):g} m", key="door")
    tree = _spanning_tree(rows, cols, rng)
    boxes: list[Box] = []
    for pair in _neighbours(rows, cols):
        (row, col), (other_row, _) = pair
        upright = row == other_row
        opened = pair in tree or rng.uniform() < extra
        # Along the wall, from its lower end: where it begins and ends, and the door.
        length = pitch[1] if upright else pitch[0]
        edge = wall / 2.0 + _MARGIN
        hinge = float(rng.uniform(edge, length - edge - door))
        # Walls reach half a thickness into each corner, so that corners are closed.
        ends = (-wall / 2.0, length + wall / 2.0)
        for begin, end in ((ends[0], hinge), (hinge + door, ends[1])) if opened else (ends,):
            along = (begin + end) / 2.0
            if upright:
                center = ((col + 1) * pitch[0], row * pitch[1] + along)
                boxes.append(Box(center, (wall, end - begin)))
            else:
                center = (col * pitch[0] + along, (row + 1) * pitch[1])
                boxes.append(Box(center, (end - begin, wall)))
    start, goal = (
        ((col + 0.5) * pitch[0], (row + 0.5) * pitch[1], 0.0)
        for row, col in ((0, 0), (rows - 1, cols - 1))
    )
    return Draw(tuple(boxes), start, goal)


def _neighbours(rows: int, cols: int) -> list[Pair]:
    """All pairs of neighbouring cells, in a fixed order."""
    beside = [((r, c), (r, c + 1)) for r in range(rows) for c in range(cols - 1)]
    above = [((r, c), (r + 1, c)) for r in range(rows - 1) for c in range(cols)]
    return beside + above


def _spanning_tree(rows: int, cols: int, rng: np.random.Generator) -> set[Pair]:
    """A random spanning tree by depth-first search: long winding ways."""
    visited = {(0, 0)}
    stack: list[Cell] = [(0, 0)]
    tree: set[Pair] = set()
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
        tree.add((first, second))
        visited.add(chosen)
        stack.append(chosen)
    return tree


def _runs(pieces: list[tuple[int, int]]) -> list[tuple[int, int, int]]:
    """Pieces (line, place) without a gap between them, as line, first and last place."""
    runs: list[tuple[int, int, int]] = []
    for line, place in sorted(pieces):
        if runs and runs[-1][0] == line and runs[-1][2] == place - 1:
            runs[-1] = (line, runs[-1][1], place)
        else:
            runs.append((line, place, place))
    return runs


def _box(x0: float, y0: float, x1: float, y1: float, size: Size) -> Box:
    """A box from corner to corner, as far as it lies in the world."""
    x0, y0, x1, y1 = max(x0, 0.0), max(y0, 0.0), min(x1, size[0]), min(y1, size[1])
    return Box(((x0 + x1) / 2.0, (y0 + y1) / 2.0), (x1 - x0, y1 - y0))
