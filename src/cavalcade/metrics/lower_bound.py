"""The shortest path that a robot could take if it were alone: what runs are compared with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.geometry.string_pulling import descend, line_is_free, string_pulled_length
from cavalcade.metrics.summary import rounded
from cavalcade.robots import RobotModel
from cavalcade.world import OccupancyMap


def lower_bounds(
    area: OccupancyMap, models: Sequence[RobotModel], stops: Sequence[Sequence[ArrayLike]]
) -> tuple[float | None, ...]:
    """Per robot the length of its shortest path, alone, m; None where there is none.

    `stops`: per robot the points `(2,)` of the map frame that it visits, its start first; for
    fewer than two the answer is None.
    """
    paths: dict[float, ShortestPaths] = {}
    result: list[float | None] = []
    for model, points in zip(models, stops, strict=True):
        if len(points) > 1 and model.width not in paths:
            paths[model.width] = ShortestPaths(area, model.width / 2.0)
        legs = [paths[model.width].length(a, b) for a, b in pairwise(points)]
        known = [leg for leg in legs if leg is not None]
        result.append(rounded(sum(known)) if legs and len(known) == len(legs) else None)
    return tuple(result)


class ShortestPaths:
    """Shortest paths of a disc of `radius` m over one map.

    Meant as a lower bound, so everything is decided in the robot's favour: a cell is free if,
    given the raster's coarseness, the disc may fit anywhere in it. The homotopy comes from
    arrival times at unit speed; string pulling then removes their first-order error.
    """

    def __init__(self, area: OccupancyMap, radius: float) -> None:
        from cavalcade.eikonal import TravelGrid, surface_distance

        self._area = area
        occupied = np.ascontiguousarray(area.occupied)
        free = ~occupied
        # A shape marks every cell that it touches, and a cell's centre stands for all of it.
        needed = radius - 1.5 * math.sqrt(2.0) * area.resolution
        if needed > 0.0:
            free &= np.asarray(surface_distance(occupied, area.resolution)) >= needed
        self._free: NDArray[np.bool_] = free
        self._grid = TravelGrid(free, area.resolution)

    def length(self, start: ArrayLike, goal: ArrayLike) -> float | None:
        """Length in m of the shortest path between two points `(2,)` of the map frame.

        None where there is no path, or where an end lies outside the map or in an obstacle.
        """
        ends = self._area.to_local(np.array([start, goal], dtype=float))
        cell = self._area.resolution
        (r0, c0), (r1, c1) = np.floor(ends[:, ::-1] / cell).astype(int)
        for row, col in ((r0, c0), (r1, c1)):
            within = 0 <= row < self._area.rows and 0 <= col < self._area.cols
            if not within or not self._free[row, col]:
                return None
        if line_is_free(self._free, cell, *ends[0], *ends[1]):
            return float(np.hypot(*(ends[1] - ends[0])))
        times = self._grid.from_cells([(r1, c1)], targets=[(r0, c0)])
        if not np.isfinite(times[r0, c0]):
            return None
        cells = descend(np.ascontiguousarray(times), int(r0), int(c0))
        between = (np.asarray(cells[:, ::-1], dtype=np.float64) + 0.5) * cell
        path = np.concatenate([ends[:1], between, ends[1:]])
        return float(string_pulled_length(self._free, cell, path))
