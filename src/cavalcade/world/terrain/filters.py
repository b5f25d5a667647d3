"""What legs need to know of heights: smoothed ground, normals, where feet may stand.

The filter chain of Quad-SDK (Norby et al., 2022), whose constants these are.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kernels import kernel

SMOOTH_RADIUS = 0.2
"""Of the mean that is the smoothed height, m."""

NORMAL_RADIUS = 0.15
"""Of the fit that judges how steep the ground is, m."""

SMOOTH_NORMAL_RADIUS = 0.4
"""Of the fit to the smoothed height, m."""

HOLE_RADIUS = 0.075
"""Feet keep this distance from holes, m."""

ROUGHNESS = 0.1
"""Difference from the smoothed height at which roughness alone forbids half, m."""

SLOPE = 0.4
"""Inclination at which it alone forbids half, rad."""

LEAST = 0.02
"""Traversability of the worst ground that is no hole."""

PIT_DEPTH = 0.5
"""Below the ground around it, m; deeper than legs reach."""

PIT_WIDTH = 1.25
"""Ground this wide or wider is ground of its own, however deep, m."""

Offsets = NDArray[np.int64]
"""`(K, 2)` row, col of cells, seen from another."""

_FILL_WORK = 100_000_000
"""Changes of cells that filling holes may take: some seconds."""


def make_layers(heights: Array, cell: float) -> dict[str, Array]:
    """The layers of a `Terrain` by name, of raw heights.

    Args:
        heights: `(rows, cols)` m; nan in a hole or where nothing is known. At least one is finite.
        cell: Side of a cell, m.

    Holes are the cells without a height and *pits*: narrow ground far below what is around it.
    The smoothed ground goes over holes as if they were filled, and no foot may stand in one or
    within `HOLE_RADIUS` of it. In pits `height` is their bottom, otherwise it is filled.
    """
    unknown = np.isnan(heights)
    height = filled(heights, unknown)
    pits = find_pits(height, cell)
    over = filled(height, pits) if pits.any() else height
    smooth = mean_within(over, disc(SMOOTH_RADIUS / cell))
    slope = np.arccos(normals_within(over, disc(NORMAL_RADIUS / cell), cell)[..., 2])
    rough = np.abs(over - smooth)
    ground = 0.5 * (1.0 - rough / ROUGHNESS) + 0.5 * (1.0 - slope / SLOPE)
    ground = np.minimum(np.maximum(ground, 0.0) + LEAST, 1.0)
    holes = unknown | pits
    if holes.any():
        from scipy.ndimage import distance_transform_edt

        away = distance_transform_edt(~holes)
        ground[away**2 <= (HOLE_RADIUS / cell) ** 2 + 1e-9] = 0.0
    normals = normals_within(smooth, disc(SMOOTH_NORMAL_RADIUS / cell), cell)
    return {"height": height, "smooth": smooth, "normals": normals, "traversability": ground}


def filled(heights: Array, holes: NDArray[np.bool_]) -> Array:
    """The heights with holes spanned smoothly: each cell the mean of its neighbours.

    Args:
        heights: `(rows, cols)` m.
        holes: `(rows, cols)` where they are not to be used; not everywhere.
    """
    if not holes.any():
        return heights.copy()
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(holes, return_distances=False, return_indices=True)
    out: Array = np.ascontiguousarray(heights[tuple(nearest)])
    cells = np.argwhere(holes)
    # Large holes start from what is nearest and are never smooth to the last millimetre.
    relax(out, cells, min(max(_FILL_WORK // len(cells), 20), 300), 1e-4)
    return out


def find_pits(height: Array, cell: float) -> NDArray[np.bool_]:
    """Cells `(rows, cols)` of narrow ground at least `PIT_DEPTH` below what is around it."""
    low, high = float(height.min()), float(height.max())
    if high - low < PIT_DEPTH:
        return np.zeros(height.shape, dtype=bool)
    from scipy.ndimage import grey_closing

    half = round(PIT_WIDTH / cell / 2.0)
    # Low ground all around: what lies between high ground and the border is no pit.
    wider = np.pad(height, 2 * half, constant_values=low)
    closed = grey_closing(wider, size=(2 * half + 1, 2 * half + 1))
    inner = slice(2 * half, -2 * half)
    deep: NDArray[np.bool_] = closed[inner, inner] - height >= PIT_DEPTH
    return deep


def disc(radius: float) -> Offsets:
    """Offsets `(K, 2)` (row, col) of the cells whose centres lie within `radius` cells."""
    reach = math.floor(radius + 1e-9)
    steps = np.arange(-reach, reach + 1)
    near = steps[:, None] ** 2 + steps**2 <= radius * radius + 1e-9
    return np.ascontiguousarray(np.argwhere(near) - reach)


@kernel
def mean_within(field: Array, offsets: Offsets) -> Array:
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


@kernel
def normals_within(field: Array, offsets: Offsets, cell: float) -> Array:
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


@kernel
def relax(field: Array, cells: NDArray[np.int64], sweeps: int, tolerance: float) -> None:
    """Make `cells` `(K, 2)` row, col the means of their neighbours, in place (Gauss-Seidel).

    Ends after so many sweeps, or when none changes by more than `tolerance` m.
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
