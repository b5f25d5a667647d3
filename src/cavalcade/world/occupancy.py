"""The occupancy map: which ground is free, and where the grid lies in the map frame."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.errors import MapError
from cavalcade.geometry import Array, inverse_transform_points, transform_points
from cavalcade.values import instances_of, number_array, plain_number, points_of
from cavalcade.world.raster import rasterise
from cavalcade.world.shapes import Shape

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Cell values of nav_msgs/OccupancyGrid."""

OCCUPIED_FROM = 65
"""Cells of at least this value are obstacles (ROS's usual `occupied_thresh` of 0.65)."""

MAX_CELLS = 64_000_000
"""Largest map that is accepted, in cells."""

MAX_EXTENT = 1e6
"""Largest coordinate of a map, m."""

_FAR, _FARTHEST = 1e9, 1e300
"""Largest coordinate of a point, m, and where the cell is the answer, which is clipped."""

Unknown = Literal["occupied", "free"]


class PlacedGrid:
    """What maps and terrains share: rows and columns of square cells, placed in the map frame."""

    resolution: float
    origin: tuple[float, float, float]
    _cells: ClassVar[str]
    """The attribute that has the rows and columns."""

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(getattr(self, self._cells))

    @property
    def cols(self) -> int:
        """Number of columns."""
        return int(getattr(self, self._cells).shape[1])

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in m, along the grid's own axes."""
        return self.cols * self.resolution, self.rows * self.resolution

    def to_local(self, points: ArrayLike) -> Array:
        """Points `(N, 2)` of the map frame seen from the corner of cell [0, 0], x along columns."""
        return inverse_transform_points(self.origin, points_of(points, _FAR, MapError))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        names = (field.name for field in fields(self))  # type: ignore[arg-type]
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    def __hash__(self) -> int:
        return hash((self.rows, self.cols, self.resolution, self.origin))


@dataclass(frozen=True, eq=False)
class OccupancyMap(PlacedGrid):
    """A grid of occupancy values with its place in the map frame.

    Grids are indexed `[row, col]` = `[y, x]` with row 0 at the lowest y; a cell's value stands
    for its whole square. All ground beyond the map counts as occupied.

    Args:
        grid: `(rows, cols)` integers: 0 free, 100 occupied, -1 unknown, 1 to 99 in between; or
            bool, True for occupied. Masked cells are unknown. Copied, and read-only afterwards.
        resolution: Side of a cell, m.
        origin: Pose (x m, y m, yaw rad) of the lower-left corner of cell [0, 0] in the map frame.
        unknown: Whether cells of value -1 count as `occupied` or `free`.

    Raises:
        MapError: Wrong shape or type, values out of range, something not finite, or more than
            `MAX_CELLS` cells.
    """

    grid: NDArray[np.int8]
    resolution: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    unknown: Unknown = "occupied"

    _cells = "grid"

    def __post_init__(self) -> None:
        object.__setattr__(self, "grid", _checked_grid(self.grid))
        object.__setattr__(self, "resolution", checked_resolution(self.resolution))
        object.__setattr__(self, "origin", checked_origin(self.origin))
        if not isinstance(self.unknown, str) or self.unknown not in ("occupied", "free"):
            raise MapError("expected another value", key="unknown", choices=("occupied", "free"))
        if max(self.grid.shape) * self.resolution > MAX_EXTENT:
            raise MapError(f"the map is longer than {MAX_EXTENT:g} m", key="resolution")

    @classmethod
    def empty(cls, size: ArrayLike, resolution: float = 0.05) -> OccupancyMap:
        """A free map of `size` (width, height) m whose lower-left corner is at (0, 0).

        A size that is no multiple of the resolution loses the last, incomplete row or column.
        """
        resolution = checked_resolution(resolution)
        rows, cols = grid_shape(size, resolution)
        return cls(np.zeros((rows, cols), dtype=np.int8), resolution)

    @cached_property
    def occupied(self) -> NDArray[np.bool_]:
        """Obstacle cells `(rows, cols)`, read-only: at least 65, or unknown unless that is free."""
        occupied: NDArray[np.bool_] = self.grid >= OCCUPIED_FROM
        if self.unknown == "occupied":
            occupied |= self.grid == UNKNOWN
        occupied.setflags(write=False)
        return occupied

    def to_map(self, points: ArrayLike) -> Array:
        """Points `(N, 2)` given from the corner of cell [0, 0], expressed in the map frame."""
        return transform_points(self.origin, points_of(points, _FAR, MapError))

    def cell_of(self, points: ArrayLike) -> NDArray[np.int64]:
        """Cells `(N, 2)` as [row, col] in which points `(N, 2)` of the map frame lie.

        They may lie outside the map.

        Raises:
            MapError: A point is not finite.
        """
        array = points_of(points, _FARTHEST, MapError)
        local = inverse_transform_points(self.origin, array)
        # The clip keeps the conversion to integers defined for points that are light years away.
        cells: Array = np.floor(local[:, ::-1] / self.resolution)
        return np.clip(cells, -(2.0**40), 2.0**40).astype(np.int64)

    def centers(self, cells: ArrayLike) -> Array:
        """Centres `(N, 2)` in the map frame of cells `(N, 2)` given as [row, col]."""
        index = number_array(cells, "cells", (None, 2), "[row, col] cells", _FAR, MapError)
        return self.to_map((index[:, ::-1] + 0.5) * self.resolution)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points `(N, 2)` of the map frame lie on the map, `(N,)`; False for nan."""
        array = number_array(points, "points", (None, 2), "points (N, 2) in m", np.nan, MapError)
        inside: NDArray[np.bool_] = np.asarray((np.abs(array) <= _FAR).all(axis=1))
        local = self.to_local(array[inside])
        inside[inside] = (local >= 0.0).all(axis=1) & (local <= self.size).all(axis=1)
        return inside

    def with_shapes(self, shapes: Iterable[Shape]) -> OccupancyMap:
        """This map with every cell occupied that one of the shapes (map frame) touches."""
        shapes = instances_of(shapes, Shape, "shapes", "a list of Box, Circle or Polygon")
        touched = rasterise(shapes, self.rows, self.cols, self.resolution, self.origin)
        return replace(self, grid=np.where(touched, np.int8(OCCUPIED), self.grid))

    def despeckled(self, size: float) -> OccupancyMap:
        """This map without specks: small groups of obstacle cells become free.

        Mapping leaves single cells and clusters of a few where nothing stands. A group are cells
        that touch each other at sides or corners; where unknown counts as occupied, these belong
        to it. Groups at the border stay, as what lies beyond is occupied.

        Args:
            size: Groups that fit into a square of this side, along the map's axes, are specks, m.

        Raises:
            MapError: The size is negative or not finite.
        """
        side = _finite(size, "size")
        if side < 0.0:
            raise MapError("expected a length that is not negative", key="size")
        cells = math.floor(side / self.resolution + 1e-6)
        if cells < 1:
            return self
        from scipy.ndimage import find_objects, label

        groups = label(np.pad(self.occupied, 1, constant_values=True), np.ones((3, 3)))[0]
        boxes = find_objects(groups)
        small = np.zeros(len(boxes) + 1, dtype=bool)
        for number, (rows, cols) in enumerate(boxes, start=1):
            small[number] = max(rows.stop - rows.start, cols.stop - cols.start) <= cells
        specks = small[groups[1:-1, 1:-1]] & self.occupied
        # A map of one cell is as small as a speck, but at its border.
        specks &= groups[1:-1, 1:-1] != groups[0, 0]
        return replace(self, grid=np.where(specks, np.int8(FREE), self.grid))

    def __repr__(self) -> str:
        return (
            f"OccupancyMap({self.rows} x {self.cols} cells of {self.resolution:g} m, "
            f"origin={self.origin}, unknown={self.unknown!r})"
        )


def check_cell_count(rows: int, cols: int, *, file: str | None = None, key: str = "grid") -> None:
    """Refuse a map without cells or with more than `MAX_CELLS`, before memory is taken for it."""
    if rows < 1 or cols < 1:
        raise MapError(f"a map of {rows} x {cols} cells has no ground", file=file, key=key)
    if rows * cols > MAX_CELLS:
        raise MapError(
            f"{rows} x {cols} cells are too many, at most {MAX_CELLS / 1e6:g} million are allowed",
            file=file,
            key=key,
        )


def checked_resolution(value: object) -> float:
    """`value` as a positive, finite float, m per cell."""
    number = _finite(value, "resolution")
    if not 1e-4 <= number <= 1e4:
        raise MapError("expected metres per cell between 0.0001 and 10000", key="resolution")
    return number


def checked_origin(value: object) -> tuple[float, float, float]:
    """`value` as a finite pose x, y, yaw."""
    try:
        parts = [_finite(part, "origin") for part in value]  # type: ignore[attr-defined]
    except TypeError:
        parts = []
    if len(parts) != 3:
        raise MapError("expected three numbers: x, y, yaw", key="origin")
    if max(abs(part) for part in parts) > MAX_EXTENT:
        raise MapError(f"expected numbers within ±{MAX_EXTENT:g}", key="origin")
    return parts[0], parts[1], parts[2]


def grid_shape(size: ArrayLike, resolution: float) -> tuple[int, int]:
    """Whole rows and columns in a world of `size` (width, height) m."""
    try:
        width, height = (_finite(side, "size") for side in np.asarray(size).tolist())
    except (TypeError, ValueError):
        raise MapError("expected two numbers: width, height", key="size") from None
    if not 0.0 < width <= MAX_EXTENT or not 0.0 < height <= MAX_EXTENT:
        raise MapError(f"expected positive lengths up to {MAX_EXTENT:g} m", key="size")
    # 14.0 / 0.05 falls just short of 280 in floating point.
    rows, cols = (math.floor(side / resolution + 1e-6) for side in (height, width))
    check_cell_count(rows, cols, key="size")
    return rows, cols


def _finite(value: object, key: str) -> float:
    number = plain_number(value, key, MapError)
    if not math.isfinite(number):
        raise MapError("expected a finite number", key=key)
    return number


def _checked_grid(grid: object) -> NDArray[np.int8]:
    """An own, read-only int8 copy of the occupancy values."""
    try:
        given: Any = np.ma.asarray(grid)
    except ValueError:
        raise MapError("rows differ in length", key="grid") from None
    if given.ndim != 2:
        raise MapError(f"expected two dimensions (rows, cols), not {given.ndim}", key="grid")
    check_cell_count(*given.shape)
    array = np.asarray(given.filled(0))
    if array.dtype == bool:
        result = np.where(array, np.int8(OCCUPIED), np.int8(FREE))
    elif np.issubdtype(array.dtype, np.integer):
        if array.min() < UNKNOWN or array.max() > OCCUPIED:
            raise MapError("occupancy values must lie between -1 and 100", key="grid")
        result = array.astype(np.int8)
    else:
        raise MapError(f"expected integers or bool, not {array.dtype}", key="grid")
    result[np.ma.getmaskarray(given)] = UNKNOWN
    result.setflags(write=False)
    return result
