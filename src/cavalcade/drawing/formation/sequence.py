"""The team at six moments on its way through the arena."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.drawing.actors import (
    SMALL,
    STAR,
    draw_driven,
    draw_goals,
    draw_robot,
    draw_springs,
    label_places,
)
from cavalcade.drawing.maps import add_map, draw_arena, draw_tracks, points_per_metre
from cavalcade.drawing.scene import Scene, runs
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STATES = {
    "partial": "Partial Goal",
    "final": "Final Goal",
    "resolving": "resolving a deadlock",
    "paused": "paused",
    "stale": "stopped: stale pose",
    "stuck": "stuck",
    "infeasible": "infeasible",
    "inactive": "inactive",
}

_AHEAD: Any = (0, (3.2, 1.6))
"""Dashes of the leader's path ahead."""
_LEFT, _RIGHT, _BETWEEN, _TITLE, _BOTTOM, _LEGEND = 0.34, 0.09, 0.09, 0.19, 0.30, 0.24


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
        for number, cycle in enumerate(moments.tolist()):
            row, column = divmod(number, columns)
            left = _LEFT + column * (width + _BETWEEN)
            bottom = total - (row + 1) * (height + _TITLE)
            axes = add_map(figure, left, bottom, width, view, first=column == 0)
            _draw_moment(axes, scene, cycle, view)
            _label_panel(axes, scene, cycle, number)
            last = number + columns >= len(moments)
            axes.tick_params(labelbottom=last, labelleft=column == 0)
            if not last:
                axes.set_xlabel("")
        handles = _legend_handles(scene)
        figure.legend(
            handles=handles,
            loc="lower center",
            ncols=len(handles),
            bbox_to_anchor=(0.5, 0.015),
            columnspacing=min(1.2, 9.0 / len(handles)),
        )
        return style.save(figure, path)


def _layout(panels: int, span: Array, body: float) -> tuple[int, float, float]:
    """Columns, and a panel's width and height in inches, for so many that show `span` `(2,)` m.

    Wide ground on which a `body` of that length, m, would be a dot gets wider panels.
    """
    aspect = float(span[1] / span[0])
    columns = 3 if aspect < 1.45 else 6
    if aspect < 0.75 and body / float(span[0]) * 2.2 * 72.0 < SMALL:
        columns = 2
    width = (style.PAGE - _LEFT - _RIGHT - (columns - 1) * _BETWEEN) / columns
    columns = min(columns, panels)
    rows = -(-panels // columns)
    tallest = (8.8 - _LEGEND - _BOTTOM) / rows - _TITLE
    width = min(width, tallest / aspect)
    return columns, width, width * aspect


def _draw_moment(axes: Axes, scene: Scene, cycle: int, view: Array) -> None:
    recording = scene.recording
    status, poses = recording.status[cycle], recording.poses[cycle]
    draw_arena(axes, scene)
    draw_tracks(axes, recording.obstacles, float(recording.time[cycle]))
    for robot in range(scene.size):
        draw_driven(axes, recording.poses[: cycle + 1, robot], robot)
        if robot < len(status.paths) and len(status.paths[robot]) > 1:
            leads = robot == status.leader
            axes.plot(
                *np.asarray(status.paths[robot]).T,
                color=style.robot_color(robot),
                linewidth=0.8 if leads else 0.5,
                linestyle=_AHEAD if leads else (0, (1, 1.4)),
                zorder=2.6,
            )
    draw_springs(axes, poses[:, :2], status)
    draw_goals(axes, status)
    for robot, (pose, model) in enumerate(zip(poses, scene.models, strict=True)):
        leads = robot == status.leader and scene.size > 1
        lost = bool(status.roles[robot] < 0) and status.state != "inactive"
        draw_robot(axes, pose, model, style.robot_color(robot), leader=leads, hollow=lost)
    if scene.size == 1:
        return
    places = label_places(poses, scene.models, view, 4.2 / points_per_metre(axes))
    for robot, place in enumerate(places):
        axes.text(place[0], place[1], str(robot), fontsize=6.0, ha="center",
                  va="center_baseline", zorder=8, path_effects=style.halo(1.3))  # fmt: skip


def _label_panel(axes: Axes, scene: Scene, cycle: int, number: int) -> None:
    state = scene.recording.status[cycle]
    text = "arrived" if state.arrived else STATES.get(state.state, state.state)
    name = f"({chr(ord('a') + number)})  $t$ = {scene.recording.time[cycle]:.1f} s"
    axes.set_title(name, loc="left", pad=2.5)
    axes.set_title(text, loc="right", pad=2.5, fontsize=7.0, fontstyle="italic", color=style.GREY)


def _legend_handles(scene: Scene) -> list[Any]:
    from matplotlib.patches import Patch

    handles: list[Any] = []
    for robot in range(min(scene.size, 10)):
        label = f"robot {robot}" if scene.size <= 4 or robot == 0 else f"{robot}"
        color = style.robot_color(robot)
        handles.append(Patch(facecolor=color, edgecolor=style.INK, linewidth=0.4, label=label))
    if scene.size > 1:
        handles.append(style.key("leader", **style.mark("*", 6, style.INK, 0.35, STAR)))
    handles.append(style.key("present goal", **style.mark("o", 3.4, style.GREY)))
    handles.append(style.key("slot at goal", **style.mark("+", 4, style.GREY, 0.6)))
    if scene.size > 1:
        handles.append(style.key("spring", color=style.INK, linewidth=0.6))
    handles.append(style.key("path", color=style.GREY, linewidth=0.8, linestyle=_AHEAD))
    return handles


def choose_moments(scene: Scene, count: int = 6) -> NDArray[np.int64]:
    """Indices `(<= count,)` of cycles, rising: the start, the end and tellers in between.

    The moments are spread evenly over the way the team has gone, not over time, so that waiting
    does not fill panels. Each is then moved, by less than half the spacing, to the tightest
    moment or to just after a change of leader or state nearby.
    """
    cycles = len(scene.recording.time)
    if cycles <= count:
        return np.arange(cycles)
    centre = np.median(scene.recording.poses[..., :2], axis=1)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(centre, axis=0).T))])
    way = way + np.linspace(0.0, 1e-3 + 0.05 * way[-1], cycles)
    interest = _interest(scene)
    chosen = [0]
    for number in range(1, count - 1):
        target = way[-1] * number / (count - 1)
        window = way[-1] / (count - 1) * 0.4
        near = np.flatnonzero(np.abs(way - target) <= window)
        near = near[near > chosen[-1]]
        if len(near) == 0:
            near = np.array([min(chosen[-1] + 1, cycles - 1)])
        score = interest[near] - 0.3 * np.abs(way[near] - target) / window
        chosen.append(int(near[np.argmax(score)]))
    chosen.append(cycles - 1)
    return np.unique(chosen)


def _interest(scene: Scene) -> Array:
    """`(T,)` how much a cycle has to tell, about 0..1."""
    time, positions = scene.recording.time, scene.recording.poses[..., :2]
    cycles = len(time)
    interest = np.zeros(cycles)
    if scene.size > 1:
        offsets = positions - positions.mean(axis=1, keepdims=True)
        moments = np.einsum("tni,tnj->tij", offsets, offsets) / scene.size
        spread = np.linalg.eigvalsh(moments)
        # A line has a vanishing second moment: the tighter the place, the flatter the team.
        flatness = 1.0 - np.sqrt(np.maximum(spread[:, 0], 0.0) / np.maximum(spread[:, 1], 1e-9))
        interest += 0.5 * flatness
    step = float(np.median(np.diff(time))) if cycles > 1 else 1.0
    lag = max(1, round(0.4 / max(step, 1e-6)))
    said = ((status.leader, status.state) for status in scene.recording.status)
    for _, after, _ in runs(said)[1:]:
        interest[after : after + lag] += 0.3
    return interest
