"""The arrival-time field of the last goal with its contour lines and the driven paths."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import draw_driven, draw_robot, draw_team_goal
from cavalcade.drawing.maps import add_scale, draw_arena, grid_transform, map_figure
from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DEFAULT_SAFE_DISTANCE = 1.50
"""The paper's `d_safe_A` in m, where the scenario does not set another one."""

_BLOCKED = "#e9e6e1"
_MARGINS = style.Margins(left=0.34, right=0.50, bottom=0.30, top=0.05)


def arrival_field(scene: Scene, goal: Array) -> tuple[Array, Array]:
    """Arrival times `(rows, cols)` at `goal` in normalised seconds, inf where there is no way.

    Beside them the clearance they come from, `(rows, cols)` m from a cell's centre to the nearest
    obstacle.

    The leader's field: speed rises from 0 at the inflated obstacles to 1 at `d_safe_A` from them
    (Norén et al., section 2.2), as at the end of the run's first map; events change nothing.
    """
    from cavalcade import eikonal

    grid = scene.world.map
    safe = scene.scenario.planner.d_safe_a or DEFAULT_SAFE_DISTANCE
    # Ground beyond the border counts as occupied.
    padded = np.pad(np.asarray(grid.occupied), 1, constant_values=True)
    surface = eikonal.surface_distance(padded, grid.resolution)[1:-1, 1:-1]
    speed = np.clip((np.asarray(surface) - scene.radius) / safe, 0.0, 1.0)
    row, column = np.clip(grid.cell_of(goal[None, :2])[0], 0, (grid.rows - 1, grid.cols - 1))
    source = (int(row), int(column))
    times = np.asarray(eikonal.arrival_times(speed, [source], grid.resolution))
    return times, np.asarray(surface)


def draw_arrival_field(scene: Scene, path: Path) -> Path | None:
    """Draw it a column wide; None where the team never had a goal or none can be reached."""
    goals = [status.goal for status in scene.recording.status if status.goal is not None]
    if not goals:
        return None
    goal = np.asarray(goals[-1], dtype=float)
    times, clearance = arrival_field(scene, goal)
    if np.isfinite(times).sum() < 2:
        return None
    view = scene.view()
    with style.paper_style():
        figure, axes = map_figure(view, _MARGINS, style.COLUMN, 5.0)
        mesh = _draw_field(axes, scene, times, clearance, view)
        draw_arena(axes, scene, heights=False)
        _draw_paths(axes, scene)
        draw_team_goal(axes, goal)
        inches = axes.get_position().height * figure.get_figheight()
        # As long a label as fits beside the scale.
        label = "arrival time (normalised s)" if inches >= 1.3 else "arrival time (s)"
        add_scale(figure, axes, mesh, label if inches >= 0.95 else "ETA (s)")
        return style.save(figure, path, dpi=400)


def _draw_field(axes: Axes, scene: Scene, times: Array, clearance: Array, view: Array) -> Any:
    """Shaded field and contour lines, on the map's own grid, turned with its origin."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.ticker import MaxNLocator

    # From light to dark in one hue, so that paths and print in grey stay readable.
    shades = LinearSegmentedColormap.from_list(
        "arrival", ["#fdfdf6", "#d9ead3", "#9ccfc4", "#5aa7b5", "#33719b", "#27406f"]
    )
    grid, radius = scene.world.map, scene.radius
    places = grid.centers(np.indices((grid.rows, grid.cols)).reshape(2, -1).T)
    in_view = ((places >= view[:2]) & (places <= view[2:])).all(axis=1)
    seen = np.isfinite(times) & in_view.reshape(grid.rows, grid.cols)
    # The last few cells before a wall take for ever: they would eat up the whole scale.
    highest = float(np.quantile(times[seen if seen.any() else np.isfinite(times)], 0.97)) or 1.0
    shown = np.ma.masked_invalid(times)
    place = grid_transform(axes, grid.origin)
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
    for robot, model in enumerate(scene.models):
        color = style.robot_color(robot)
        line = scene.recording.poses[:, robot]
        draw_driven(axes, line, robot, linestyle="-", linewidth=1.0, zorder=4,
                    path_effects=style.halo(2.0))  # fmt: skip
        draw_robot(axes, line[-1], model, color)
        axes.plot(*line[0, :2], **style.mark("o", 3.2, color, 0.9), zorder=5)
