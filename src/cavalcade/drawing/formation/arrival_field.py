"""The arrival-time field of the last goal with its contour lines and the driven paths."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.drawing.actors import draw_arena, draw_robot, set_ticks, set_view
from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array, inverse_transform_points, transform_points
from cavalcade.world import OccupancyMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from cavalcade.scenario import World

DEFAULT_SAFE_DISTANCE = 1.50
"""The paper's `d_safe_A` in m, where the scenario does not set another one."""

_BLOCKED = "#e9e6e1"
_LEFT, _RIGHT, _BOTTOM, _TOP, _BAR = 0.34, 0.42, 0.30, 0.05, 0.09


def arrival_field(scene: Scene, world: World, goal: Array, safe: float) -> tuple[Array, Array]:
    """Arrival times at `goal`, and the clearance they come from.

    Returns:
        `(rows, cols)` normalised seconds, inf where there is no way, and `(rows, cols)` m from a
        cell's centre to the nearest obstacle.

    The leader's field: speed rises from 0 at the inflated obstacles to 1 at `safe` m from them
    (Norén et al., section 2.2), as at the end of the run's first map; events change nothing.
    """
    from cavalcade import eikonal

    grid = world.map
    # Ground beyond the border counts as occupied.
    padded = np.pad(np.asarray(grid.occupied), 1, constant_values=True)
    surface = eikonal.surface_distance(padded, grid.resolution)[1:-1, 1:-1]
    speed = np.clip((np.asarray(surface) - scene.radius) / safe, 0.0, 1.0)
    column, row = inverse_transform_points(grid.origin, goal[None, :2])[0] / grid.resolution
    source = (
        min(max(int(np.floor(row)), 0), grid.rows - 1),
        min(max(int(np.floor(column)), 0), grid.cols - 1),
    )
    times = np.asarray(eikonal.arrival_times(speed, [source], grid.resolution))
    return times, np.asarray(surface)


def draw_arrival_field(
    scene: Scene, world: World, path: Path, safe: float | None = None
) -> Path | None:
    """Draw it a column wide; None where the team never had a goal or none can be reached."""
    goals = [status.goal for status in scene.status if status.goal is not None]
    if not goals:
        return None
    goal = np.asarray(goals[-1], dtype=float)
    times, clearance = arrival_field(scene, world, goal, safe or DEFAULT_SAFE_DISTANCE)
    if np.isfinite(times).sum() < 2:
        return None
    view = scene.view()
    span = view[2:] - view[:2]
    with style.paper_style():
        room = style.COLUMN - _LEFT - _RIGHT
        width = min(room, 5.0 * float(span[0] / span[1]))
        height = width * float(span[1] / span[0])
        page, total = _LEFT + width + _RIGHT, _BOTTOM + height + _TOP
        figure = style.new_figure(page, total)
        axes = figure.add_axes((_LEFT / page, _BOTTOM / total, width / page, height / total))
        bar = figure.add_axes(
            ((_LEFT + width + 0.05) / page, _BOTTOM / total, _BAR / page, height / total)
        )
        mesh = _draw_field(axes, world.map, times, clearance, scene.radius, view)
        draw_arena(axes, scene.arena)
        _draw_paths(axes, scene)
        axes.plot(*goal[:2], marker="D", markersize=4.2, markerfacecolor="white",
                  markeredgecolor=style.INK, markeredgewidth=0.9, zorder=5.5)  # fmt: skip
        set_view(axes, view)
        set_ticks(axes, view, width)
        axes.set_xlabel("$x$ (m)", labelpad=1)
        axes.set_ylabel("$y$ (m)", labelpad=1)
        scale = figure.colorbar(mesh, cax=bar)
        scale.set_label(_bar_label(height), labelpad=2)
        scale.outline.set_linewidth(0.4)
        bar.tick_params(size=1.8, pad=1.5)
        return style.save(figure, path, dpi=400)


def _bar_label(inches: float) -> str:
    """What the bar shows, as long as it fits beside it."""
    if inches >= 1.6:
        return "arrival time (normalised s)"
    return "arrival time (s)" if inches >= 0.95 else "ETA (s)"


def _in_view(grid: OccupancyMap, view: Array) -> NDArray[np.bool_]:
    """`(rows, cols)`: the cells whose centres lie in the part that is shown."""
    rows, cols = np.mgrid[0 : grid.rows, 0 : grid.cols]
    local = np.column_stack([cols.ravel() + 0.5, rows.ravel() + 0.5]) * grid.resolution
    places = transform_points(grid.origin, local)
    inside = ((places >= view[:2]) & (places <= view[2:])).all(axis=1)
    return np.asarray(inside.reshape(grid.rows, grid.cols))


def _draw_field(
    axes: Axes, grid: OccupancyMap, times: Array, clearance: Array, radius: float, view: Array
) -> Any:
    """Shaded field and contour lines, on the map's own grid, turned with its origin."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.ticker import MaxNLocator
    from matplotlib.transforms import Affine2D

    # From light to dark in one hue, so that paths and print in grey stay readable.
    shades = LinearSegmentedColormap.from_list(
        "arrival", ["#fdfdf6", "#d9ead3", "#9ccfc4", "#5aa7b5", "#33719b", "#27406f"]
    )
    seen = np.isfinite(times) & _in_view(grid, view)
    # The last few cells before a wall take for ever: they would eat up the whole scale.
    highest = float(np.quantile(times[seen if seen.any() else np.isfinite(times)], 0.97)) or 1.0
    shown = np.ma.masked_invalid(times)
    x, y, yaw = (float(value) for value in grid.origin)
    place = Affine2D().rotate(yaw).translate(x, y) + axes.transData
    width, height = grid.size
    mesh = axes.imshow(
        shown,
        origin="lower",
        extent=(0.0, width, 0.0, height),
        cmap=shades,
        vmin=0.0,
        vmax=highest,
        interpolation="nearest",
        transform=place,
        zorder=0.2,
    )
    levels = MaxNLocator(nbins=14, steps=[1, 2, 2.5, 5, 10]).tick_values(0.0, highest)
    columns = (np.arange(grid.cols) + 0.5) * grid.resolution
    rows = (np.arange(grid.rows) + 0.5) * grid.resolution
    # Beside the inflated obstacles the speed vanishes and all contour lines run together.
    steep = clearance < radius + 2.0 * grid.resolution
    axes.contour(
        columns,
        rows,
        np.ma.masked_where(steep, shown),
        levels=[level for level in levels if 0.0 < level <= highest],
        colors=style.INK,
        linewidths=0.35,
        alpha=0.55,
        transform=place,
        zorder=0.6,
    )
    edge = radius + 0.5 * grid.resolution
    if (clearance < edge).any():
        axes.contourf(columns, rows, clearance, levels=[-1.0, edge], colors=[_BLOCKED],
                      transform=place, zorder=0.7)  # fmt: skip
    axes.set_facecolor(_BLOCKED)
    return mesh


def _draw_paths(axes: Axes, scene: Scene) -> None:
    from matplotlib.patheffects import Normal, withStroke

    halo = [withStroke(linewidth=2.0, foreground="white"), Normal()]
    for robot in range(scene.size):
        color = style.robot_color(robot)
        line = scene.poses[:, robot]
        axes.plot(*line[:, :2].T, color=color, linewidth=1.0, zorder=4, path_effects=halo)
        draw_robot(axes, line[-1], scene.models[robot], color)
        axes.plot(*line[0, :2], marker="o", markersize=3.2, markerfacecolor="white",
                  markeredgecolor=color, markeredgewidth=0.9, zorder=5)  # fmt: skip
