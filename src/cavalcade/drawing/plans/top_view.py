"""The plan seen from above, after the paper's Fig. 6: walking red, flight blue."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import draw_outline, draw_own_goal, draw_robot
from cavalcade.drawing.charts import draw_legend
from cavalcade.drawing.maps import (
    add_scale,
    draw_arena,
    has_blocked_ground,
    map_figure,
    points_per_metre,
)
from cavalcade.drawing.plans.motion import FLIES, STANDS, activities
from cavalcade.drawing.scene import PlanScene, runs
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARGINS = style.Margins(left=0.38, right=0.08, bottom=0.32, top=0.40)
_WAIT = style.mark("s", 3.0, style.INK, 0.6)
_LONG_WAIT = 0.5
"""Stands shorter than this on the way are not marked, s."""


def draw_top_view(scene: PlanScene, path: Path) -> Path:
    """Draw it as wide as a page or as high as fits; returns the file written."""
    scale = 0.0 if scene.world.terrain is None else 0.64
    with style.paper_style():
        figure, axes = map_figure(
            scene.view(), _MARGINS, style.PAGE, 6.4, scale=scale, narrowest=3.2
        )
        shown = draw_arena(axes, scene)
        if shown is not None:
            add_scale(figure, axes, shown, "height (m)")
        axes.set_title(scene.name, loc="left", pad=13)
        if not scene.plan.solved:
            axes.set_title(scene.result[:70], loc="right", pad=13, color=style.LIMIT, fontsize=7)
        _draw_paths(axes, scene)
        _draw_ends(axes, scene)
        _draw_legend(axes, scene)
        return style.save(figure, path)


def _draw_paths(axes: Axes, scene: PlanScene) -> None:
    """Paths with the robot's colour as their edge, and bodies at common moments."""
    many = scene.size > 8
    core, gap, edge = (0.8, 1.5, 2.3) if many else (1.2, 2.1, 3.3)
    moments = _moments(scene, points_per_metre(axes))
    dash: Any = "-" if scene.plan.solved else (0, (3, 1.5))
    for robot, path in scene.known:
        color = style.robot_color(robot)
        for pose in path.poses_at(moments[moments < path.duration]):
            draw_outline(axes, pose, scene.models[robot], edgecolor=color, linewidth=0.35,
                         alpha=0.55, zorder=3.0)  # fmt: skip
        axes.plot(*path.position[:, :2].T, color=color, linewidth=edge, zorder=3.2)
        axes.plot(*path.position[:, :2].T, color="white", linewidth=gap, zorder=3.3)
        for kind, first, last in runs(activities(path)):
            line = path.position[first : last + 1, :2]
            if kind == FLIES:
                axes.plot(*line.T, color=style.FLYING, linewidth=core + 0.7, zorder=3.6)
            else:
                axes.plot(*line.T, color=style.WALKING, linewidth=core, linestyle=dash, zorder=3.4)
        for x, y, _ in waits(path):
            axes.plot(x, y, **_WAIT, zorder=3.8)


def waits(path: Trajectory) -> list[tuple[float, float, float]]:
    """(x, y, seconds) of the stands on the way, not those at its ends."""
    found = []
    for kind, first, last in runs(activities(path))[:-1]:
        length = float(path.time[last] - path.time[first])
        if kind == STANDS and length >= _LONG_WAIT:
            found.append((float(path.position[first, 0]), float(path.position[first, 1]), length))
    return found


def _moments(scene: PlanScene, scale: float) -> Array:
    """Common times at which bodies are drawn: as often as they don't pile up on paper."""
    speeds = [path.length / max(path.duration, 1e-6) for _, path in scene.known if path.length]
    if not speeds:
        return np.zeros(0)
    body = max(model.length for model in scene.models)
    # At least two bodies' lengths and 30 points apart for a robot of usual speed.
    period = max(2.0 * body, 30.0 / scale) / max(float(np.median(speeds)), 1e-3)
    period = max(0.5, round(2.0 * period) / 2.0)
    return np.arange(period, scene.makespan, period)


def _draw_ends(axes: Axes, scene: PlanScene) -> None:
    """Starts as full bodies, goals as dashed ones, both numbered."""
    scale = points_per_metre(axes)
    ends = np.array([scene.scenario.starts, scene.scenario.goals], dtype=float)
    for robot, (start, goal) in enumerate(zip(*ends, strict=True)):
        color, model = style.robot_color(robot), scene.models[robot]
        draw_own_goal(axes, goal, model, color)
        draw_robot(axes, start, model, color)
        away = 0.5 * model.width + (5.0 if model.length * scale < 7.0 else 6.0) / scale
        for pose, weight in ((start, "bold"), (goal, "normal")):
            place = pose[:2] + away * np.array([-np.sin(pose[2]), np.cos(pose[2])])
            axes.text(place[0], place[1], str(robot), fontsize=6.5, fontweight=weight,
                      ha="center", va="center", zorder=8, path_effects=style.halo(1.4),
                      clip_on=True)  # fmt: skip


def _draw_legend(axes: Axes, scene: PlanScene) -> None:
    from matplotlib.patches import Patch

    legged = any(model.legs is not None for model in scene.models)
    walking = "walking" if legged else "driving"
    handles: list[Any] = [style.key(walking, color=style.WALKING, linewidth=1.4)]
    if any(FLIES in activities(path) for _, path in scene.known):
        handles.append(style.key("flight", color=style.FLYING, linewidth=2.0))
    if any(waits(path) for _, path in scene.known):
        handles.append(style.key("waits", **_WAIT))
    handles += [
        Patch(facecolor=style.GREY, edgecolor=style.INK, label="start"),
        Patch(facecolor="white", edgecolor=style.GREY, linestyle=(0, (2.2, 1.1)), label="goal"),
    ]
    if has_blocked_ground(scene.world.terrain):
        handles.append(Patch(facecolor="#7d6c59", edgecolor="none", label="no foothold"))
    draw_legend(axes, handles, "left", borderaxespad=0.1, handlelength=1.3)
