"""Distances over time with the limits drawn: to obstacles, and between the robots."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_grid, draw_limit, draw_lines, draw_note, stacked_panels
from cavalcade.drawing.distances import (
    neighbour_distances,
    obstacle_distances,
    pair_distances,
    rest_lengths,
)
from cavalcade.drawing.scene import Scene, runs
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BAND, _HEIGHT, _GAP = 0.07, 1.62, 0.035
_LEFT, _RIGHT, _BOTTOM = 0.40, 0.42, 0.33
_ROW = 0.135
_WIDTH = 1.05
MANY_ROBOTS = 4

_Name = tuple[str, list[dict[str, Any]]]
"""A line's name, and the strokes it is drawn with, one over the other."""


def draw_obstacle_distance(scene: Scene, path: Path) -> Path:
    """Distance of each robot's centre to the nearest obstacle, as in the paper's Fig. 9."""
    distances = obstacle_distances(scene)
    with style.paper_style():
        usual = float(np.quantile(distances, 0.995)) if distances.size else 1.0
        top = max(1.08 * usual, 2.2 * scene.radius)
        figure, axes = _frame(scene, _robot_names(scene), distances, top)
        draw_limit(axes, scene.radius, 0.0, f"$r_{{\\max}}$ =\n{scene.radius:.2f} m")
        axes.set_ylabel("distance to obstacle (m)")
        return style.save(figure, path, dpi=400)


def draw_pair_distance(scene: Scene, path: Path) -> Path | None:
    """Distance of each pair of robots, as in the paper's Fig. 10; None for a single robot.

    Up to four robots every pair has its line. Beyond, each robot's distance to its nearest
    neighbour has, over grey lines for the connected pairs.
    """
    if scene.size < 2:
        return None
    few = scene.size <= MANY_ROBOTS
    pairs, distances = pair_distances(scene.recording.poses)
    lines, names = distances, [_name(f"{a}\N{EN DASH}{b}", a, b) for a, b in pairs.tolist()]
    if not few:
        lines, names = neighbour_distances(scene.recording.poses), _robot_names(scene)
    with style.paper_style():
        highest = float(np.quantile(lines, 0.995))
        joined = distances[:, [] if few else _ever_connected(scene, pairs)]
        if joined.size:
            highest = max(highest, float(np.quantile(joined, 0.98)))
        rests, minimum = rest_lengths(scene), 2.0 * scene.radius
        top = max(1.08 * highest, 1.4 * minimum, 1.1 * max((r[2] for r in rests), default=0))
        figure, axes = _frame(scene, names, lines, top)
        for line in joined.T:
            axes.plot(scene.recording.time, line, color="#b9bcc0", linewidth=0.4, zorder=1.5)
        draw_limit(axes, minimum, 0.0, f"$2r_{{\\max}}$ =\n{minimum:.2f} m")
        _rests(axes, rests, float(scene.recording.time[-1]), top)
        axes.set_ylabel("distance of robots (m)" if few else "nearest neighbour (m)")
        return style.save(figure, path, dpi=400)


def _robot_names(scene: Scene) -> list[_Name]:
    prefix = "robot " if scene.size <= MANY_ROBOTS else ""
    return [_name(f"{prefix}{k}", k) for k in range(scene.size)]


def _name(label: str, robot: int, second: int | None = None) -> _Name:
    """A line in the robot's colour; a pair's in the colours of both robots, in turns."""
    strokes: list[dict[str, Any]] = [{"color": style.robot_color(robot), "linewidth": _WIDTH}]
    if second is not None:
        dashes = {"linestyle": (0, (3.2, 3.2)), "dash_capstyle": "butt"}
        strokes.append({**strokes[0], "color": style.robot_color(second), **dashes})
    return label, strokes


def _frame(scene: Scene, names: list[_Name], lines: Array, top: float) -> tuple[Figure, Axes]:
    """The lines `(T, K)` from 0 to `top` under a legend row and a band that tells who leads."""
    from matplotlib.legend_handler import HandlerTuple

    most = 4 if len(names) <= 4 else 6
    rows = -(-len(names) // most)
    per_row = -(-len(names) // rows)
    margins = style.Margins(_LEFT, _RIGHT, _BOTTOM, 0.05 + rows * _ROW)
    time = scene.recording.time
    start, end = float(time[0]), float(time[-1])
    span = (start, end if end > start else start + 1.0)
    figure, (band, axes) = stacked_panels(style.COLUMN, margins, [_BAND, _HEIGHT], [_GAP], span)
    _draw_band(band, scene)
    draw_grid(axes)
    axes.set_ylim(0.0, top)
    looks = [{"color": strokes[0]["color"]} for _, strokes in names]
    draw_lines(axes, [(time, line) for line in lines.T], looks, _WIDTH)
    for (_, strokes), line in zip(names, lines.T, strict=True):
        for stroke in strokes[1:]:
            axes.plot(time, line, **stroke, zorder=3.2)
    # A legend fills its columns first; people read rows.
    order = [k for column in range(per_row) for k in range(column, len(names), per_row)]
    handles: list[Any] = [tuple(style.key("", **part) for part in names[k][1]) for k in order]
    kinds: dict[Any, Any] = {tuple: HandlerTuple(ndivide=1, pad=0.0)}
    box = axes.get_position()
    figure.legend(
        handles=handles,
        labels=[names[k][0] for k in order],
        handler_map=kinds,
        loc="upper center",
        bbox_to_anchor=((box.x0 + box.x1) / 2.0, 1.0 - 0.02 / figure.get_figheight()),
        ncols=per_row,
        labelspacing=0.25,
        columnspacing=1.0,
        handlelength=1.7,
    )
    return figure, axes


def _draw_band(band: Axes, scene: Scene) -> None:
    """The leader's colour over time; grey where nobody leads."""
    time = scene.recording.time
    for leader, first, last in runs(status.leader for status in scene.recording.status):
        color = style.robot_color(leader) if leader >= 0 else "#e3e4e6"
        end = time[min(last, len(time) - 1)]
        band.axvspan(time[first], end, facecolor=color, edgecolor="none")
    band.set_xticks([])
    band.set_yticks([])
    for spine in band.spines.values():
        spine.set_linewidth(0.4)
    draw_note(band, 0.5, "leader", style.GREY)


def _rests(axes: Axes, rests: list[tuple[float, float, float]], end: float, top: float) -> None:
    """Dotted lines for the springs' rest lengths; those that still hold get a note."""
    noted: list[float] = []
    for start, stop, length in rests:
        axes.plot([start, stop], [length, length], color=style.INK, linewidth=0.6, zorder=2.3,
                  linestyle=(0, (1, 1.6)))  # fmt: skip
        clear = all(abs(length - other) > 0.075 * top for other in noted)
        if stop >= end and clear and length < 0.98 * top:
            draw_note(axes, length, f"{length:.2f} m", style.INK)
            noted.append(length)


def _ever_connected(scene: Scene, pairs: NDArray[np.int64]) -> NDArray[np.bool_]:
    statuses = scene.recording.status
    joined = {
        frozenset(pair)
        for status in statuses[:: max(1, len(statuses) // 200)]
        for pair in np.asarray(status.connections, dtype=int).reshape(-1, 2).tolist()
    }
    return np.array([frozenset(pair) in joined for pair in pairs.tolist()], dtype=bool)
