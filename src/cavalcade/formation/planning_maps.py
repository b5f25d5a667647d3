"""The planner's view of the world: distances, velocity maps, what is connected with what.

Everything here is in the grid's own frame: x, y in m from the lower-left corner of cell [0, 0].
"""

from __future__ import annotations

import copy
import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from cavalcade.eikonal import TravelGrid, surface_distance, velocity_map
from cavalcade.formation._clearance import DistanceMap
from cavalcade.formation._placement import FreeSpace, fitting_shift, values_at
from cavalcade.formation.settings import FormationSettings
from cavalcade.geometry import Array
from cavalcade.world import Box, rasterise

_SPARE = 0.30  # m on each side of a body with which a place is not narrow
_OWN_WAY = 1.0  # dearer for followers: past an obstacle on its other side springs hold them back
_SHIFT_STEP = 0.05  # m between places that are tried for a shape, at most


class PlanningMaps:
    """Maps of one state of the world.

    The inflation `radius` is the settings', unless a path needs less, m; the `distance`, if it is
    known already, need not be found. What a narrow place costs depends on the robots'
    `half_width`, m.

    Attributes:
        distance: `(rows, cols)` from each cell's centre to the nearest obstacle's surface, m.
        speed_b: `(rows, cols)` the paper's W_B.
        leader, follower: W_A and W_B with the settings' price of narrowness, for marching.
        slots: What to march over from final slots: the paper's W_B, or as the leader does, so
            that all find the same way.
    """

    def __init__(
        self,
        occupied: NDArray[np.bool_],
        cell: float,
        settings: FormationSettings,
        radius: float | None = None,
        distance: Array | None = None,
        half_width: float = 0.0,
    ) -> None:
        self.occupied = occupied
        self.cell = cell
        self.settings = settings
        self.radius = settings.r_max if radius is None else radius
        self.distance = surface_distance(occupied, cell) if distance is None else distance
        self.speed_b = velocity_map(self.distance, self.radius, settings.d_safe_b)
        self._half_width = half_width
        speed_a = velocity_map(self.distance, self.radius, settings.d_safe_a)
        most = settings.max_detour
        self.leader = TravelGrid(self._priced(speed_a, most), cell)
        speed_b = self._priced(self.speed_b, most + _OWN_WAY)
        self.follower = TravelGrid(speed_b, cell, beside=self.leader)
        self.slots = self.follower if math.isinf(most) else self.leader
        self._labels: NDArray[np.int32] | None = None

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, m."""
        rows, cols = self.occupied.shape
        return cols * self.cell, rows * self.cell

    def tightened(self, radius: float) -> PlanningMaps:
        """The same world for robots inflated by another radius."""
        # Distances that were renewed piecewise are cut off where the maps saturate.
        known = self.distance if radius <= self.radius else None
        return self._with(self.occupied, radius, known)

    def changed(self, occupied: NDArray[np.bool_]) -> PlanningMaps:
        """The maps after some cells changed; distances are renewed only near the change."""
        distance = self.distance_after(occupied)
        return self if distance is self.distance else self.redrawn(occupied, distance)

    def redrawn(self, occupied: NDArray[np.bool_], distance: Array) -> PlanningMaps:
        """The maps of other cells, whose distances are known."""
        return self._with(occupied, self.radius, distance)

    def distance_after(
        self, occupied: NDArray[np.bool_], former: tuple[NDArray[np.bool_], Array] | None = None
    ) -> Array:
        """Distances after some cells changed, found anew only near the change.

        The change is from the maps' own cells and distances, or from `former` ones.
        """
        before, known = (self.occupied, self.distance) if former is None else former
        rows, cols = np.nonzero(occupied != before)
        if len(rows) == 0:
            return known
        # Beyond this distance from a change, the saturated maps stay as they are.
        not_narrow = self._half_width + _SPARE - self.radius
        safe = max(self.settings.d_safe_a, self.settings.d_safe_b, not_narrow)
        reach = int(np.ceil((self.radius + safe) / self.cell)) + 2
        height, width = occupied.shape
        top, left = max(rows.min() - reach, 0), max(cols.min() - reach, 0)
        bottom, right = min(rows.max() + reach + 1, height), min(cols.max() + reach + 1, width)
        if (bottom - top) * (right - left) > 0.5 * occupied.size:
            return surface_distance(occupied, self.cell)
        t, lf = max(top - reach, 0), max(left - reach, 0)
        b, rt = min(bottom + reach, height), min(right + reach, width)
        window = surface_distance(occupied[t:b, lf:rt], self.cell, border=False)
        # Where the window ends inside the map nothing is known beyond it, but that is far away.
        inner = window[top - t : bottom - t, left - lf : right - lf]
        far = (reach - 1) * self.cell
        r, c = np.arange(top, bottom) + 0.5, np.arange(left, right) + 0.5
        to_border = self.cell * np.minimum(
            np.minimum(r, height - r)[:, None], np.minimum(c, width - c)[None, :]
        )
        distance = known.copy()
        distance[top:bottom, left:right] = np.minimum(np.minimum(inner, to_border), far)
        return distance

    def twin(self) -> PlanningMaps:
        """The same maps with a work space of their own, to plan on in another thread."""
        twin = copy.copy(self)
        twin.leader = self.leader.twin()
        twin.follower = self.follower.twin(beside=twin.leader)
        twin.slots = twin.follower if self.slots is self.follower else twin.leader
        return twin

    def _with(
        self, occupied: NDArray[np.bool_], radius: float, distance: Array | None = None
    ) -> PlanningMaps:
        return PlanningMaps(occupied, self.cell, self.settings, radius, distance, self._half_width)

    def _priced(self, speed: Array, most: float) -> Array:
        """A velocity map `(rows, cols)` on which ground that is not narrow is not dear.

        A metre with `_SPARE` on each side of a body, as seen from anywhere in the cell, costs at
        most 1 + `most` metres elsewhere. From there to the inflated obstacles the price rises to
        that of the velocity map itself.
        """
        if math.isinf(most):
            return speed
        easy = self._half_width + _SPARE - math.sqrt(0.5) * self.cell
        share = (self.distance - self.radius) / max(easy - self.radius, 1e-3)
        least = np.minimum(share, 1.0) / (1.0 + most)
        return np.where(speed > 0.0, np.maximum(speed, least), 0.0)

    def clearance(self, points: Array) -> Array:
        """Distance `(N,)` from points `(N, 2)` to the nearest obstacle: that of their cells; m."""
        rows, cols = self._cells(points)
        return self.distance[rows, cols]

    def speed_at(self, points: Array) -> Array:
        """W_B `(N,)` in the cells of points `(N, 2)`; 0 off the map."""
        return values_at(self.speed_b, np.ascontiguousarray(points), self.cell)

    def distance_at(self, point: Array) -> float:
        """Distance from a point `(2,)` to the nearest obstacle's surface, m; 0 off the map."""
        (row,), (col,) = self._cells(point[None])
        # What is nearest to the point is hardly farther off than what is nearest to its cell.
        reach = int(self.distance[row, col] / self.cell) + 2
        top, left = max(row - reach, 0), max(col - reach, 0)
        near = self.occupied[top : row + reach + 1, left : col + reach + 1]
        low = (np.argwhere(near)[:, ::-1] + (left, top)) * self.cell
        away = np.maximum(np.maximum(low - point, point - low - self.cell), 0.0)
        border = min(*point, *(self.size - point), self.distance[row, col] + self.cell)
        return max(float(np.hypot(*away.T).min(initial=border)), 0.0)

    def component(self, point: Array) -> int:
        """Number of the connected free region a point stands in or next to; 0 if in none."""
        labels = self.regions()
        rows, cols = self._cells(np.asarray(point)[None])
        here = int(labels[rows[0], cols[0]])
        if here == 0:
            near = self.follower.nearest_free(point, reach=2.0 * self.settings.d_safe_b)
            if near is not None:
                rows, cols = self._cells(near[None])
                here = int(labels[rows[0], cols[0]])
        return here

    def with_bodies(self, poses: Array, length: float, width: float) -> PlanningMaps:
        """The maps with robots that stand at `poses` `(K, 3)` as obstacles to go around."""
        bodies = [Box((x, y), (length, width), yaw) for x, y, yaw in poses.tolist()]
        rows, cols = self.occupied.shape
        return self.changed(self.occupied | rasterise(bodies, rows, cols, self.cell))

    def placement(
        self, slots: Array, region: int | None, reach: float, body: Array, needed: float
    ) -> Array | None:
        """The smallest shift `(2,)` with which every slot takes a robot, in one free region, m.

        Slots `(N, 2)` are shifted by at most `reach`; with None for the region's number any will
        do. `body` `(K, 2)` are the centres of discs that cover a robot, from its centre, turned to
        the goal's heading; they need that clearance. Returns None if no shift fits.
        """
        known = DistanceMap(self.distance, self.cell)
        space = FreeSpace(self.regions(), known, float(self.radius))
        bodies = slots[:, None] + body[None]
        wanted = -1 if region is None else region

        def first_fit(shifts: Array) -> Array | None:
            found = fitting_shift(shifts, slots, bodies, wanted, needed, space)
            return None if found < 0 else np.asarray(shifts[found])

        unmoved = first_fit(np.zeros((1, 2)))
        step = min(self.cell, _SHIFT_STEP)
        if unmoved is not None or reach < step:
            return unmoved
        span = int(np.ceil(reach / step))
        steps = np.arange(-span, span + 1) * step
        shifts = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        length = np.hypot(shifts[:, 0], shifts[:, 1])
        shifts, length = shifts[length <= reach], length[length <= reach]
        return first_fit(shifts[np.argsort(length, kind="stable")])

    def regions(self) -> NDArray[np.int32]:
        """Numbers `(rows, cols)` of the connected free regions, 0 where there is none."""
        if self._labels is None:
            self._labels = ndimage.label(self.speed_b > 0.0)[0]
        return self._labels

    def _cells(self, points: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        index = np.floor(np.asarray(points) / self.cell).astype(np.int64)
        rows, cols = self.occupied.shape
        return np.clip(index[:, 1], 0, rows - 1), np.clip(index[:, 0], 0, cols - 1)
