"""Exact rasters of shapes: a cell is occupied if and only if the shape touches it.

A cell is its closed square, drawn in by `TOLERANCE` on each side. A shape whose edge lies exactly
on a cell border therefore occupies the cells on its own side of the border only, however the
coordinates were rounded.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.geometry import Array, inverse_transform_points
from cavalcade.world.shapes import Box, Circle, Polygon, Shape

TOLERANCE = 1e-9
"""Overlap in m below which a shape does not occupy a cell."""

_Window = tuple[int, int, int, int]
"""Half-open rows and columns: row_0, row_1, col_0, col_1."""


def rasterise(
    shapes: Iterable[Shape],
    rows: int,
    cols: int,
    resolution: float,
    origin: ArrayLike = (0.0, 0.0, 0.0),
) -> NDArray[np.bool_]:
    """Cells `(rows, cols)` that at least one of the shapes touches; clipped at the border.

    Args:
        shapes: In the map frame, m.
        rows: Number of rows; row 0 is the one at the lowest y.
        cols: Number of columns; column 0 is the one at the lowest x.
        resolution: Side of a cell, m.
        origin: Pose (x, y, yaw) of the lower-left corner of cell [0, 0] in the map frame.
    """
    grid = np.zeros((rows, cols), dtype=bool)
    pose = np.asarray(origin, dtype=float)
    for shape in shapes:
        if isinstance(shape, Polygon):
            _mark_polygon(grid, inverse_transform_points(pose, shape.vertices), resolution)
            continue
        x, y = (float(v) for v in inverse_transform_points(pose, [shape.center])[0])
        if isinstance(shape, Circle):
            _mark_circle(grid, Circle((x, y), shape.radius), resolution)
        else:
            _mark_box(grid, Box((x, y), shape.size, shape.yaw - float(pose[2])), resolution)
    return grid


def _window(bounds: tuple[float, ...], shape: tuple[int, int], resolution: float) -> _Window | None:
    """The cells whose drawn-in squares the bounds touch; None if there are none."""
    x_min, y_min, x_max, y_max = bounds
    # Closed squares [c * res + tol, (c + 1) * res - tol]: c >= (min + tol) / res - 1 and so on.
    row_0 = max(math.ceil((y_min + TOLERANCE) / resolution - 1.0), 0)
    col_0 = max(math.ceil((x_min + TOLERANCE) / resolution - 1.0), 0)
    row_1 = min(math.floor((y_max - TOLERANCE) / resolution) + 1, shape[0])
    col_1 = min(math.floor((x_max - TOLERANCE) / resolution) + 1, shape[1])
    if row_0 >= row_1 or col_0 >= col_1:
        return None
    return row_0, row_1, col_0, col_1


def _cell_centres(window: _Window, resolution: float) -> tuple[Array, Array]:
    """Coordinates x `(1, cols)` and y `(rows, 1)` of the cell centres in the grid frame."""
    row_0, row_1, col_0, col_1 = window
    x = (np.arange(col_0, col_1, dtype=np.float64) + 0.5) * resolution
    y = (np.arange(row_0, row_1, dtype=np.float64) + 0.5) * resolution
    return x[None, :], y[:, None]


def _mark(grid: NDArray[np.bool_], window: _Window, touched: NDArray[np.bool_]) -> None:
    row_0, row_1, col_0, col_1 = window
    grid[row_0:row_1, col_0:col_1] |= touched


def _mark_circle(grid: NDArray[np.bool_], circle: Circle, resolution: float) -> None:
    """A square touches a disc if its point nearest to the centre lies in it."""
    window = _window(circle.bounds, grid.shape, resolution)
    if window is None:
        return
    x, y = _cell_centres(window, resolution)
    half = resolution / 2.0 - TOLERANCE
    dx = np.maximum(np.abs(x - circle.center[0]) - half, 0.0)
    dy = np.maximum(np.abs(y - circle.center[1]) - half, 0.0)
    _mark(grid, window, dx * dx + dy * dy <= circle.radius**2)


def _mark_box(grid: NDArray[np.bool_], box: Box, resolution: float) -> None:
    """Separating axes: the window stands for the grid's two axes, the box adds its own two."""
    window = _window(box.bounds, grid.shape, resolution)
    if window is None:
        return
    x, y = _cell_centres(window, resolution)
    dx, dy = x - box.center[0], y - box.center[1]
    c, s = math.cos(box.yaw), math.sin(box.yaw)
    reach = (resolution / 2.0 - TOLERANCE) * (abs(c) + abs(s))
    touched = np.abs(c * dx + s * dy) <= box.size[0] / 2.0 + reach
    touched &= np.abs(c * dy - s * dx) <= box.size[1] / 2.0 + reach
    _mark(grid, window, touched)


def _mark_polygon(grid: NDArray[np.bool_], vertices: Array, resolution: float) -> None:
    """A square touches a polygon if an edge touches it or, if none does, its centre is inside."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    window = _window((*low, *high), grid.shape, resolution)
    if window is None:
        return
    (ax, ay), (bx, by) = vertices.T, np.roll(vertices, -1, axis=0).T
    x, y = _cell_centres(window, resolution)
    inside = np.zeros((y.size, x.size), dtype=bool)
    for row, height in enumerate(y[:, 0]):
        spans = (ay > height) != (by > height)
        share = (height - ay[spans]) / (by[spans] - ay[spans])
        crossings = np.sort(ax[spans] + share * (bx[spans] - ax[spans]))
        inside[row] = np.searchsorted(crossings, x[0]) % 2 == 1
    _mark(grid, window, inside)
    for start, end in zip(vertices, np.roll(vertices, -1, axis=0), strict=True):
        _mark_segment(grid, start, end, resolution)


def _mark_segment(grid: NDArray[np.bool_], start: Array, end: Array, resolution: float) -> None:
    """Separating axes: the window stands for the grid's two axes, the segment adds its normal."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    window = _window((*low, *high), grid.shape, resolution)
    if window is None:
        return
    x, y = _cell_centres(window, resolution)
    nx, ny = start[1] - end[1], end[0] - start[0]
    reach = (resolution / 2.0 - TOLERANCE) * (abs(nx) + abs(ny))
    _mark(grid, window, np.abs(nx * (x - start[0]) + ny * (y - start[1])) <= reach)
