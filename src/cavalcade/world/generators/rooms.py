"""Rooms: a grid of rooms joined by doors; each can be reached from each."""

from __future__ import annotations

import numpy as np

from cavalcade.errors import InputError
from cavalcade.world.generators.model import Draw, Pose, Size, number
from cavalcade.world.generators.spanning import Cell, spanning_tree, walls_between
from cavalcade.world.shapes import Box

_MARGIN = 0.10
"""Least wall between a door and the end of its room, m."""


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
        size: Width and height of the world, m.
        rng: Source of all randomness.
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
    tree = spanning_tree(rows, cols, rng)
    boxes: list[Box] = []
    for pair in walls_between(rows, cols):
        opened = pair in tree or rng.uniform() < extra
        boxes.extend(_wall(pair, pitch, wall, _door_place(pair, pitch, door, wall, rng), opened))
    return Draw(tuple(boxes), _middle((0, 0), pitch), _middle((rows - 1, cols - 1), pitch))


def _middle(cell: Cell, pitch: tuple[float, float]) -> Pose:
    return ((cell[1] + 0.5) * pitch[0], (cell[0] + 0.5) * pitch[1], 0.0)


def _door_place(
    pair: tuple[Cell, Cell],
    pitch: tuple[float, float],
    door: float,
    wall: float,
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Where along the wall the door begins and ends, m from the wall's lower end."""
    upright = pair[0][0] == pair[1][0]
    length = pitch[1] if upright else pitch[0]
    edge = wall / 2.0 + _MARGIN
    begin = float(rng.uniform(edge, length - edge - door))
    return begin, begin + door


def _wall(
    pair: tuple[Cell, Cell],
    pitch: tuple[float, float],
    wall: float,
    place: tuple[float, float],
    opened: bool,
) -> list[Box]:
    """The wall between two neighbouring rooms: one box, or two beside a door."""
    (row, col), (other_row, _) = pair
    upright = row == other_row
    length = pitch[1] if upright else pitch[0]
    # Walls reach half a thickness into each corner, so that corners are closed.
    ends = (-wall / 2.0, length + wall / 2.0)
    pieces = [(ends[0], place[0]), (place[1], ends[1])] if opened else [ends]
    boxes = []
    for begin, end in pieces:
        along = (begin + end) / 2.0
        if upright:
            center = ((col + 1) * pitch[0], row * pitch[1] + along)
            boxes.append(Box(center, (wall, end - begin)))
        else:
            center = (col * pitch[0] + along, (row + 1) * pitch[1])
            boxes.append(Box(center, (end - begin, wall)))
    return boxes
