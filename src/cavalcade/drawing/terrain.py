"""The ground seen from above: heights shaded, where no foot may stand, what is solid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.actors import draw_arena
from cavalcade.drawing.plans.scene import PlanScene
from cavalcade.geometry import Array, transform_points
from cavalcade.locomotion.footholds import LEAST_TRAVERSABILITY
from cavalcade.world import Terrain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

_LEVEL = 0.02
"""Ground with less relief than this is drawn as level, m."""

_MOST_CELLS = 1200


def height_colours() -> Colormap:
    """Pale, so that paths stand out: from a cool grey-green to a warm sand."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list(
        "heights", ["#8fa7ad", "#b5c4b1", "#dcdcb8", "#ecdfc0", "#e3cdae", "#d6b797"]
    )


def draw_ground(axes: Axes, scene: PlanScene) -> Any:
    """Draw it; returns what a colour bar needs, None on flat ground."""
    shown = None if scene.terrain is None else draw_terrain(axes, scene.terrain)
    draw_arena(axes, scene.arena)
    return shown


def draw_terrain(axes: Axes, terrain: Terrain) -> Any:
    """Shaded heights in the map frame; returns what a colour bar needs, None on level ground."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.transforms import Affine2D

    stride = max(1, -(-max(terrain.rows, terrain.cols) // _MOST_CELLS))
    height = terrain.height[::stride, ::stride]
    cell = terrain.resolution * stride
    relief = float(np.ptp(height))
    low, high = float(height.min()), float(height.max())
    if relief < _LEVEL:
        low, high = low - 0.5 * _LEVEL, low + 0.5 * _LEVEL
    norm = Normalize(low, high)
    colours = height_colours()
    picture = colours(norm(height))
    picture[..., :3] *= _light(height, cell, relief)[..., None]
    picture[_blocked(terrain)[::stride, ::stride], :3] *= 0.62
    picture = np.clip(picture, 0.0, 1.0)
    x, y, yaw = terrain.origin
    place = Affine2D().rotate(yaw).translate(x, y) + axes.transData
    width, depth = height.shape[1] * cell, height.shape[0] * cell
    axes.imshow(
        picture,
        origin="lower",
        extent=(0.0, width, 0.0, depth),
        transform=place,
        interpolation="nearest",
        zorder=0.2,
    )
    if relief >= _LEVEL and min(height.shape) >= 2:
        _draw_contours(axes, height, cell, terrain.origin)
    return ScalarMappable(norm, colours) if relief >= _LEVEL else None


def _light(height: Array, cell: float, relief: float) -> Array:
    """Brightness `(rows, cols)`, 1 on level ground, lit from the upper left."""
    steeper = min(3.0, 0.6 / max(relief, 0.05))
    slope_y, slope_x = np.gradient(height * steeper, cell)
    towards = np.array([-0.54, 0.54, 0.64])
    lit = -slope_x * towards[0] - slope_y * towards[1] + towards[2]
    lit /= np.sqrt(1.0 + slope_x**2 + slope_y**2)
    return np.clip(1.0 + 0.7 * (lit - towards[2]), 0.55, 1.2)


def _blocked(terrain: Terrain) -> NDArray[np.bool_]:
    return terrain.traversability < LEAST_TRAVERSABILITY


def has_blocked_ground(scene: PlanScene) -> bool:
    """Whether there is ground, other than solid obstacles, where no foot may stand."""
    return scene.terrain is not None and bool(_blocked(scene.terrain).any())


def _draw_contours(
    axes: Axes, height: Array, cell: float, origin: tuple[float, float, float]
) -> None:
    from matplotlib.ticker import MaxNLocator

    rows, cols = height.shape
    x, y = np.meshgrid((np.arange(cols) + 0.5) * cell, (np.arange(rows) + 0.5) * cell)
    places = transform_points(origin, np.column_stack([x.ravel(), y.ravel()]))
    levels = MaxNLocator(nbins=7).tick_values(float(height.min()), float(height.max()))
    axes.contour(
        places[:, 0].reshape(rows, cols),
        places[:, 1].reshape(rows, cols),
        height,
        levels=levels,
        colors="#4a4a42",
        linewidths=0.3,
        alpha=0.55,
        zorder=0.3,
    )
