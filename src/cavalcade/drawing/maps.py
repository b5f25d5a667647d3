"""The arena seen from above on axes to scale; all lengths in m, map frame."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.drawing.outlines import shape_ring
from cavalcade.drawing.scene import Team
from cavalcade.geometry import Array
from cavalcade.locomotion.footholds import LEAST_TRAVERSABILITY
from cavalcade.recording.frames import ObstacleTrack
from cavalcade.world import Terrain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import Transform

_LEVEL = 0.02
"""Ground with less relief than this is drawn as level, m."""

_MOST_CELLS = 1200


def map_figure(
    view: Array,
    margins: style.Margins,
    widest: float,
    tallest: float,
    *,
    scale: float = 0.0,
    narrowest: float = 0.0,
) -> tuple[Figure, Axes]:
    """A figure of one map's part `view`, as large as fits; lengths in inches.

    The figure is `narrowest` (titles need room, too) to `widest` wide, the map up to `tallest`
    high, with room for a `scale` on its right.
    """
    aspect = float((view[3] - view[1]) / (view[2] - view[0]))
    left, right, bottom, top = margins
    width = min(widest - left - right - scale, tallest / aspect)
    page = max(left + width + right + scale, narrowest)
    figure = style.new_figure(page, bottom + width * aspect + top)
    return figure, add_map(figure, left, bottom, width, view)


def add_map(
    figure: Figure, left: float, bottom: float, width: float, view: Array, *, first: bool = True
) -> Axes:
    """Axes of that width in inches that show the part `view` to scale; `first` of their row."""
    from matplotlib.ticker import MaxNLocator

    span = view[2:] - view[:2]
    axes = style.add_panel(figure, left, bottom, width, width * float(span[1] / span[0]))
    axes.set_xlim(view[0], view[2])
    axes.set_ylim(view[1], view[3])
    axes.set_aspect("equal", adjustable="box")
    # The same round steps on both axes; labels of neighbouring panels keep their distance.
    most = max(2, min(8, int(width / 0.3)))
    longest = float(span.max()) if span[0] >= 0.5 * span[1] else float(2.0 * span[0])
    steps = MaxNLocator(nbins=most, steps=[1, 2, 5, 10]).tick_values(0.0, longest)
    step = float(steps[1] - steps[0])
    for axis, (low, high) in enumerate(zip(view[:2], view[2:], strict=True)):
        ticks = np.arange(np.ceil(low / step - 1e-6), np.floor(high / step + 1e-6) + 1) * step
        if axis == 0 and not first:
            ticks = ticks[ticks > low + 0.06 * span[0]]
        (axes.set_xticks, axes.set_yticks)[axis](ticks)
    axes.set_xlabel("$x$ (m)", labelpad=1)
    if first:
        axes.set_ylabel("$y$ (m)", labelpad=1)
    return axes


def points_per_metre(axes: Axes) -> float:
    """How many points of the page a metre takes."""
    low, high = axes.get_xlim()
    return 72.0 * axes.bbox.width / axes.figure.dpi / (high - low)


def add_scale(figure: Figure, axes: Axes, shown: Any, label: str) -> None:
    """A bar on the right that tells what the colours of `shown` mean."""
    box, page = axes.get_position(), figure.get_figwidth()
    bar = figure.add_axes((box.x1 + 0.05 / page, box.y0, 0.09 / page, box.height))
    scale = figure.colorbar(shown, cax=bar)
    scale.set_label(label, labelpad=2)
    scale.outline.set_linewidth(0.4)
    bar.tick_params(size=1.8, pad=1.5)


def add_polygon(axes: Axes, ring: Array, **options: Any) -> None:
    """The polygon whose corners `(K, 2)` are given, not closed."""
    from matplotlib.patches import Polygon

    axes.add_patch(Polygon(ring, **options))


def grid_transform(axes: Axes, origin: tuple[float, float, float]) -> Transform:
    """From a grid's own frame to the page."""
    from matplotlib.transforms import Affine2D

    x, y, yaw = (float(value) for value in origin)
    return Affine2D().rotate(yaw).translate(x, y) + axes.transData


def draw_arena(axes: Axes, team: Team, *, heights: bool = True) -> Any:
    """The ground with its border, terrain, unknown cells, walls and lasting shapes.

    Returns what a scale of heights needs; None on level ground.
    """
    from matplotlib.collections import PolyCollection

    terrain, border, (walls, unknown) = team.world.terrain, team.border, team.rings
    shown = None if terrain is None or not heights else _draw_terrain(axes, terrain)
    _fill_rings(axes, unknown, facecolor=style.UNKNOWN, edgecolor="none", zorder=0.5)
    _fill_rings(axes, walls, facecolor=style.WALL, edgecolor=style.WALL, linewidth=0.2, zorder=1)
    # Edges below, fills above: shapes that overlap show one common outline.
    look: Any = {"facecolors": "none", "edgecolors": style.INK, "linewidths": 0.7, "zorder": 1.05}
    axes.add_collection(PolyCollection(team.outlines, **look), autolim=False)
    look = {"facecolors": style.SHAPE, "edgecolors": "none", "zorder": 1.1}
    axes.add_collection(PolyCollection(team.outlines, **look), autolim=False)
    add_polygon(axes, border, fill=False, edgecolor=style.INK, linewidth=0.9, zorder=1.2)
    return shown


def _fill_rings(axes: Axes, rings: Iterable[Array], **options: Any) -> None:
    """Fill rings `(K, 2)` together, so that clockwise ones are holes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    paths = [Path(np.concatenate([ring, ring[:1]]), closed=True) for ring in rings]
    if paths:
        axes.add_patch(PathPatch(Path.make_compound_path(*paths), **options))


def draw_tracks(axes: Axes, tracks: Iterable[ObstacleTrack], time: float) -> None:
    """Obstacles of events as they stand at that time, with the way they came."""
    for track in tracks:
        if not track.start <= time < track.end:
            continue
        ring, offset = shape_ring(track.solid), track.offset_at(time)
        add_polygon(
            axes,
            ring + offset,
            facecolor="#d9b8a5",
            edgecolor=style.MOVER,
            linewidth=0.6,
            hatch="//////",
            zorder=1.15,
        )
        travelled = track.offset[track.time <= time]
        if len(travelled) > 1:
            way = ring.mean(axis=0) + np.vstack([travelled, offset])
            axes.plot(*way.T, color=style.MOVER, linewidth=0.6, linestyle=":", zorder=1.14)


def _draw_terrain(axes: Axes, terrain: Terrain) -> Any:
    """Shaded heights, from a cool grey-green to a warm sand, so pale that paths stand out."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize
    from matplotlib.ticker import MaxNLocator

    stride = max(1, -(-max(terrain.rows, terrain.cols) // _MOST_CELLS))
    height = terrain.height[::stride, ::stride]
    cell = terrain.resolution * stride
    relief = float(np.ptp(height))
    low, high = float(height.min()), float(height.max())
    if relief < _LEVEL:
        low, high = low - 0.5 * _LEVEL, low + 0.5 * _LEVEL
    norm = Normalize(low, high)
    colours = LinearSegmentedColormap.from_list(
        "heights", ["#8fa7ad", "#b5c4b1", "#dcdcb8", "#ecdfc0", "#e3cdae", "#d6b797"]
    )
    picture = colours(norm(height))
    picture[..., :3] *= _light(height, cell, relief)[..., None]
    picture[_blocked(terrain)[::stride, ::stride], :3] *= 0.62
    rows, cols = height.shape
    place = grid_transform(axes, terrain.origin)
    axes.imshow(
        np.clip(picture, 0.0, 1.0),
        origin="lower",
        extent=(0.0, cols * cell, 0.0, rows * cell),
        transform=place,
        interpolation="nearest",
        zorder=0.2,
    )
    if relief < _LEVEL:
        return None
    if min(rows, cols) >= 2:
        axes.contour(
            (np.arange(cols) + 0.5) * cell,
            (np.arange(rows) + 0.5) * cell,
            height,
            levels=MaxNLocator(nbins=7).tick_values(low, high),
            colors="#4a4a42",
            linewidths=0.3,
            linestyles="solid",  # below zero, too
            alpha=0.55,
            transform=place,
            zorder=0.3,
        )
    return ScalarMappable(norm, colours)


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


def has_blocked_ground(terrain: Terrain | None) -> bool:
    """Whether there is ground, other than solid obstacles, where no foot may stand."""
    return terrain is not None and bool(_blocked(terrain).any())
