"""Arrival times on a grid: the solver, its fields and the paths down them."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.eikonal import _descent, _march
from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.values import described, instance_of, plain_number, real_array

_ALL: NDArray[np.int64] = np.empty(0, np.int64)
_FARTHEST = 1e12  # cells
_SEED_RADIUS = 12.0  # cells around a source that get straight-line times


class TravelGrid:
    """A speed map prepared for marching.

    Points `(N, 2)` are x, y in m, measured from the lower-left corner of cell [0, 0].

    Args:
        speed: `(rows, cols)` m/s; cells with a speed of 0, and masked ones, are blocked.
        cell: Cell size, m.
        beside: Another grid, whose work space is used if it has the same size: large arrays
            that are new cost more than a short march. The two cannot march at the same time then.

    Raises:
        InputError: The speeds are not a finite, non-negative `(rows, cols)` array, or `cell` is
            not positive.
    """

    def __init__(self, speed: ArrayLike, cell: float, beside: TravelGrid | None = None) -> None:
        # Nobody knows how fast one goes in cells that are masked: they are walls.
        known = np.ma.filled(speed, 0) if np.ma.isMaskedArray(speed) else speed
        speed = real_array(known, "speed", "(rows, cols) numbers")
        if speed.ndim != 2 or speed.size == 0:
            raise InputError(f"expected (rows, cols) speeds, got shape {speed.shape}", key="speed")
        try:
            self.cell = float(cell)
        except (TypeError, ValueError, OverflowError):
            self.cell = math.nan
        if not 0.0 < self.cell < np.inf:
            what = "a positive cell size in m"
            raise InputError(f"expected {what}, got {described(cell)}", key="cell")
        if beside is not None:
            instance_of(beside, TravelGrid, "beside")
        self.rows, self.cols = speed.shape
        self._stride = self.cols + 2
        size = (self.rows + 2) * self._stride
        delay = np.empty(size)
        top = float(speed.max())
        positive = _march.pad_delays(np.ascontiguousarray(speed), self.cell, delay)
        if not (np.isfinite(top) and positive):
            raise InputError("expected finite speeds of at least 0", key="speed")
        least = self.cell / top if top > 0.0 else np.inf
        width = 0.7 * least if np.isfinite(least) else 1.0
        self._delay = delay
        self._padded = _march.PaddedGrid(delay, self.rows, self.cols, self._stride, least, width)
        self._work: _march.WorkSpace
        if beside is not None and beside._delay.size == size:
            self._work = beside._work
        else:
            self._work = _march.work_space(size)
        self._scratch: Array | None = None  # kept at inf between local paths
        self._points: Array = np.empty((0, 2))
        self._stamps: Array = np.empty(0)

    def twin(self, beside: TravelGrid | None = None) -> TravelGrid:
        """The same grid with a work space of its own, or that `beside` it, for another thread."""
        twin = copy.copy(self)
        size = self._work.cells.size
        twin._work = _march.work_space(self._delay.size, size) if beside is None else beside._work
        twin._scratch = None
        twin._points, twin._stamps = np.empty((0, 2)), np.empty(0)
        return twin

    def get_ready(self) -> None:
        """Allocate what the first path would allocate."""
        if self._scratch is None:
            self._scratch = np.full(self._delay.size, np.inf)
        self._buffers(16 * (self.rows + self.cols))

    @property
    def speed(self) -> Array:
        """Speeds `(rows, cols)`, m/s, as they were given but for rounding."""
        delay = self._delay.reshape(self.rows + 2, self._stride)[1:-1, 1:-1]
        return np.asarray(self.cell / delay)

    def cell_of(self, point: ArrayLike) -> tuple[int, int]:
        """The [row, col] in which a point `(2,)` lies; it may be outside the grid."""
        u, v = self._place(point)
        return math.floor(v + 0.5), math.floor(u + 0.5)

    def is_free(self, point: ArrayLike) -> bool:
        """Whether the point lies in a cell that can be driven through."""
        return bool(self._delay[self._index(*self._place(point))] < np.inf)

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
        points = np.atleast_2d(real_array(sources, "point", "points (N, 2) in m"))
        if points.ndim != 2 or points.shape[1] != 2:
            raise InputError(f"expected points (N, 2) in m, got shape {points.shape}", key="point")
        places = [self._place(point) for point in points]
        return ArrivalField(self, self._march(places, _SEED_RADIUS, targets), points)

    def from_cells(
        self,
        cells: Sequence[tuple[int, int]] | NDArray[np.int64],
        targets: Sequence[tuple[int, int]] | None = None,
    ) -> Array:
        """Times `(rows, cols)` from the centres of [row, col] cells; see `arrival_times`."""
        places = self._cells(cells, "sources")
        # Around few sources straight-line times help; many are a front, not points.
        radius = _SEED_RADIUS if len(places) <= 64 else 0.0
        times = self._march([(float(c), float(r)) for r, c in places], radius, targets)
        blocked = (places[:, 0] + 1) * self._stride + places[:, 1] + 1
        times[blocked] = 0.0
        return times.reshape(self.rows + 2, self._stride)[1:-1, 1:-1]

    def _march(
        self,
        places: Sequence[tuple[float, float]],
        radius: float,
        targets: Sequence[tuple[int, int]] | None,
    ) -> Array:
        """Padded times from places in cell units; `radius` as in `_descent.seed_point`."""
        stops = _ALL
        if targets is not None:
            cells = self._cells(targets, "targets")
            stops = (cells[:, 0] + 1) * self._stride + cells[:, 1] + 1
            stops = stops[self._delay[stops] < np.inf]
        idle = targets is not None and len(stops) == 0
        stop = _march.Stop(stops, np.inf, 0.0, 0.0)
        while True:
            times = np.full(self._delay.size, np.inf)
            count = 0
            for u, v in places:
                count = _descent.seed_point(
                    u, v, radius, self._padded, times, self._work.visited, count
                )
            if count == 0 or idle:
                return times
            try:
                _march.march(self._padded, times, count, self._work, stop)
            except MemoryError:
                self._grow()
            else:
                return times

    def _grow(self) -> None:
        """More work space, for the rare march whose front is longer than the grid has cells."""
        self._work = _march.work_space(self._delay.size, 4 * self._work.cells.size)

    def _cells(self, cells: ArrayLike, key: str) -> NDArray[np.int64]:
        """[row, col] cells as an array `(N, 2)`."""
        try:
            places = np.asarray(cells)
            if places.dtype.kind == "c":
                raise TypeError
            with np.errstate(invalid="ignore"):
                whole = places.astype(np.int64)
            same = bool((whole == places).all()) and not np.ma.is_masked(cells)
        except (TypeError, ValueError, OverflowError):
            raise InputError("expected [row, col] cells", key=key) from None
        if places.size == 0:
            return np.empty((0, 2), np.int64)
        if whole.ndim == 1:
            whole = whole[None]
        if not same or whole.ndim != 2 or whole.shape[1] != 2:
            raise InputError("expected [row, col] cells", key=key)
        if ((whole < 0) | (whole >= (self.rows, self.cols))).any():
            raise InputError(f"expected [row, col] cells inside {self.rows} x {self.cols}", key=key)
        return whole

    def local_path(
        self, start: ArrayLike, goal: ArrayLike, guess: float = np.inf
    ) -> tuple[Array, float]:
        """The fastest path between two points, marching no farther than it must.

        Args:
            start, goal: `(2,)` m.
            guess: A time that the path will hardly exceed, s. It saves work and never changes the
                result.

        Returns:
            The path `(K, 2)` from start to goal, empty where there is none, and its time in s
            (inf where there is none).
        """
        guess = plain_number(guess, "guess")
        if math.isnan(guess):
            raise InputError("expected a time in s, got nan", key="guess")
        begin, end = self._place(start), self._place(goal)
        if np.inf in (self._delay[self._index(*begin)], self._delay[self._index(*end)]):
            return np.empty((0, 2)), np.inf
        self._buffers(8 * (self.rows + self.cols))
        while True:
            if self._scratch is None:
                self._scratch = np.full(self._delay.size, np.inf)
            try:
                count, reached, eta = _descent.local_path(
                    begin, end, guess, self._padded, self._scratch, self._work,
                    self._points, self._stamps,
                )  # fmt: skip
            except MemoryError:
                self._grow()
                self._scratch = None
                continue
            if reached:
                break
            if eta == np.inf or not self._more_points():
                return np.empty((0, 2)), np.inf
        return (self._points[:count] + 0.5) * self.cell, float(eta)

    def _place(self, point: ArrayLike) -> tuple[float, float]:
        """A point `(2,)` in cell units: [row, col] = [v, u] is a cell's centre."""
        # Asked for many times in every cycle: Python's own numbers are the fastest here.
        pair: Any = point.tolist() if isinstance(point, np.ndarray) else point
        try:
            x, y = pair
            x, y = float(x), float(y)
        except (TypeError, ValueError, OverflowError):
            raise InputError("expected a point (x, y) in m", key="point") from None
        u, v = x / self.cell, y / self.cell
        if -_FARTHEST < u < _FARTHEST and -_FARTHEST < v < _FARTHEST:
            return u - 0.5, v - 0.5
        if not (math.isfinite(x) and math.isfinite(y)):
            raise InputError(f"expected a finite point in m, got ({x}, {y})", key="point")
        # Far off any grid: brought to where it fits into an integer.
        u, v = (min(max(cells, -_FARTHEST), _FARTHEST) for cells in (u, v))
        return u - 0.5, v - 0.5

    def _index(self, u: float, v: float) -> int:
        """Padded index of the cell around a place in cell units; outside, of a blocked one."""
        row, col = math.floor(v + 0.5), math.floor(u + 0.5)
        if 0 <= row < self.rows and 0 <= col < self.cols:
            return (row + 1) * self._stride + col + 1
        return 0

    def _buffers(self, size: int) -> None:
        if len(self._points) < size:
            self._points = np.empty((size, 2))
            self._stamps = np.empty(size)

    def _more_points(self) -> bool:
        """Double the longest path; False if it is longer than any path already."""
        size = len(self._points)
        if size > 8 * self._delay.size:
            return False
        self._buffers(2 * size)
        return True

    def _nearest(self, point: ArrayLike, values: Array, reach: float) -> Array | None:
        u, v = self._place(point)
        reach = plain_number(reach, "reach")
        if not reach >= 0.0:
            raise InputError(f"expected a distance in m, got {reach:g}", key="reach")
        rings = int(min(reach / self.cell, self.rows + self.cols)) + 1
        found = _descent.nearest_reached(u, v, values, self.rows, self.cols, rings)
        if found < 0:
            return None
        row, col = divmod(found, self._stride)
        nearest = np.array([col - 0.5, row - 0.5])
        near = np.hypot(*(nearest - (u + 0.5, v + 0.5))) <= reach / self.cell
        return nearest * self.cell if near else None


class ArrivalField:
    """Arrival times around sources, and the paths down to them. Made by `TravelGrid.field`.

    Attributes:
        grid: The speed map that was marched over.
        sources: `(N, 2)` m.
    """

    def __init__(self, grid: TravelGrid, times: Array, sources: Array) -> None:
        self.grid = grid
        self.sources = sources
        self._times = times
        # Only these have times around them.
        self._goals = np.array([s for s in sources if grid.is_free(s)]).reshape(-1, 2)
        self._goals = self._goals / grid.cell - 0.5

    @property
    def times(self) -> Array:
        """`(rows, cols)` s; inf where the march did not come."""
        grid = self.grid
        return self._times.reshape(grid.rows + 2, grid.cols + 2)[1:-1, 1:-1]

    def eta(self, point: ArrayLike) -> float:
        """Interpolated arrival time at a point `(2,)`, s; inf in a cell that was not reached."""
        u, v = self.grid._place(point)
        if self._times[self.grid._index(u, v)] == np.inf:
            return np.inf
        return float(_descent.time_at(u, v, self._times, self.grid._stride))

    def reaches(self, cells: Sequence[tuple[int, int]]) -> bool:
        """Whether the march came to all of these [row, col] cells of the grid."""
        stride = self.grid._stride
        try:
            return all(self._times[(r + 1) * stride + c + 1] < np.inf for r, c in cells)
        except (TypeError, ValueError, IndexError, OverflowError):
            raise InputError("expected [row, col] cells of the grid", key="cells") from None

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
        u, v = grid._place(start)
        if self._times[grid._index(u, v)] == np.inf:
            return np.empty((0, 2)), np.empty(0)
        grid._buffers(16 * (grid.rows + grid.cols))
        while True:
            count, reached = _descent.descend(
                u, v, self._goals, self._times, grid._padded, grid._points, grid._stamps
            )
            if reached or not grid._more_points():
                break
        points = (grid._points[:count] + 0.5) * grid.cell
        return points, grid._stamps[:count].copy()


def arrival_times(
    speed: ArrayLike,
    sources: Sequence[tuple[int, int]],
    cell: float,
    targets: Sequence[tuple[int, int]] | None = None,
) -> Array:
    """Solve `|grad T| speed = 1` by fast marching (Sethian 1996; Norén et al., eq. 1).

    First order. Times within twelve cells of a source (of up to 64) begin with those along the
    straight line, where it is free: near a source the scheme is at its worst.

    Args:
        speed: `(rows, cols)` m/s; 0 blocks a cell, and so does a mask.
        sources: [row, col] cells from whose centres the front starts. A blocked source holds the
            time 0 itself but starts nothing.
        cell: Cell size, m.
        targets: [row, col] cells at which to stop once all of them are settled.

    Returns:
        `(rows, cols)` s; inf where the front does not come. A view into a larger array, so not
        contiguous.

    Raises:
        InputError: Malformed speeds or cell size; sources or targets off the grid.
    """
    return TravelGrid(speed, cell).from_cells(sources, targets)
