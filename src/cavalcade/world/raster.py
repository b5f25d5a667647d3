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

Cells = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Overlap in m below which a shape does not occupy a cell."""


def rasterise(
    shapes: Iterable[Shape],
    rows: int,
    cols: int,
    resolution: float,
    origin: ArrayLike = (0.0, 0.0, 0.0),
) -> Cells:
    """Cells `(rows, cols)` that at least one of the shapes touches; clipped at the border.

    Args:
        shapes: In the map frame, m.
        rows, cols: Of the grid; cell [0, 0] is the one at the lowest y and x.
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


def _window(
    grid: Cells, bounds: tuple[float, ...], resolution: float
) -> tuple[Cells, Array, Array]:
    """The cells whose drawn-in squares the bounds touch, maybe none, and their centres.

    Returns:
        A view `(rows, cols)` of these cells, x `(1, cols)` and y `(rows, 1)` in the grid frame.
    """
    x_min, y_min, x_max, y_max = bounds
    # Closed squares [c * res + tol, (c + 1) * res - tol]: c >= (min + tol) / res - 1 and so on.
    row_0 = max(math.ceil((y_min + TOLERANCE) / resolution - 1.0), 0)
    col_0 = max(math.ceil((x_min + TOLERANCE) / resolution - 1.0), 0)
    row_1 = max(math.floor((y_max - TOLERANCE) / resolution) + 1, row_0)
    col_1 = max(math.floor((x_max - TOLERANCE) / resolution) + 1, col_0)
    view = grid[row_0:row_1, col_0:col_1]
    y = (np.arange(row_0, row_0 + view.shape[0], dtype=np.float64) + 0.5) * resolution
    x = (np.arange(col_0, col_0 + view.shape[1], dtype=np.float64) + 0.5) * resolution
    return view, x[None, :], y[:, None]


def _mark_circle(grid: Cells, circle: Circle, resolution: float) -> None:
    """A square touches a disc if its point nearest to the centre lies in it."""
    cells, x, y = _window(grid, circle.bounds, resolution)
    half = resolution / 2.0 - TOLERANCE
    dx = np.maximum(np.abs(x - circle.center[0]) - half, 0.0)
    dy = np.maximum(np.abs(y - circle.center[1]) - half, 0.0)
    cells |= dx * dx + dy * dy <= circle.radius**2


def _mark_box(grid: Cells, box: Box, resolution: float) -> None:
    """Separating axes: the window stands for the grid's two axes, the box adds its own two."""
    cells, x, y = _window(grid, box.bounds, resolution)
    dx, dy = x - box.center[0], y - box.center[1]
    c, s = math.cos(box.yaw), math.sin(box.yaw)
    reach = (resolution / 2.0 - TOLERANCE) * (abs(c) + abs(s))
    touched = np.abs(c * dx + s * dy) <= box.size[0] / 2.0 + reach
    touched &= np.abs(c * dy - s * dx) <= box.size[1] / 2.0 + reach
    cells |= touched


def _mark_polygon(grid: Cells, vertices: Array, resolution: float) -> None:
    """A square touches a polygon if an edge touches it or, if none does, its centre is inside."""
    cells, x, y = _window(grid, (*vertices.min(axis=0), *vertices.max(axis=0)), resolution)
    if not cells.size:
        return
    ends = np.roll(vertices, -1, axis=0)
    (ax, ay), (bx, by) = vertices.T, ends.T
    for row, height in enumerate(y[:, 0]):
        spans = (ay > height) != (by > height)
        share = (height - ay[spans]) / (by[spans] - ay[spans])
        crossings = np.sort(ax[spans] + share * (bx[spans] - ax[spans]))
        cells[row] |= np.searchsorted(crossings, x[0]) % 2 == 1
    for start, end in zip(vertices, ends, strict=True):
        _mark_segment(grid, start, end, resolution)


def _mark_segment(grid: Cells, start: Array, end: Array, resolution: float) -> None:
    """Separating axes: the window stands for the grid's two axes, the segment adds its normal."""
    bounds = (*np.minimum(start, end), *np.maximum(start, end))
    cells, x, y = _window(grid, bounds, resolution)
    nx, ny = start[1] - end[1], end[0] - start[0]
    reach = (resolution / 2.0 - TOLERANCE) * (abs(nx) + abs(ny))
    cells |= np.abs(nx * (x - start[0]) + ny * (y - start[1])) <= reach
