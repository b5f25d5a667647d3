"""Raw heights of the ground, and what follows from them for legs, computed on its own.

The constants are those of the method (Norby et al., 2022: the filters of Quad-SDK); the way they
are applied is not the planner's, so values near edges differ a little: those who ask allow for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.ground import Floor, Ground, Origin
from cavalcade.errors import InputError, RecordingError
from cavalcade.geometry import Array, inverse_transform_points
from cavalcade.scenario import Scenario, build_world

SMOOTH, STEEP, LEVEL = 0.2, 0.15, 0.4
"""Radii in m of the smoothed height, of the fit that judges slopes, and of that to the smoothed
height, along which bodies are pitched."""

ROUGHNESS, SLOPE, LEAST = 0.1, 0.4, 0.02
"""Roughness in m and slope in rad that forbid half each, and what is left of the worst ground."""

HOLE = 0.075
"""Feet keep this distance from holes, m."""

PIT_DEPTH, PIT_WIDTH = 0.5, 1.25
"""Ground this far below what is around it, and narrower than that, is a hole, m."""

_MARGIN = 1.5
"""Around the places asked for, m: further than any of the above reaches."""


@dataclass(frozen=True, eq=False)
class Heights:
    """A grid of heights as its source says it.

    Attributes:
        height: `(rows, cols)` m, `[row, col]` = `[y, x]`, at the centres of cells; nan where the
            source has none.
        cell: Side of a cell, m.
        origin: Pose (x, y, yaw) of the lower left corner of cell [0, 0] in the map frame.
        holes: `(rows, cols)` cells that are known to be holes; None if only nan tells.
    """

    height: Array
    cell: float
    origin: Origin = (0.0, 0.0, 0.0)
    holes: NDArray[np.bool_] | None = None

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the grid, m."""
        rows, cols = self.height.shape
        return cols * self.cell, rows * self.cell


def read_heights(scenario: Scenario) -> Heights | None:
    """The raw heights of a scenario's ground; None where it is level.

    Of the world that the scenario makes only the heights are used, and where it has none:
    smoothing, slopes, pits and traversability are the checker's own.

    Raises:
        RecordingError: They cannot be made.
    """
    if not scenario.world.has_heights:
        return None
    try:
        terrain = build_world(scenario).terrain
    except InputError as error:
        raise RecordingError(str(error)) from error
    if terrain is None:
        return None
    from scipy.ndimage import binary_erosion

    # The world tells holes with the margin that feet keep from them; here that is taken off.
    margin = disc(HOLE / terrain.resolution)
    holes = binary_erosion(terrain.traversability <= 0.0, margin, border_value=1)
    return Heights(terrain.height, terrain.resolution, terrain.origin, holes)


def floor_of(heights: Heights | None, places: Array) -> Floor:
    """The ground around places `(N, 2)` of the map frame; level without heights."""
    if heights is None:
        return Floor()
    rows, cols = heights.height.shape
    local = inverse_transform_points(heights.origin, places) / heights.cell
    margin = int(np.ceil(_MARGIN / heights.cell))
    low = np.floor(local.min(axis=0)).astype(np.int64) - margin
    high = np.ceil(local.max(axis=0)).astype(np.int64) + margin
    x0, y0 = int(np.clip(low[0], 0, cols - 2)), int(np.clip(low[1], 0, rows - 2))
    x1, y1 = int(np.clip(high[0], x0 + 2, cols)), int(np.clip(high[1], y0 + 2, rows))
    part = heights.height[y0:y1, x0:x1]
    holes = np.isnan(part)
    if heights.holes is not None:
        holes = holes | heights.holes[y0:y1, x0:x1]
    x, y, yaw = heights.origin
    dx, dy = x0 * heights.cell, y0 * heights.cell
    corner = (x + np.cos(yaw) * dx - np.sin(yaw) * dy, y + np.sin(yaw) * dx + np.cos(yaw) * dy)
    origin = (float(corner[0]), float(corner[1]), yaw)
    return _layers(part, holes, heights.cell, origin)


def _layers(raw: Array, holes: NDArray[np.bool_], cell: float, origin: Origin) -> Ground:
    from scipy.ndimage import binary_dilation, maximum_filter

    height = _filled(raw, np.isnan(raw))
    holes = holes | _pits(height, cell)
    over = _filled(height, holes)
    around = disc(SMOOTH / cell).astype(float)
    smooth = _convolved(over, around / around.sum()) + over.mean()
    x, y = _slopes(over, STEEP / cell, cell)
    steep = np.arctan(np.hypot(x, y))
    along, across = _slopes(smooth, LEVEL / cell, cell)
    # Whether slopes are judged before or after smoothing is the planner's choice.
    steep = np.minimum(steep, np.arctan(np.hypot(along, across)))
    rough = np.abs(over - smooth)
    good = np.clip(0.5 * (1.0 - rough / ROUGHNESS) + 0.5 * (1.0 - steep / SLOPE), 0.0, None)
    good = np.minimum(good + LEAST, 1.0)
    if holes.any():
        good[binary_dilation(holes, disc(HOLE / cell))] = 0.0
    best = maximum_filter(good, size=3, mode="nearest")
    return Ground(cell, origin, height, along, across, best)


def _filled(height: Array, holes: NDArray[np.bool_]) -> Array:
    """Holes spanned from around: each cell in them the mean of its neighbours, roughly."""
    from scipy.ndimage import distance_transform_edt, uniform_filter

    if not holes.any() or holes.all():
        return np.nan_to_num(height, nan=0.0)
    nearest = distance_transform_edt(holes, return_distances=False, return_indices=True)
    out: Array = height[tuple(nearest)]
    for _ in range(60):
        out = np.where(holes, uniform_filter(out, 5, mode="nearest"), out)
    return out


def _pits(height: Array, cell: float) -> NDArray[np.bool_]:
    from scipy.ndimage import maximum_filter, minimum_filter

    if float(np.ptp(height)) < PIT_DEPTH:
        return np.zeros(height.shape, dtype=bool)
    width = 2 * round(PIT_WIDTH / cell / 2.0) + 1
    rim = minimum_filter(maximum_filter(height, width, mode="nearest"), width, mode="nearest")
    return rim - height >= PIT_DEPTH


def disc(radius: float) -> NDArray[np.bool_]:
    """The cells within `radius` cells of the middle one."""
    reach = int(radius + 1e-9)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    return x * x + y * y <= radius * radius + 1e-9


def _slopes(field: Array, radius: float, cell: float) -> tuple[Array, Array]:
    """Slopes along x and y of the planes that fit the discs around each cell best."""
    within = disc(radius)
    edge = within.shape[0] // 2
    if edge == 0:
        return np.zeros_like(field), np.zeros_like(field)
    steps = np.arange(-edge, edge + 1) * within * cell
    kernel = steps / (steps * steps).sum()
    # Convolution turns the kernel round.
    return _convolved(field, -kernel), _convolved(field, -kernel.T)


def _convolved(field: Array, kernel: Array) -> Array:
    """What differs from the field's mean, continued beyond its edges, times the kernel."""
    from scipy.signal import oaconvolve

    wide = np.pad(field - field.mean(), kernel.shape[0] // 2, mode="edge")
    return oaconvolve(wide, kernel, mode="valid")
