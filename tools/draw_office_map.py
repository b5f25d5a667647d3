"""Draws the map of the shipped scenario `office`.

Run as `python tools/draw_office_map.py`.

Walls, doors and desks in metres, the lower left corner at (0, 0). Ground that a mapping robot
would not have seen, here a lift shaft and what lies behind the outer wall, stays unknown.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cavalcade.world import Box, OccupancyMap, rasterise, save_map

LIBRARY = Path(__file__).parents[1] / "src/cavalcade/scenario/library/maps"
RESOLUTION = 0.05
WIDTH, HEIGHT = 24.0, 16.0
WALL = 0.15
DOOR = 1.3

# The building stands half a metre inside the picture; x and y are those of the walls' middles.
WEST, EAST, SOUTH, NORTH = 0.5, 23.5, 0.5, 15.5
CORRIDOR = (7.0, 9.2)

# Walls along x: y, from, to, middles of the doors in it.
LEVEL = [
    (SOUTH, WEST, EAST, []),
    (NORTH, WEST, EAST, []),
    (CORRIDOR[0], WEST, EAST, [3.6, 8.7, 13.9, 19.8]),
    (CORRIDOR[1], WEST, EAST, [3.2, 9.6, 18.6]),
]
# Walls along y: x, from, to, middles of the doors in it.
UPRIGHT = [
    (WEST, SOUTH, NORTH, []),
    (EAST, SOUTH, NORTH, []),
    (6.2, SOUTH, CORRIDOR[0], []),
    (11.4, SOUTH, CORRIDOR[0], [5.6]),
    (16.6, SOUTH, CORRIDOR[0], []),
    (6.4, CORRIDOR[1], NORTH, [13.9]),
    (13.2, CORRIDOR[1], NORTH, []),
    (15.2, CORRIDOR[1], NORTH, []),
]
# Desks, shelves, tables and pillars: x from, y from, x to, y to.
FURNITURE = [
    (0.7, 0.7, 1.4, 2.3),
    (5.2, 0.7, 6.0, 2.4),
    (4.9, 5.6, 6.0, 6.1),
    (7.4, 1.9, 9.0, 2.7),
    (7.4, 0.7, 9.0, 1.3),
    (10.6, 2.2, 11.2, 4.0),
    (12.9, 0.7, 15.2, 1.3),
    (12.9, 2.9, 15.2, 3.7),
    (17.0, 0.7, 17.6, 4.4),
    (19.6, 2.6, 21.6, 3.6),
    (22.4, 5.0, 23.3, 6.5),
    (0.7, 11.4, 1.3, 14.2),
    (2.9, 12.6, 4.7, 13.5),
    (8.4, 11.9, 11.2, 13.0),
    (6.7, 10.2, 7.2, 11.9),
    (15.4, 10.0, 15.9, 14.0),
    (20.9, 9.5, 21.7, 11.2),
    (18.2, 14.6, 20.8, 15.2),
    (10.9, 7.1, 11.7, 7.4),
    (16.2, 8.7, 17.0, 9.1),
]
SHAFT = (13.3, 9.3, 15.1, 15.4)


def main() -> None:
    """Write office.yaml and office.png."""
    rows, cols = round(HEIGHT / RESOLUTION), round(WIDTH / RESOLUTION)
    grid = np.zeros((rows, cols), dtype=np.int8)
    grid[rasterise([block(*SHAFT)], rows, cols, RESOLUTION)] = -1
    seen = rasterise([block(WEST, SOUTH, EAST, NORTH)], rows, cols, RESOLUTION)
    grid[~seen] = -1
    boxes = [block(*corners) for corners in FURNITURE]
    for y, start, end, doors in LEVEL:
        boxes += [block(a, y, b, y, WALL) for a, b in pieces(start, end, doors)]
    for x, start, end, doors in UPRIGHT:
        boxes += [block(x, a, x, b, WALL) for a, b in pieces(start, end, doors)]
    grid[rasterise(boxes, rows, cols, RESOLUTION)] = 100
    LIBRARY.mkdir(parents=True, exist_ok=True)
    save_map(OccupancyMap(grid, RESOLUTION), LIBRARY / "office.yaml", image="png")


def block(x0: float, y0: float, x1: float, y1: float, grow: float = 0.0) -> Box:
    """The rectangle between two corners, `grow` larger in each direction."""
    center = ((x0 + x1) / 2.0, (y0 + y1) / 2.0)
    return Box(center, (x1 - x0 + grow, y1 - y0 + grow))


def pieces(start: float, end: float, doors: list[float]) -> list[tuple[float, float]]:
    """What the doors leave of a wall."""
    # The wall's thickness is added at both ends of a piece.
    edges = [start]
    for door in doors:
        edges += [door - (DOOR + WALL) / 2.0, door + (DOOR + WALL) / 2.0]
    return list(zip(edges[::2], [*edges[1::2], end], strict=True))


if __name__ == "__main__":
    main()
