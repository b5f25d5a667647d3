"""Filters over height grids: filling, means and slopes within a radius."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


def disc(radius: float) -> NDArray[np.int64]:
    """Offsets `(K, 2)` (row, col) of the cells whose centres lie within `radius` cells."""
    reach = math.floor(radius + 1e-9)
    steps = np.arange(-reach, reach + 1)
    near = steps[:, None] ** 2 + steps**2 <= radius * radius + 1e-9
    return np.ascontiguousarray(np.argwhere(near) - reach)


@njit(cache=True)
def mean_within(field, offsets):
    """Mean over the cells at `offsets` that are on the grid, `(rows, cols)`."""
    rows, cols = field.shape
    out = np.empty((rows, cols))
    for row in range(rows):
        for col in range(cols):
            total, count = 0.0, 0
            for k in range(offsets.shape[0]):
                r, c = row + offsets[k, 0], col + offsets[k, 1]
                if 0 <= r < rows and 0 <= c < cols:
                    total += field[r, c]
                    count += 1
            out[row, col] = total / count
    return out


@njit(cache=True)
def any_within(mask, offsets):
    """Whether one of the cells at `offsets` is set, `(rows, cols)`."""
    rows, cols = mask.shape
    out = np.zeros((rows, cols), np.bool_)
    for row in range(rows):
        for col in range(cols):
            if mask[row, col]:
                for k in range(offsets.shape[0]):
                    r, c = row + offsets[k, 0], col + offsets[k, 1]
                    if 0 <= r < rows and 0 <= c < cols:
                        out[r, c] = True
    return out


@njit(cache=True)
def normals_within(field, offsets, cell):
    """Upward normals of the planes that fit the heights around each cell best, `(rows, cols, 3)`.

    Least squares in z over the cells at `offsets` that are on the grid; level in a direction
    that they don't span.
    """
    rows, cols = field.shape
    out = np.empty((rows, cols, 3))
    for row in range(rows):
        for col in range(cols):
            n, sx, sy, sz = 0, 0.0, 0.0, 0.0
            sxx, sxy, syy, sxz, syz = 0.0, 0.0, 0.0, 0.0, 0.0
            for k in range(offsets.shape[0]):
                r, c = row + offsets[k, 0], col + offsets[k, 1]
                if 0 <= r < rows and 0 <= c < cols:
                    x, y = offsets[k, 1] * cell, offsets[k, 0] * cell
                    z = field[r, c] - field[row, col]
                    n += 1
                    sx += x
                    sy += y
                    sz += z
                    sxx += x * x
                    sxy += x * y
                    syy += y * y
                    sxz += x * z
                    syz += y * z
            sxx -= sx * sx / n
            sxy -= sx * sy / n
            syy -= sy * sy / n
            sxz -= sx * sz / n
            syz -= sy * sz / n
            least = 1e-9 * cell * cell
            determinant = sxx * syy - sxy * sxy
            a, b = 0.0, 0.0
            if sxx > least and syy > least and determinant > least * least:
                a = (sxz * syy - syz * sxy) / determinant
                b = (syz * sxx - sxz * sxy) / determinant
            elif sxx > least:
                a = sxz / sxx
            elif syy > least:
                b = syz / syy
            length = math.sqrt(a * a + b * b + 1.0)
            out[row, col, 0] = -a / length
            out[row, col, 1] = -b / length
            out[row, col, 2] = 1.0 / length
    return out


@njit(cache=True)
def relax(field, cells, sweeps, tolerance):
    """Make the given cells the means of their neighbours, in place (Gauss-Seidel).

    Args:
        field: `(rows, cols)`.
        cells: `(K, 2)` row, col of the cells that may change.
        sweeps: How often at most.
        tolerance: Ends when no cell changes more, m.
    """
    rows, cols = field.shape
    for _ in range(sweeps):
        change = 0.0
        for k in range(cells.shape[0]):
            r, c = cells[k, 0], cells[k, 1]
            total, count = 0.0, 0
            if r > 0:
                total += field[r - 1, c]
                count += 1
            if r < rows - 1:
                total += field[r + 1, c]
                count += 1
            if c > 0:
                total += field[r, c - 1]
                count += 1
            if c < cols - 1:
                total += field[r, c + 1]
                count += 1
            if count > 0:
                mean = total / count
                change = max(change, abs(mean - field[r, c]))
                field[r, c] = mean
        if change <= tolerance:
            break
