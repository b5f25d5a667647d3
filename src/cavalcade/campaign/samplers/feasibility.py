"""Whether a team can get there at all, decided without the planner.

A disc of `RADIUS` stands for every robot. It has to get from every start to every slot at the
goal past everything that stands, one disc at a time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.geometry import Array
from cavalcade.world import OccupancyMap, Shape
from cavalcade.world.shapes import distance_to_shapes

RADIUS = 0.30
"""m; narrower than a go1 is long (0.65 m), wider than it is broad (0.28 m)."""

STEP = 0.02
"""Distance of the nodes in worlds without a map of their own, m."""

_MAX_NODES = 1_500_000
"""Larger worlds get coarser nodes."""

_TINY = 1e-9


class DiscRegions:
    """The connected regions that a disc's centre can be in, worked out once per world.

    Nodes lie at the centres of a map's cells, or `STEP` apart where there is no map. Neighbours,
    also across the corner, are joined if the way between them is clear for certain: between two
    places `d` apart that both are `c` away from a point, no place is nearer to it than
    sqrt(c^2 - d^2 / 4). The answer "connected" is therefore always right; "not connected" may be
    wrong where what is free for the centre is hardly wider than a step.
    """

    def __init__(
        self,
        base: OccupancyMap,
        shapes: Sequence[Shape] = (),
        radius: float = RADIUS,
        step: float = STEP,
    ) -> None:
        """Work out the regions of one world.

        Args:
            base: The map; its occupied cells count as squares, and so does all beyond it.
            shapes: Obstacles besides, map frame, m.
            radius: Of the disc, m.
            step: Distance of the nodes if the map has no occupied cell, m.
        """
        from scipy.ndimage import label

        self.base = base
        self.shapes = tuple(shapes)
        self._mapped = bool(base.occupied.any())
        width, height = base.size
        least = math.sqrt(width * height / _MAX_NODES)
        self.step = base.resolution if self._mapped else max(step, least)
        # The longest way between neighbours is the diagonal one.
        self.need = math.hypot(radius, self.step / math.sqrt(2.0))
        clear = self._clear_nodes()
        self.labels: NDArray[np.int32] = label(clear, structure=np.ones((3, 3)))[0]

    def nodes(self, cells: ArrayLike) -> Array:
        """Places `(N, 2)` in the map frame of nodes `(N, 2)` given as [row, col], m."""
        local = (np.asarray(cells, dtype=float)[:, ::-1] + 0.5) * self.step
        return self.base.to_map(local)

    def clearance(self, points: ArrayLike, reach: float = 0.5) -> Array:
        """Distance `(N,)` in m of points `(N, 2)` to what stands; exact up to `reach`.

        What lies beyond the border stands too; outside the map the distance is 0.
        """
        places = np.asarray(points, dtype=float)
        local = self.base.to_local(places)
        border = np.minimum(local, np.asarray(self.base.size) - local).min(axis=1)
        distance = np.minimum(np.maximum(border, 0.0), distance_to_shapes(self.shapes, places))
        if self._mapped:
            for k, point in enumerate(local):
                distance[k] = min(distance[k], self._to_cells(point, reach))
        return distance

    def regions(self, point: ArrayLike) -> set[int]:
        """The regions that a disc at a point `(2,)` is in for certain; none if it is in the way."""
        place = np.asarray(point, dtype=float)
        if float(self.clearance(place[None])[0]) < self.need - _TINY:
            return set()
        rows, cols = self.labels.shape
        col, row = np.floor(self.base.to_local(place[None])[0] / self.step - 0.5).astype(int)
        near = self.labels[max(row, 0) : min(row + 2, rows), max(col, 0) : min(col + 2, cols)]
        return {int(name) for name in near.flat} - {0}

    def connect(self, starts: ArrayLike, goals: ArrayLike) -> bool:
        """Whether the disc gets from every start `(N, 2)` to every goal `(M, 2)`."""
        there = [self.regions(goal) for goal in np.asarray(goals, dtype=float)]
        return all(
            not here.isdisjoint(goal)
            for here in (self.regions(start) for start in np.asarray(starts, dtype=float))
            for goal in there
        )

    def _clear_nodes(self) -> NDArray[np.bool_]:
        """Whether each node `(rows, cols)` keeps `need`."""
        if self._mapped:
            clear = ~_within(self.base.occupied, self.need / self.step)
        else:
            width, height = self.base.size
            clear = np.ones((int(height / self.step), int(width / self.step)), dtype=bool)
            edge = math.ceil(self.need / self.step - 0.5 - _TINY)
            clear[:edge] = clear[:, :edge] = False
            # The last nodes may lie up to a step further from the border than the first ones.
            x, y = ((np.arange(count) + 0.5) * self.step for count in clear.shape[::-1])
            clear[y > height - self.need] = False
            clear[:, x > width - self.need] = False
        for shape in self.shapes:
            self._block(clear, shape)
        return clear

    def _block(self, clear: NDArray[np.bool_], shape: Shape) -> None:
        """Take the nodes that are too near to a shape out of `clear`."""
        x0, y0, x1, y1 = shape.bounds
        corners = self.base.to_local([[x0, y0], [x0, y1], [x1, y0], [x1, y1]])
        low = np.floor((corners.min(axis=0) - self.need) / self.step).astype(int)
        high = np.ceil((corners.max(axis=0) + self.need) / self.step).astype(int)
        left, bottom = np.maximum(low, 0)
        right, top = np.minimum(high, clear.shape[::-1])
        if left >= right or bottom >= top:
            return
        window = np.stack(
            np.meshgrid(np.arange(bottom, top), np.arange(left, right), indexing="ij"), axis=-1
        )
        distance = shape.distance(self.nodes(window.reshape(-1, 2)))
        clear[bottom:top, left:right] &= (distance >= self.need).reshape(window.shape[:2])

    def _to_cells(self, local: Array, reach: float) -> float:
        """Distance of a point `(2,)` to the nearest occupied square, at most `reach`, m."""
        cell = self.base.resolution
        low = np.maximum(np.floor((local - reach) / cell).astype(int), 0)
        high = np.maximum(np.ceil((local + reach) / cell).astype(int), 0)
        near = np.argwhere(self.base.occupied[low[1] : high[1], low[0] : high[0]])
        if len(near) == 0:
            return reach
        centers = (near[:, ::-1] + low + 0.5) * cell
        beyond = np.maximum(np.abs(local - centers) - cell / 2.0, 0.0)
        return min(float(np.hypot(beyond[:, 0], beyond[:, 1]).min()), reach)


def _within(occupied: NDArray[np.bool_], reach: float) -> NDArray[np.bool_]:
    """Cells whose centre is nearer than `reach` cells to an occupied square; the border is one.

    Row by row of the disc's outline, each by sums along the map's rows.
    """
    most = math.floor(reach + 0.5)
    padded = np.pad(occupied, most, constant_values=True)
    total = np.zeros((padded.shape[0], padded.shape[1] + 1), dtype=np.int32)
    np.cumsum(padded, axis=1, out=total[:, 1:])
    rows, cols = occupied.shape
    found = np.zeros((rows, cols), dtype=bool)
    for away in range(most + 1):
        rise = max(away - 0.5, 0.0)
        if rise >= reach - _TINY:
            continue
        # The furthest column whose square is still nearer than `reach` in that row.
        side = math.ceil(math.sqrt(reach**2 - rise**2) + 0.5 - _TINY) - 1
        first, last = most - side, most + side + 1
        hit = total[:, last : last + cols] != total[:, first : first + cols]
        for row in {most - away, most + away}:
            found |= hit[row : row + rows]
    return found
