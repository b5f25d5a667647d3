"""The ground that bodies and feet are over: level, or with heights as their source says them.

Places are given in the map frame, m. Between the heights that its source gives, ground may lie
anywhere: whoever makes triangles or boxes of them stays within `range_at`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array, inverse_transform_points

_AROUND = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]], dtype=float)

STEEP, BENT = 0.8, 0.2
"""Steeper ground, and ground whose slope changes by more within a foot's width, is an edge."""

ROUNDING = 0.05
"""Of a force recorded as a mean while its foot rolls: rad."""

Origin = tuple[float, float, float]
Indices = NDArray[np.int64]


class Floor:
    """Level ground at height 0 that carries everywhere."""

    doubt = ROUNDING
    """How far a force may be turned against the ground's normal as it is known here, rad."""

    def heights_at(self, places: Array) -> Array:
        """Heights `(...)` in m at places `(..., 2)`."""
        return np.zeros(places.shape[:-1])

    def highest_at(self, places: Array, reach: float) -> Array:
        """The largest height `(...)` within about `reach` m of places `(..., 2)`."""
        return np.zeros(places.shape[:-1])

    def range_at(self, places: Array, reach: float = 0.0) -> tuple[Array, Array]:
        """Lowest and highest ground `(...)` within `reach` m of places `(..., 2)`, m."""
        zero = np.zeros(places.shape[:-1])
        return zero, zero

    def slope_at(self, places: Array, yaw: Array) -> Array:
        """Slope `(...)` of the smoothed height along headings `(...)` at places `(..., 2)`."""
        return np.zeros(places.shape[:-1])

    def best_at(self, places: Array) -> Array:
        """The kindest traversability `(...)` next to places `(..., 2)`."""
        return np.ones(places.shape[:-1])

    def normals_at(self, places: Array, reach: float) -> Array:
        """Unit vectors `(..., 3)` across the ground at places `(..., 2)`, seen `reach` m around."""
        return np.broadcast_to((0.0, 0.0, 1.0), (*places.shape[:-1], 3))

    def even_at(self, places: Array, reach: float) -> NDArray[np.bool_]:
        """Whether the ground around places `(..., 2)` has one normal: no edge and no wall."""
        return np.ones(places.shape[:-1], dtype=bool)


@dataclass(frozen=True, eq=False)
class Ground(Floor):
    """Layers of part of the ground.

    Attributes:
        cell, origin: As of `Heights`, of this part.
        height: `(rows, cols)` m, finite: holes without a height are filled from around.
        slope_x, slope_y: `(rows, cols)` of the smoothed height along the grid's axes.
        best: `(rows, cols)` the largest traversability in a cell and its eight neighbours.
    """

    # What counts as even has slopes that differ by so much below one foot.
    doubt = ROUNDING + BENT

    cell: float
    origin: Origin
    height: Array
    slope_x: Array
    slope_y: Array
    best: Array

    def heights_at(self, places: Array) -> Array:
        """Bilinear."""
        return _bilinear(self.height, self._cells(places))

    def highest_at(self, places: Array, reach: float) -> Array:
        """Of the place and of four others `reach` away."""
        return self.heights_at(places[..., None, :] + reach * _AROUND).max(axis=-1)

    def range_at(self, places: Array, reach: float = 0.0) -> tuple[Array, Array]:
        """Of the four cells around the place, and around four others `reach` away."""
        around = reach * _AROUND if reach else _AROUND[:1]
        cells = self._cells(places[..., None, :] + around)
        row, col, right, above = _around(self.height.shape, cells)[:4]
        four = np.stack(
            [self.height[r, c] for r, c in ((row, col), (row, right), (above, col), (above, right))]
        )
        return four.min(axis=(0, -1)), four.max(axis=(0, -1))

    def slope_at(self, places: Array, yaw: Array) -> Array:
        """Bilinear, of the slopes along the grid's axes."""
        cells, heading = self._cells(places), yaw - self.origin[2]
        x, y = _bilinear(self.slope_x, cells), _bilinear(self.slope_y, cells)
        return np.cos(heading) * x + np.sin(heading) * y

    def best_at(self, places: Array) -> Array:
        """Of the nearest cell."""
        cells = np.rint(self._cells(places)).astype(np.int64)
        rows, cols = self.best.shape
        return self.best[cells[..., 1].clip(0, rows - 1), cells[..., 0].clip(0, cols - 1)]

    def normals_at(self, places: Array, reach: float) -> Array:
        """From the heights before, behind, left and right; on an edge half way between."""
        slope = np.clip(self._slopes_around(places, reach), -STEEP, STEEP)
        normals = np.concatenate((-slope, np.ones((*slope.shape[:-1], 1))), axis=-1)
        return normals / np.linalg.norm(normals, axis=-1, keepdims=True)

    def even_at(self, places: Array, reach: float) -> NDArray[np.bool_]:
        """Where slopes seen nearby and from three times as far are gentle and about the same.

        They are so, too, before and behind, left and right of the place itself: a foot beside an
        edge sees half of it from near and from far.
        """
        near, far = self._slopes_around(places, reach), self._slopes_around(places, 3.0 * reach)
        size = np.maximum(np.abs(near), np.abs(far)).max(axis=-1)
        bend = np.maximum(self._bend_at(places, reach), self._bend_at(places, 2.0 * reach))
        bend = np.maximum(bend, np.abs(near - far).max(axis=-1))
        return (size < STEEP) & (bend < BENT)

    def _bend_at(self, places: Array, reach: float) -> Array:
        """Largest change `(...)` of the slope from one side of a place to the other."""
        heights = self.heights_at(places[..., None, :] + reach * _AROUND)
        sides = heights[..., 1::2] + heights[..., 2::2] - 2.0 * heights[..., :1]
        return np.abs(sides / reach).max(axis=-1)

    def _slopes_around(self, places: Array, reach: float) -> Array:
        heights = self.heights_at(places[..., None, :] + reach * _AROUND[1:])
        return (heights[..., ::2] - heights[..., 1::2]) / (2.0 * reach)

    def _cells(self, places: Array) -> Array:
        """Places in cells from the centre of cell [0, 0], x and y."""
        local = inverse_transform_points(self.origin, places.reshape(-1, 2))
        return local.reshape(places.shape) / self.cell - 0.5


def _around(
    shape: tuple[int, ...], cells: Array
) -> tuple[Indices, Indices, Indices, Indices, Array, Array]:
    """Row, column, next column, next row and fractions along x and y of the four cells around."""
    rows, cols = shape
    u = np.clip(cells[..., 0], 0.0, cols - 1.0)
    v = np.clip(cells[..., 1], 0.0, rows - 1.0)
    col = np.minimum(u.astype(np.int64), cols - 2)
    row = np.minimum(v.astype(np.int64), rows - 2)
    return row, col, col + 1, row + 1, u - col, v - row


def _bilinear(field: Array, cells: Array) -> Array:
    row, col, right, above, s, t = _around(field.shape, cells)
    low = field[row, col] * (1.0 - s) + field[row, right] * s
    high = field[above, col] * (1.0 - s) + field[above, right] * s
    return low * (1.0 - t) + high * t
