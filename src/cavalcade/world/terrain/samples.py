"""Heights as a file gives them, brought to a terrain's grid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cavalcade.errors import MapError
from cavalcade.geometry import Array
from cavalcade.world.terrain._sampling import block_means, resample
from cavalcade.world.terrain.filters import filled
from cavalcade.world.terrain.terrain import check_terrain_size, checked_heights

MAX_SAMPLES = 16_000_000
"""Most heights that are read from a file."""

Pose = tuple[float, float, float]


@dataclass(frozen=True)
class Samples:
    """Heights at even distances.

    Attributes:
        heights: `(rows, cols)` m, row 0 at the lowest y; nan in holes.
        step: Distance of two neighbours, m; None if the file does not say.
        corner: x, y in m of the lower-left corner of the ground; None if the file does not say.
        cells: Whether each height stands for a cell around it (as the pixels of a picture do);
            otherwise the ground ends at the outermost ones.
    """

    heights: Array
    step: float | None = None
    corner: tuple[float, float] | None = None
    cells: bool = True


def check_sample_count(rows: int, cols: int) -> None:
    """Refuse files with too many heights before memory is taken for them."""
    if rows * cols > MAX_SAMPLES:
        raise MapError(
            f"{rows} x {cols} heights are too many, at most {MAX_SAMPLES / 1e6:g} million are read"
        )


def to_grid(samples: Samples, cell: float, holes: bool = True) -> Array:
    """Heights `(rows, cols)` on cells of side `cell`; nan in holes unless they are to be filled.

    Finer samples are averaged first, then values are taken bilinearly; a cell is a hole where
    holes weigh half or more.

    Args:
        samples: With their `step`.
        cell: m.
        holes: Keep them.

    Raises:
        MapError: Too few, too many or no heights.
    """
    heights = checked_heights(samples.heights)
    if samples.step is None:
        raise MapError("is missing", key="resolution")
    step = samples.step
    unknown = np.isnan(heights)
    if samples.cells and abs(step - cell) <= 1e-9 * cell:
        check_terrain_size(*heights.shape)
        return heights if holes else filled(heights, unknown)
    last = 0 if samples.cells else 1
    width, length = (step * (count - last) for count in heights.shape[::-1])
    rows, cols = (math.floor(side / cell + 1e-6) for side in (length, width))
    check_terrain_size(rows, cols)
    low = 0.0  # of the ground, seen from the first sample or block
    solid = filled(heights, unknown)
    weight = unknown.astype(float)
    block = math.floor(cell / step + 1e-9)
    if block >= 2 and min(heights.shape) >= block:
        solid, weight = _means(solid, block), _means(weight, block)
        low = -0.5 * (block - 1) * step
        step *= block
    if samples.cells:
        low -= 0.5 * samples.step
    out = np.empty((rows, cols))
    resample(solid, step, out, cell, low, low)
    if holes and unknown.any():
        share = np.empty((rows, cols))
        resample(weight, step, share, cell, low, low)
        out[share >= 0.5] = np.nan
        if np.isnan(out).all():
            raise MapError("expected at least one height; all are nan", key="heights")
    return out


def _means(field: Array, block: int) -> Array:
    out = np.empty((field.shape[0] // block, field.shape[1] // block))
    block_means(np.ascontiguousarray(field), block, out)
    return out
