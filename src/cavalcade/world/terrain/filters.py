"""What legs need to know of heights: smoothed ground, normals, where feet may stand.

The filter chain of Quad-SDK (Norby et al., 2022), whose constants these are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.world.terrain._kernels import any_within, disc, mean_within, normals_within, relax

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
    ground[any_within(unknown | pits, disc(HOLE_RADIUS / cell))] = 0.0
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
