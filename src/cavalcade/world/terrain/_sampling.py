"""Values of a grid between its cells' centres."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def sample(field, cell, x, y):
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


@njit(cache=True)
def sample_many(field, cell, points, out):
    """`sample` at points `(N, 2)` x, y into `out` `(N,)`."""
    for k in range(points.shape[0]):
        out[k] = sample(field, cell, points[k, 0], points[k, 1])


@njit(cache=True)
def resample(field, step, out, cell, x0, y0):
    """Fill `out` `(rows, cols)` of cells `cell` from a grid of samples `step` apart.

    Args:
        field: Samples; [0, 0] stands at (0, 0), not at a cell's centre.
        step: Distance of two samples, m.
        out: Filled; cell [0, 0]'s lower-left corner lies at (x0, y0).
        cell: Side of its cells, m.
        x0, y0: m.
    """
    for row in range(out.shape[0]):
        for col in range(out.shape[1]):
            x = x0 + (col + 0.5) * cell
            y = y0 + (row + 0.5) * cell
            out[row, col] = sample(field, step, x + 0.5 * step, y + 0.5 * step)


@njit(cache=True)
def block_means(field, size, out):
    """Fill `out` with the means of blocks of `size` x `size` values; nan where one is."""
    for row in range(out.shape[0]):
        for col in range(out.shape[1]):
            total = 0.0
            for i in range(row * size, (row + 1) * size):
                for j in range(col * size, (col + 1) * size):
                    total += field[i, j]
            out[row, col] = total / (size * size)
