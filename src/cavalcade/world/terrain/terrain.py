"""Ground with heights: a grid of layers with its place in the map frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.errors import MapError
from cavalcade.geometry import Array
from cavalcade.kernels import kernel, subroutine
from cavalcade.values import instance_of, plain_number, real_array
from cavalcade.world.occupancy import MAX_EXTENT, OccupancyMap, PlacedGrid, checked_origin
from cavalcade.world.terrain.filters import make_layers

RESOLUTION = 0.05
"""Side of a terrain's cells unless another one is asked for, m."""

FINEST, COARSEST = 0.02, 0.2
"""Cells that the filters make sense on, m: they fit planes to what lies within 0.15 m."""

MAX_CELLS = 4_000_000
"""Largest terrain that is accepted, in cells: 100 m x 100 m at 0.05 m."""

MAX_HEIGHT = 1e4
"""Largest magnitude of a height, m."""

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Terrain(PlacedGrid):
    """Heights of the ground and what legs need to know of it; arrays are read-only.

    Grids are indexed `[row, col]` = `[y, x]` with row 0 at the lowest y; a value stands at its
    cell's centre. `Terrain.from_heights` makes the layers of heights alone.

    Attributes:
        height: `(rows, cols)` m; finite everywhere: in pits their bottom, where nothing was known
            what spans it.
        smooth: `(rows, cols)` m, the smoothed height, which goes over holes and pits.
        normals: `(rows, cols, 3)` upward unit normals of `smooth`, along the grid's own axes.
        traversability: `(rows, cols)` from 0 (in or beside a hole) to 1 (level and smooth).
        resolution: Side of a cell, m.
        origin: Pose (x m, y m, yaw rad) of the lower-left corner of cell [0, 0] in the map frame.

    Raises:
        MapError: Layers of different or impossible shape, values that are not finite or out of
            range, or too many cells.
    """

    height: Array
    smooth: Array
    normals: Array
    traversability: Array
    resolution: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    _cells = "height"

    def __post_init__(self) -> None:
        object.__setattr__(self, "resolution", checked_cell(self.resolution))
        object.__setattr__(self, "origin", checked_origin(self.origin))
        height = _layer(self.height, "height", 2)
        check_terrain_size(*height.shape)
        if max(height.shape) * self.resolution > MAX_EXTENT:
            raise MapError(f"the terrain is longer than {MAX_EXTENT:g} m", key="resolution")
        for name in ("height", "smooth", "normals", "traversability"):
            layer = _layer(getattr(self, name), name, 3 if name == "normals" else 2)
            wanted = (*height.shape, 3) if name == "normals" else height.shape
            if layer.shape != wanted:
                raise MapError(f"expected {wanted}, not {layer.shape}", key=name)
            object.__setattr__(self, name, layer)
        if np.abs(self.height).max() > MAX_HEIGHT:
            raise MapError(f"expected heights within ±{MAX_HEIGHT:g} m", key="height")
        low, high = self.traversability.min(), self.traversability.max()
        if low < 0.0 or high > 1.0 + _ROUNDING:
            raise MapError("expected values from 0 to 1", key="traversability")

    @classmethod
    def from_heights(
        cls,
        heights: ArrayLike,
        resolution: float = RESOLUTION,
        origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> Terrain:
        """The terrain of raw heights.

        Args:
            heights: `(rows, cols)` m; nan, or a mask, in holes and where nothing is known:
                spanned from around, and no foot may stand there.
            resolution: Side of a cell, m.
            origin: Pose of the lower-left corner of cell [0, 0].

        Raises:
            MapError: No grid of at least 2 x 2 cells, nothing but nan, something infinite or too
                high, or too many cells.
        """
        cell = checked_cell(resolution)
        raw = checked_heights(heights)
        check_terrain_size(*raw.shape)
        return cls(**make_layers(raw, cell), resolution=cell, origin=origin)

    @classmethod
    def from_map(cls, map: OccupancyMap) -> Terrain:
        """Level ground where no foot may stand in or beside what is occupied.

        Args:
            map: Whose cells are `FINEST` to `COARSEST` m wide; its grid is the terrain's.

        Raises:
            MapError: No cell is free, or cells of another size.
        """
        instance_of(map, OccupancyMap, "map")
        heights = np.where(map.occupied, np.nan, 0.0)
        return cls.from_heights(heights, map.resolution, map.origin)

    def heights_at(self, points: ArrayLike) -> Array:
        """Heights `(N,)` in m at points `(N, 2)` of the map frame; beyond the edge that of it."""
        return self._sampled(self.height, points)

    def smooth_at(self, points: ArrayLike) -> Array:
        """Smoothed heights `(N,)` in m at points `(N, 2)` of the map frame."""
        return self._sampled(self.smooth, points)

    def traversability_at(self, points: ArrayLike) -> Array:
        """Traversability `(N,)` at points `(N, 2)` of the map frame."""
        return self._sampled(self.traversability, points)

    def in_hole(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points `(N, 2)` of the map frame lie in a cell that no foot may use, `(N,)`."""
        local = self.to_local(points)
        cells = np.floor(local[:, ::-1] / self.resolution).astype(np.int64)
        cells = np.clip(cells, 0, (self.rows - 1, self.cols - 1))
        hole: NDArray[np.bool_] = self.traversability[cells[:, 0], cells[:, 1]] <= 0.0
        return hole

    def _sampled(self, layer: Array, points: ArrayLike) -> Array:
        local = self.to_local(points)
        out = np.empty(len(local))
        sample_many(layer, self.resolution, local, out)
        return out

    def __repr__(self) -> str:
        return (
            f"Terrain({self.rows} x {self.cols} cells of {self.resolution:g} m, "
            f"{self.height.min():.2f} to {self.height.max():.2f} m high, origin={self.origin})"
        )


def checked_cell(value: object) -> float:
    """`value` as the side of a terrain's cells, m."""
    try:
        cell = plain_number(value, "resolution", MapError)
    except MapError:
        cell = np.nan
    if not FINEST <= cell <= COARSEST:
        raise MapError(
            f"expected cells of {FINEST:g} to {COARSEST:g} m for terrain", key="resolution"
        )
    return cell


def check_terrain_size(rows: int, cols: int, key: str = "heights") -> None:
    """Refuse grids too small for slopes or too large for memory."""
    if rows < 2 or cols < 2:
        raise MapError(f"{rows} x {cols} cells are no terrain; expected at least 2 x 2", key=key)
    if rows * cols > MAX_CELLS:
        raise MapError(
            f"{rows} x {cols} cells are too many, at most {MAX_CELLS / 1e6:g} million are allowed",
            key=key,
        )


def checked_heights(heights: ArrayLike) -> Array:
    """An own array `(rows, cols)` of heights, some finite, the others nan."""
    raw = _numbers(heights, "heights")
    if raw.ndim != 2:
        raise MapError(f"expected two dimensions (rows, cols), not {raw.ndim}", key="heights")
    if np.isinf(raw).any():
        raise MapError("expected finite heights or nan for holes", key="heights")
    if raw.size and np.isnan(raw).all():
        raise MapError("expected at least one height; all are nan", key="heights")
    if raw.size and np.nanmax(np.abs(raw)) > MAX_HEIGHT:
        raise MapError(f"expected heights within ±{MAX_HEIGHT:g} m", key="heights")
    return raw


def _layer(value: object, name: str, dimensions: int) -> Array:
    layer = _numbers(value, name)
    if layer.ndim != dimensions:
        raise MapError(f"expected {dimensions} dimensions, not {layer.ndim}", key=name)
    if not np.isfinite(layer).all():
        raise MapError("expected finite numbers", key=name)
    layer.setflags(write=False)
    return layer


def _numbers(value: object, key: str) -> Array:
    return np.array(real_array(value, key, "a grid of numbers", MapError))


@subroutine
def sample(field: Array, cell: float, x: float, y: float) -> float:
    """Bilinear value of a grid at one point.

    Args:
        field: `(rows, cols)`; a value stands at its cell's centre.
        cell: Side of a cell, m.
        x, y: m from the lower-left corner of cell [0, 0]. Points beyond the outermost centres
            take the value at the nearest point between them.
    """
    rows, cols = field.shape
    u = min(max(x / cell - 0.5, 0.0), cols - 1.0)
    v = min(max(y / cell - 0.5, 0.0), rows - 1.0)
    col = min(int(u), max(cols - 2, 0))
    row = min(int(v), max(rows - 2, 0))
    right, above = min(col + 1, cols - 1), min(row + 1, rows - 1)
    s, t = u - col, v - row
    low = field[row, col] + s * (field[row, right] - field[row, col])
    high = field[above, col] + s * (field[above, right] - field[above, col])
    return low + t * (high - low)


@kernel
def sample_many(field: Array, cell: float, points: Array, out: Array) -> None:
    """`sample` at points `(N, 2)` x, y into `out` `(N,)`."""
    for k in range(points.shape[0]):
        out[k] = sample(field, cell, points[k, 0], points[k, 1])
