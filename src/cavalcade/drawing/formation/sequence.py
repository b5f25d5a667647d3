"""The team at six moments on its way through the arena."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import (
    draw_arena,
    draw_goals,
    draw_robot,
    draw_springs,
    draw_tracks,
    label_places,
    set_ticks,
    set_view,
)
from cavalcade.drawing.formation.snapshots import choose_moments
from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STATES = {
    "partial": "Partial Goal",
    "final": "Final Goal",
    "resolving": "resolving a deadlock",
    "paused": "paused",
    "stuck": "stuck",
    "infeasible": "infeasible",
    "inactive": "inactive",
}

_SMALL = 6.0
"""A body shorter than this, in points, needs a dot to be seen."""
_LEFT, _RIGHT, _BETWEEN, _TITLE, _BOTTOM, _LEGEND = 0.34, 0.05, 0.09, 0.19, 0.30, 0.24


def draw_sequence(scene: Scene, path: Path) -> Path:
    """Six panels over the width of a page, in the order of time; returns the file written."""
    moments = choose_moments(scene)
    view = scene.view()
    span = view[2:] - view[:2]
    columns, width, height = _layout(len(moments), span, scene.models[0].length)
    rows = -(-len(moments) // columns)
    with style.paper_style():
        total = _LEGEND + _BOTTOM + rows * (height + _TITLE)
        page = _LEFT + _RIGHT + columns * width + (columns - 1) * _BETWEEN
        figure = style.new_figure(page, total)
        for number, cycle in enumerate(moments):
            row, column = divmod(number, columns)
            left = _LEFT + column * (width + _BETWEEN)
            bottom = total - (row + 1) * (height + _TITLE)
            axes = figure.add_axes((left / page, bottom / total, width / page, height / total))
            set_view(axes, view)
            set_ticks(axes, view, width, first=column == 0)
            _draw_moment(axes, scene, int(cycle), view, width)
            _label_panel(axes, scene, int(cycle), number)
            last = number + columns >= len(moments)
            axes.tick_params(labelbottom=last, labelleft=column == 0)
            if last:
                axes.set_xlabel("$x$ (m)", labelpad=1)
            if column == 0:
                axes.set_ylabel("$y$ (m)", labelpad=1)
        handles = _legend_handles(scene)
        figure.legend(
            handles=handles,
            loc="lower center",
            ncols=len(handles),
            bbox_to_anchor=(0.5, 0.015),
            handler_map=_handler_map(),
            columnspacing=min(1.2, 9.0 / len(handles)),
        )
        return style.save(figure, path)


def _layout(panels: int, span: Array, body: float) -> tuple[int, float, float]:
    """Columns, and a panel's width and height in inches.

    Args:
        panels: How many there are.
        span: `(2,)` width and height of the part that is shown, m.
        body: A robot's length, m; wide ground on which it would be a dot gets wider panels.
    """
    aspect = float(span[1] / span[0])
    columns = 3 if aspect < 1.45 else 6
    if aspect < 0.75 and body / float(span[0]) * 2.2 * 72.0 < _SMALL:
        columns = 2
    width = (style.PAGE - _LEFT - _RIGHT - (columns - 1) * _BETWEEN) / columns
    columns = min(columns, panels)
    rows = -(-panels // columns)
    tallest = (8.8 - _LEGEND - _BOTTOM) / rows - _TITLE
    width = min(width, tallest / aspect)
    return columns, width, width * aspect


def _draw_moment(axes: Axes, scene: Scene, cycle: int, view: Array, inches: float) -> None:
    status = scene.status[cycle]
    poses = scene.poses[cycle]
    points_per_metre = inches * 72.0 / float(view[2] - view[0])
    draw_arena(axes, scene.arena)
    draw_tracks(axes, scene.tracks, float(scene.time[cycle]))
    for robot in range(scene.size):
        color = style.robot_color(robot)
        axes.plot(
            *scene.poses[: cycle + 1, robot, :2].T,
            color=color,
            linestyle=style.robot_dash(robot),
            linewidth=0.9,
            zorder=2.5,
        )
        if robot < len(status.paths) and len(status.paths[robot]) > 1:
            leads = robot == status.leader
            axes.plot(
                *np.asarray(status.paths[robot]).T,
                color=color,
                linewidth=0.8 if leads else 0.5,
                linestyle=(0, (3.2, 1.6)) if leads else (0, (1, 1.4)),
                zorder=2.6,
            )
    draw_springs(axes, poses[:, :2], status)
    draw_goals(axes, status)
    body = scene.models[0].length * points_per_metre
    for robot, pose in enumerate(poses):
        if body < _SMALL:
            axes.plot(
                *pose[:2],
                marker="o",
                markersize=4.2,
                color=style.robot_color(robot),
                markeredgecolor="white",
                markeredgewidth=0.3,
                zorder=5.8,
            )
        draw_robot(
            axes,
            pose,
            scene.models[robot],
            style.robot_color(robot),
            leader=robot == status.leader and scene.size > 1,
            lost=bool(status.roles[robot] < 0) and status.state != "inactive",
            star=min(6.0, max(3.6, 0.75 * body)),
        )
    _label_roles(axes, scene, cycle, view, points_per_metre)


def _label_roles(axes: Axes, scene: Scene, cycle: int, view: Array, scale: float) -> None:
    """The number of its slot beside each robot, the leader's being 1."""
    from matplotlib.patheffects import withStroke

    status = scene.status[cycle]
    if scene.size == 1:
        return
    places = label_places(scene.poses[cycle], scene.models, view, 4.2 / scale)
    for robot, place in enumerate(places):
        if status.roles[robot] < 0:
            continue
        axes.text(
            float(place[0]),
            float(place[1]),
            f"{int(status.roles[robot]) + 1}",
            fontsize=6.0,
            ha="center",
            va="center_baseline",
            zorder=8,
            path_effects=[withStroke(linewidth=1.3, foreground="white")],
        )


def _label_panel(axes: Axes, scene: Scene, cycle: int, number: int) -> None:
    state = scene.status[cycle]
    text = "arrived" if state.arrived else STATES.get(state.state, state.state)
    name = f"({chr(ord('a') + number)})  $t$ = {scene.time[cycle]:.1f} s"
    axes.set_title(name, loc="left", pad=2.5)
    axes.set_title(text, loc="right", pad=2.5, fontsize=7.0, fontstyle="italic", color=style.GREY)


def _legend_handles(scene: Scene) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = []
    shown = range(min(scene.size, 10))
    for robot in shown:
        label = f"robot {robot}" if scene.size <= 4 or robot == 0 else f"{robot}"
        color = style.robot_color(robot)
        handles.append(Patch(facecolor=color, edgecolor=style.INK, linewidth=0.4, label=label))
    if scene.size > 1:
        handles.append(
            Line2D([], [], marker="*", markersize=6, markerfacecolor="#ffe14d", linestyle="none",
                   markeredgecolor=style.INK, markeredgewidth=0.35, label="leader")
        )  # fmt: skip
    handles.append(
        Line2D([], [], marker="o", markersize=3.4, markerfacecolor="white", linestyle="none",
               markeredgecolor=style.GREY, markeredgewidth=0.8, label="present goal")
    )  # fmt: skip
    handles.append(
        Line2D([], [], marker="+", markersize=4, color=style.GREY, linestyle="none",
               markeredgewidth=0.6, label="slot at goal")
    )  # fmt: skip
    if scene.size > 1:
        handles.append(Line2D([], [], color=style.INK, linewidth=0.6, label="spring"))
    handles.append(
        Line2D([], [], color=style.GREY, linewidth=0.8, linestyle=(0, (3.2, 1.6)), label="path")
    )
    return handles


def _handler_map() -> dict[Any, Any]:
    from matplotlib.legend_handler import HandlerPatch
    from matplotlib.patches import Patch

    return {Patch: HandlerPatch()}
