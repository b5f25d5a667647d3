"""The plan seen from above, after the paper's Fig. 6: walking red, flight blue."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import set_ticks, set_view
from cavalcade.drawing.outlines import body_ring
from cavalcade.drawing.plans.scene import FLYING, WALKING, PlanScene, activities, runs
from cavalcade.drawing.terrain import draw_ground, has_blocked_ground
from cavalcade.geometry import Array, transform_points
from cavalcade.geometry.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEFT, _RIGHT, _BOTTOM, _TOP = 0.38, 0.08, 0.32, 0.40
_BAR = 0.64
_TALLEST = 6.4
_NARROWEST = 3.2
_LONG_WAIT = 0.5
"""Stands shorter than this on the way are not marked, s."""


def draw_top_view(scene: PlanScene, path: Path) -> Path:
    """Draw it as wide as a page or as high as fits; returns the file written."""
    with style.paper_style():
        figure, axes, inches = map_figure(scene)
        size = 72.0 * inches / float(np.ptp(scene.view()[::2]))
        draw_paths(axes, scene, size)
        _draw_ends(axes, scene, size)
        _draw_legend(axes, scene)
        return style.save(figure, path)


def map_figure(scene: PlanScene) -> tuple[Figure, Axes, float]:
    """A figure with the ground drawn to scale, titled; its axes and their width in inches."""
    view = scene.view()
    span = view[2:] - view[:2]
    aspect = float(span[1] / span[0])
    bar = _BAR if scene.terrain is not None else 0.0
    width = min(style.PAGE - _LEFT - _RIGHT - bar, _TALLEST / aspect)
    height = width * aspect
    page = max(_LEFT + width + _RIGHT + bar, _NARROWEST)
    total = _BOTTOM + height + _TOP
    figure = style.new_figure(page, total)
    axes = figure.add_axes((_LEFT / page, _BOTTOM / total, width / page, height / total))
    set_view(axes, view)
    set_ticks(axes, view, width)
    shown = draw_ground(axes, scene)
    set_view(axes, view)
    if shown is not None:
        place = ((_LEFT + width + 0.06) / page, _BOTTOM / total, 0.09 / page, height / total)
        colours = figure.colorbar(shown, cax=figure.add_axes(place))
        colours.set_label("height (m)", labelpad=2)
        colours.outline.set_linewidth(0.5)
    axes.set_xlabel("$x$ (m)", labelpad=1)
    axes.set_ylabel("$y$ (m)", labelpad=1)
    axes.set_title(scene.name, loc="left", pad=13)
    if not scene.solved:
        axes.set_title(scene.result[:70], loc="right", pad=13, color=style.LIMIT, fontsize=7)
    return figure, axes, width


def draw_paths(axes: Axes, scene: PlanScene, size: float, *, bodies: bool = True) -> None:
    """Paths with the robot's colour as their edge, and bodies at common moments.

    Args:
        axes: The map.
        scene: The plan.
        size: Points of the page per metre.
        bodies: Draw the footprints.
    """
    many = scene.size > 8
    core, gap, edge = (0.8, 1.5, 2.3) if many else (1.2, 2.1, 3.3)
    moments = _moments(scene, size)
    for robot, path in scene.known:
        colour = style.robot_color(robot)
        if bodies:
            for pose in path.poses_at(moments[moments < path.duration]):
                _outline(axes, pose, scene, robot, linewidth=0.35, alpha=0.55, zorder=3.0)
        axes.plot(*path.position[:, :2].T, color=colour, linewidth=edge, zorder=3.2)
        axes.plot(*path.position[:, :2].T, color="white", linewidth=gap, zorder=3.3)
        dash: Any = "-" if scene.solved else (0, (3, 1.5))
        for kind, first, last in runs(activities(path)):
            line = path.position[first : last + 1, :2]
            if kind == 2:
                axes.plot(*line.T, color=FLYING, linewidth=core + 0.7, zorder=3.6)
            else:
                axes.plot(*line.T, color=WALKING, linewidth=core, linestyle=dash, zorder=3.4)
        for place in waits(path):
            axes.plot(*place[:2], marker="s", markersize=3.0, markerfacecolor="white",
                      markeredgecolor=style.INK, markeredgewidth=0.6, zorder=3.8)  # fmt: skip


def waits(path: Trajectory) -> list[tuple[float, float, float]]:
    """(x, y, seconds) of the stands on the way, not those at its ends."""
    found = []
    spans = runs(activities(path))
    for kind, first, last in spans[:-1]:
        length = float(path.time[last] - path.time[first])
        if kind == 0 and length >= _LONG_WAIT:
            found.append((float(path.position[first, 0]), float(path.position[first, 1]), length))
    return found


def _moments(scene: PlanScene, size: float) -> Array:
    """Common times at which bodies are drawn: as often as they don't pile up on paper."""
    speeds = [path.length / max(path.duration, 1e-6) for _, path in scene.known if path.length]
    if not speeds:
        return np.zeros(0)
    body = max(model.length for model in scene.models)
    # At least two bodies' lengths and 30 points apart for a robot of usual speed.
    period = max(2.0 * body, 30.0 / size) / max(float(np.median(speeds)), 1e-3)
    period = max(0.5, round(2.0 * period) / 2.0)
    return np.arange(period, scene.makespan, period)


def _outline(axes: Axes, pose: Array, scene: PlanScene, robot: int, **options: Any) -> None:
    from matplotlib.patches import Polygon

    ring = body_ring(pose, scene.models[robot])
    axes.add_patch(Polygon(ring, fill=False, edgecolor=style.robot_color(robot), **options))


def _draw_ends(axes: Axes, scene: PlanScene, size: float) -> None:
    """Starts as full bodies, goals as dashed ones, both numbered."""
    from matplotlib.patches import Polygon
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=1.4, foreground="white")]
    for robot, (start, goal) in enumerate(zip(scene.starts, scene.goals, strict=True)):
        colour, model = style.robot_color(robot), scene.models[robot]
        small = model.length * size < 7.0
        axes.add_patch(
            Polygon(
                body_ring(start, model), facecolor=colour, edgecolor=style.INK, linewidth=0.5,
                zorder=5.0,
            )
        )  # fmt: skip
        axes.add_patch(
            Polygon(
                body_ring(goal, model), facecolor="white", alpha=0.85, edgecolor="none", zorder=4.6
            )
        )
        _outline(axes, goal, scene, robot, linewidth=1.0, linestyle=(0, (2.2, 1.1)), zorder=4.8)
        _nose(axes, start, scene, robot, "white", 5.1)
        _nose(axes, goal, scene, robot, colour, 4.9)
        for pose, weight in ((start, "bold"), (goal, "normal")):
            away = 0.5 * model.width + (5.0 if small else 6.0) / size
            side = np.array([-np.sin(pose[2]), np.cos(pose[2])])
            axes.text(
                pose[0] + away * side[0], pose[1] + away * side[1], str(robot), fontsize=6.5,
                fontweight=weight, color=style.INK, ha="center", va="center", zorder=8,
                path_effects=halo, clip_on=True,
            )  # fmt: skip


def _nose(
    axes: Axes, pose: Array, scene: PlanScene, robot: int, colour: str, zorder: float
) -> None:
    from matplotlib.patches import Polygon

    model = scene.models[robot]
    front, half = model.length / 2.0, model.width / 2.0
    tip = [(front * 0.92, 0.0), (front * 0.35, half * 0.7), (front * 0.35, -half * 0.7)]
    axes.add_patch(
        Polygon(transform_points(pose, tip), facecolor=colour, edgecolor="none", zorder=zorder)
    )


def _draw_legend(axes: Axes, scene: PlanScene) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    legged = any(model.legs is not None for model in scene.models)
    handles: list[Any] = [
        Line2D([], [], color=WALKING, linewidth=1.4, label="walking" if legged else "driving")
    ]
    if any((activities(path) == 2).any() for _, path in scene.known):
        handles.append(Line2D([], [], color=FLYING, linewidth=2.0, label="flight"))
    if any(waits(path) for _, path in scene.known):
        handles.append(
            Line2D([], [], marker="s", markersize=3.0, markerfacecolor="white",
                   markeredgecolor=style.INK, markeredgewidth=0.6, linestyle="none",
                   label="waits")
        )  # fmt: skip
    handles += [
        Patch(facecolor=style.GREY, edgecolor=style.INK, label="start"),
        Patch(facecolor="white", edgecolor=style.GREY, linestyle=(0, (2.2, 1.1)), label="goal"),
    ]
    if has_blocked_ground(scene):
        handles.append(Patch(facecolor="#7d6c59", edgecolor="none", label="no foothold"))
    axes.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.005), ncols=len(handles),
        borderaxespad=0.1, handlelength=1.3, columnspacing=0.9,
    )  # fmt: skip
