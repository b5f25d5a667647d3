"""Arrival times on a grid: the solver, its fields and the paths down them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.eikonal import _descent, _march
from cavalcade.errors import InputError
from cavalcade.geometry import Array

_ALL: NDArray[np.int64] = np.empty(0, np.int64)
_STEP = 0.5  # of a cell: step length of a walk down a field
_SEED_RADIUS = 12.0  # cells around a source that get straight-line times
_LONGEST = 200_000  # points of a path


class TravelGrid:
    """A speed map prepared for marching.

    Points `(N, 2)` are x, y in m, measured from the lower-left corner of cell [0, 0].

    Args:
        speed: `(rows, cols)` m/s; cells with a speed of 0 are blocked.
        cell: Cell size, m.

    Raises:
        InputError: The speeds are not a finite, non-negative `(rows, cols)` array, or `cell` is
            not positive.
    """

    def __init__(self, speed: ArrayLike, cell: float) -> None:
        speed = np.asarray(speed, dtype=float)
        if speed.ndim != 2 or speed.size == 0:
            raise InputError(f"expected (rows, cols) speeds, got shape {speed.shape}", key="speed")
        if not (np.isfinite(cell) and cell > 0.0):
            raise InputError(f"expected a positive cell size in m, got {cell!r}", key="cell")
        top = float(speed.max())
        if not (np.isfinite(top) and speed.min() >= 0.0):
            raise InputError("expected finite speeds of at least 0", key="speed")
        self.rows, self.cols = speed.shape
        self.cell = float(cell)
        self._stride = self.cols + 2
        delay = np.full((self.rows + 2, self._stride), np.inf)
        with np.errstate(divide="ignore"):
            np.divide(cell, speed, out=delay[1:-1, 1:-1])
        self._delay = delay.ravel()
        self._least = cell / top if top > 0.0 else np.inf
        size = self._delay.size
        self._visited = np.empty(size, np.uint32)
        self._heads = np.full(_march.BUCKETS, _march.NONE, np.uint32)
        self._queue = np.empty((2, _march.POOL * size), np.uint32)
        self._far = np.empty(size, np.uint32)
        self._scratch: Array | None = None  # kept at inf between local paths
        self._points: Array = np.empty((0, 2))
        self._stamps: Array = np.empty(0)

    @property
    def _width(self) -> float:
        return self._least if np.isfinite(self._least) else 1.0

    def cell_of(self, point: ArrayLike) -> tuple[int, int]:
        """The [row, col] in which a point `(2,)` lies; it may be outside the grid."""
        x, y = np.asarray(point, dtype=float)
        return int(np.floor(y / self.cell)), int(np.floor(x / self.cell))

    def is_free(self, point: ArrayLike) -> bool:
        """Whether the point lies in a cell that can be driven through."""
        row, col = self.cell_of(point)
        if not (0 <= row < self.rows and 0 <= col < self.cols):
            return False
        return bool(self._delay[(row + 1) * self._stride + col + 1] < np.inf)

    def nearest_free(self, point: ArrayLike, reach: float = np.inf) -> Array | None:
        """The centre of the nearest free cell `(2,)`, or None if there is none within `reach` m."""
        return self._nearest(point, self._delay, reach)

    def field(
        self, sources: ArrayLike, targets: Sequence[tuple[int, int]] | None = None
    ) -> ArrivalField:
        """March from points.

        Args:
            sources: `(N, 2)` m. One in a blocked cell starts nothing.
            targets: [row, col] cells at which the march may stop once all are settled; None
                settles every cell that can be reached.
        """
        sources = np.atleast_2d(np.asarray(sources, dtype=float))
        times = np.full(self._delay.size, np.inf)
        count = 0
        for u, v in sources / self.cell - 0.5:
            count = _descent.seed_point(
                u, v, _SEED_RADIUS, self._delay, self.rows, self.cols, self._stride, times,
                self._visited, count,
            )  # fmt: skip
        self._run(times, count, targets)
        return ArrivalField(self, times, sources)

    def from_cells(
        self,
        cells: Sequence[tuple[int, int]] | NDArray[np.int64],
        targets: Sequence[tuple[int, int]] | None = None,
    ) -> Array:
        """Times `(rows, cols)` from the centres of [row, col] cells; see `arrival_times`."""
        places = np.asarray(cells, dtype=np.int64).reshape(-1, 2)
        if ((places < 0) | (places >= (self.rows, self.cols))).any():
            raise InputError(
                f"expected [row, col] cells inside {self.rows} x {self.cols}", key="sources"
            )
        # Around few sources straight-line times help; many are a front, not points.
        radius = _SEED_RADIUS if len(places) <= 64 else 0.0
        times = np.full(self._delay.size, np.inf)
        count = 0
        for row, col in places:
            count = _descent.seed_point(
                float(col), float(row), radius, self._delay, self.rows, self.cols, self._stride,
                times, self._visited, count,
            )  # fmt: skip
        self._run(times, count, targets)
        blocked = (places[:, 0] + 1) * self._stride + places[:, 1] + 1
        times[blocked] = 0.0
        return times.reshape(self.rows + 2, self._stride)[1:-1, 1:-1].copy()

    def _run(
        self, times: Array, count: int, targets: Sequence[tuple[int, int]] | None
    ) -> None:
        if count == 0:
            return
        stops = _ALL
        if targets is not None:
            cells = np.asarray(targets, dtype=np.int64).reshape(-1, 2)
            stops = (cells[:, 0] + 1) * self._stride + cells[:, 1] + 1
        _march.march(
            self._delay, self._stride, times, self._visited, count, self._heads, self._queue[0],
            self._queue[1], self._far, self._width, stops, np.inf, np.zeros(3),
        )  # fmt: skip

    def local_path(self, start: ArrayLike, goal: ArrayLike) -> tuple[Array, float]:
        """The fastest way between two points, marching no farther than it must.

        Args:
            start, goal: `(2,)` m.

        Returns:
            The path `(K, 2)` from start to goal, empty where there is none, and its time in s
            (inf where there is none).
        """
        if self._scratch is None:
            self._scratch = np.full(self._delay.size, np.inf)
        self._buffers(8 * (self.rows + self.cols))
        start_u, start_v = np.asarray(start, dtype=float) / self.cell - 0.5
        goal_u, goal_v = np.asarray(goal, dtype=float) / self.cell - 0.5
        if not (self.is_free(start) and self.is_free(goal)):
            return np.empty((0, 2)), np.inf
        count, reached, eta = _descent.local_path(
            start_u, start_v, goal_u, goal_v, self._delay, self.rows, self.cols, self._stride,
            self._scratch, self._visited, self._heads, self._queue[0], self._queue[1], self._far,
            self._width, self._least, _STEP, self._points, self._stamps,
        )  # fmt: skip
        if not reached:
            return np.empty((0, 2)), np.inf
        return (self._points[:count] + 0.5) * self.cell, float(eta)

    def _buffers(self, size: int) -> None:
        if len(self._points) < size:
            self._points = np.empty((min(size, _LONGEST), 2))
            self._stamps = np.empty(min(size, _LONGEST))

    def _nearest(self, point: ArrayLike, values: Array, reach: float) -> Array | None:
        u, v = np.asarray(point, dtype=float) / self.cell - 0.5
        rings = int(min(reach / self.cell, self.rows + self.cols)) + 1
        found = _descent.nearest_reached(
            u, v, values, self.rows, self.cols, self._stride, rings
        )
        if found < 0:
            return None
        row, col = divmod(found, self._stride)
        return np.array([col - 0.5, row - 0.5]) * self.cell


class ArrivalField:
    """Arrival times around sources, and the ways down to them. Made by `TravelGrid.field`.

    Attributes:
        grid: The speed map that was marched over.
        sources: `(N, 2)` m.
    """

    def __init__(self, grid: TravelGrid, times: Array, sources: Array) -> None:
        self.grid = grid
        self.sources = sources
        self._times = times

    @property
    def times(self) -> Array:
        """`(rows, cols)` s; inf where the march did not come."""
        grid = self.grid
        return self._times.reshape(grid.rows + 2, grid.cols + 2)[1:-1, 1:-1]

    def eta(self, point: ArrayLike) -> float:
        """Interpolated arrival time at a point `(2,)`, s; inf in a cell that was not reached."""
        row, col = self.grid.cell_of(point)
        if not (0 <= row < self.grid.rows and 0 <= col < self.grid.cols):
            return np.inf
        if self._times[(row + 1) * (self.grid.cols + 2) + col + 1] == np.inf:
            return np.inf
        u, v = np.asarray(point, dtype=float) / self.grid.cell - 0.5
        return float(_descent.time_at(u, v, self._times, self.grid.cols + 2))

    def nearest_reached(self, point: ArrayLike, reach: float = np.inf) -> Array | None:
        """The centre of the nearest reached cell `(2,)`, or None if none lies within `reach` m."""
        return self.grid._nearest(point, self._times, reach)

    def path(self, start: ArrayLike) -> tuple[Array, Array]:
        """Walk down the field from a point to the nearest source in time.

        Args:
            start: `(2,)` m.

        Returns:
            Points `(K, 2)` from start to source with the remaining times `(K,)`, s; both empty
            if the start's cell was not reached.
        """
        grid = self.grid
        if self.eta(start) == np.inf:
            return np.empty((0, 2)), np.empty(0)
        grid._buffers(16 * (grid.rows + grid.cols))
        u, v = np.asarray(start, dtype=float) / grid.cell - 0.5
        source = self.sources[0] if len(self.sources) == 1 else self._source_below(start)
        goal_u, goal_v = source / grid.cell - 0.5
        while True:
            count, reached = _descent.descend(
                u, v, goal_u, goal_v, self._times, grid._delay, grid._stride, _STEP,
                grid._points, grid._stamps,
            )  # fmt: skip
            if reached or len(grid._points) == _LONGEST:
                break
            grid._buffers(2 * len(grid._points))
        points = (grid._points[:count] + 0.5) * grid.cell
        return points, grid._stamps[:count].copy()

    def _source_below(self, start: ArrayLike) -> Array:
        """Of several sources, the one a descent from `start` ends at."""
        best, found = np.inf, self.sources[0]
        for source in self.sources:
            _, eta = self.grid.local_path(start, source)
            if eta < best:
                best, found = eta, source
        return found


def arrival_times(
    speed: ArrayLike,
    sources: Sequence[tuple[int, int]],
    cell: float,
    targets: Sequence[tuple[int, int]] | None = None,
) -> Array:
    """Solve `|grad T| speed = 1` by fast marching (Sethian 1996; Norén et al., eq. 1).

    First order. Times within three cells of a source are those along the straight line, where
    it is free.

    Args:
        speed: `(rows, cols)` m/s; 0 blocks a cell.
        sources: [row, col] cells from whose centres the front starts. A blocked source holds the
            time 0 itself but starts nothing.
        cell: Cell size, m.
        targets: [row, col] cells at which to stop once all of them are settled.

    Returns:
        `(rows, cols)` s; inf where the front does not come.

    Raises:
        InputError: Malformed speeds, cell size or sources.
    """
    return TravelGrid(speed, cell).from_cells(sources, targets)
