"""Where in a generated world a team may start and end."""

from __future__ import annotations

import numpy as np

from cavalcade.errors import InputError

Area = tuple[float, float, float, float]
"""x_min, y_min, x_max, y_max in m."""


def end_zones(size: tuple[float, float], zone: float) -> tuple[Area, Area]:
    """The zones of that width on the left and on the right of a world."""
    width, height = size
    return (0.0, 0.0, zone, height), (width - zone, 0.0, width, height)


def two_rooms(
    rng: np.random.Generator | None, size: tuple[float, float], side: float, apart: int
) -> tuple[Area, Area]:
    """Two rooms of the rooms generator.

    Args:
        rng: Draws any two; None takes the first and the last, lower left and upper right.
        size: Width and height of the world, m.
        side: Wanted side of a room, m; the generator fits it to the world.
        apart: Doors between them at least.

    Raises:
        InputError: There are no two such rooms.
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
