"""The ground and what is solid on it, as pages need it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.outlines import shape_ring
from cavalcade.drawing.replay.packing import packed, whole
from cavalcade.drawing.scene import Team
from cavalcade.geometry import Array
from cavalcade.locomotion.footholds import LEAST_TRAVERSABILITY
from cavalcade.world import OccupancyMap, Terrain

WALL = 0.5
"""How high solid obstacles are drawn, m: as high as they are in physics; planners never look."""

_MOST_NODES = 22_000
_MOST_NODES_DENSE = 150_000
_MOST_RECTANGLES = 3000


def ground_data(team: Team, dense: bool) -> dict[str, Any]:
    """Border, terrain, solids, walls and unknown cells.

    `dense`: steps are to be drawn where feet find them.
    """
    base, terrain, (walls, unknown) = team.world.base, team.world.terrain, team.cells
    most_nodes = _MOST_NODES_DENSE if dense else _MOST_NODES
    return {
        "border": whole(team.border, 1000),
        "terrain": None if terrain is None else _terrain(terrain, most_nodes),
        "solids": [prism(shape_ring(shape, corners=28), terrain) for shape in team.fixed],
        "walls": _walls(base, walls, terrain),
        "unknown": _walls(base, unknown, terrain),
    }


def prism(outline: Array, terrain: Terrain | None) -> dict[str, Any]:
    """The upright prism over an outline `(K, 2)`: its ring in mm, counter-clockwise, not closed.

    `fill` holds triangles of the ring's indices; `low` and `high` are heights of foot and top, m.
    """
    ring = counter_clockwise(outline)
    low, high = 0.0, WALL
    if terrain is not None:
        around = terrain.heights_at(np.concatenate([ring, ring.mean(axis=0)[None, :]]))
        low, high = float(around.min()) - 0.05, float(around.max()) + WALL
    return {
        "ring": whole(ring, 1000),
        "fill": triangulate(ring).ravel().tolist(),
        "low": round(low, 3),
        "high": round(high, 3),
    }


def _terrain(terrain: Terrain, most_nodes: int) -> dict[str, Any]:
    """Every so many-th node of the grid, heights in 1/65000 of their range."""
    stride = max(1, int(np.ceil(np.sqrt(terrain.rows * terrain.cols / most_nodes))))
    rows, cols = (np.unique(np.append(np.arange(0, n, stride), n - 1)) for n in
                  (terrain.rows, terrain.cols))  # fmt: skip
    height = terrain.height[np.ix_(rows, cols)]
    blocked = terrain.traversability[np.ix_(rows, cols)] < LEAST_TRAVERSABILITY
    low, span = float(height.min()), max(float(np.ptp(height)), 1e-6)
    levels = np.rint((height - low) / span * 65_000).astype("<u2")
    return {
        "x": whole((cols + 0.5) * terrain.resolution, 1000),
        "y": whole((rows + 0.5) * terrain.resolution, 1000),
        "origin": [round(part, 6) for part in terrain.origin],
        "low": low,
        "span": span,
        "heights": packed(levels),
        "blocked": packed(np.packbits(blocked.ravel())),
    }


def _walls(
    grid: OccupancyMap, cells: NDArray[np.bool_], terrain: Terrain | None
) -> dict[str, Any] | None:
    """Cells of the map as rectangles in the grid's own frame; None where there are none."""
    if not cells.any():
        return None
    found, factor = rectangles(cells)
    top = 0.0 if terrain is None else float(terrain.height.max())
    return {
        "cell": grid.resolution * factor,
        "origin": [round(part, 6) for part in grid.origin],
        "low": 0.0 if terrain is None else float(terrain.height.min()),
        "high": round(top + WALL, 3),
        "boxes": found.ravel().tolist(),
    }


def triangulate(ring: Array) -> NDArray[np.int64]:
    """Triangles `(K - 2, 3)` of a simple polygon `(K, 2)` given counter-clockwise.

    By cutting off ears; a polygon without any left, such as one that crosses itself, is fanned.
    """
    left = list(range(len(ring)))
    found: list[tuple[int, int, int]] = []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _is_ear(ring, left, a, b, c):
                found.append((a, b, c))
                del left[k]
                break
        else:
            found += [(left[0], left[k], left[k + 1]) for k in range(1, len(left) - 2)]
            left = [left[0], left[-2], left[-1]]
    found.append((left[0], left[1], left[2]))
    return np.array(found, dtype=np.int64)


def counter_clockwise(ring: Array) -> Array:
    """The same outline in the mathematical sense of turning."""
    x, y = ring.T
    twice = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    return ring if twice >= 0.0 else ring[::-1]


def rectangles(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int64], int]:
    """Rectangles `(K, 4)` first row, first column, last row + 1, last column + 1 of true cells.

    They cover them exactly, but for very ragged grids, whose cells are joined two by two, and
    again, until there are few enough.

    Returns:
        The rectangles in cells of the joined grid, and how many cells were joined per side.
    """
    factor = 1
    while True:
        found = _greedy(mask)
        if len(found) <= _MOST_RECTANGLES:
            return found, factor
        rows, cols = mask.shape
        padded = np.pad(mask, ((0, rows % 2), (0, cols % 2)))
        fours = padded.reshape(padded.shape[0] // 2, 2, padded.shape[1] // 2, 2)
        mask = np.asarray(fours.any(axis=(1, 3)))
        factor *= 2


def _greedy(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    left = mask.copy()
    found = []
    for row in range(mask.shape[0]):
        while left[row].any():
            first = int(np.argmax(left[row]))
            gap = np.flatnonzero(~left[row, first:])
            last = first + int(gap[0]) if len(gap) else mask.shape[1]
            end = row + 1
            while end < mask.shape[0] and left[end, first:last].all():
                end += 1
            left[row:end, first:last] = False
            found.append((row, first, end, last))
            if len(found) > 4 * _MOST_RECTANGLES:  # joined anyway
                return np.array(found, dtype=np.int64)
    return np.array(found, dtype=np.int64).reshape(-1, 4)


def _is_ear(ring: Array, left: list[int], a: int, b: int, c: int) -> bool:
    """Whether b is a convex corner and no other point lies in the triangle or on its edge."""
    corners = (ring[a], ring[b], ring[c])
    edges = tuple(zip(corners, (*corners[1:], corners[0]), strict=True))
    return _side(*corners) > 0.0 and not any(
        all(_side(*edge, ring[k]) >= 0.0 for edge in edges) for k in left if k not in (a, b, c)
    )


def _side(a: Array, b: Array, p: Array) -> float:
    return float((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]))
