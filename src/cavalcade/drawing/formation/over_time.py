"""Distances over time with the limits drawn: to obstacles, and between the robots."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.drawing.distances import obstacle_distances, pair_distances, rest_lengths
from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cavalcade.scenario import World

_WIDTH, _HEIGHT, _BAND = style.COLUMN, 1.62, 0.07
_LEFT, _RIGHT, _BOTTOM, _GAP = 0.40, 0.42, 0.33, 0.035
_ROW = 0.135
MANY_ROBOTS = 4

_Name = tuple[str, str, str]
"""A line's name, its colour, and the colour it alternates with (the same for a plain line)."""


def draw_obstacle_distance(scene: Scene, world: World, path: Path) -> Path:
    """Distance of each robot's centre to the nearest obstacle, as in the paper's Fig. 9."""
    distances = obstacle_distances(scene, world)
    with style.paper_style():
        names = _robot_names(scene)
        figure, axes = _frame(scene, names)
        for name, line in zip(names, distances.T, strict=True):
            _plot(axes, scene.time, line, name)
        usual = float(np.quantile(distances, 0.995)) if distances.size else 1.0
        _limit(axes, scene.radius, f"$r_{{\\max}}$ =\n{scene.radius:.2f} m")
        axes.set_ylim(0.0, max(1.08 * usual, 2.2 * scene.radius))
        axes.set_ylabel("distance to obstacle (m)")
        return style.save(figure, path, dpi=400)


def draw_pair_distance(scene: Scene, path: Path) -> Path | None:
    """Distance of each pair of robots, as in the paper's Fig. 10; None for a single robot.

    Up to four robots every pair has its line. Beyond, each robot's distance to its nearest
    neighbour has, over grey lines for the connected pairs.
    """
    if scene.size < 2:
        return None
    pairs, distances = pair_distances(scene.poses)
    with style.paper_style():
        if scene.size <= MANY_ROBOTS:
            names = [
                (f"{a}\N{EN DASH}{b}", style.robot_color(a), style.robot_color(b)) for a, b in pairs
            ]
            lines = distances
        else:
            names = _robot_names(scene)
            lines = np.column_stack(
                [distances[:, (pairs == k).any(axis=1)].min(axis=1) for k in range(scene.size)]
            )
        figure, axes = _frame(scene, names)
        highest = float(np.quantile(lines, 0.995))
        if scene.size > MANY_ROBOTS:
            joined = _ever_connected(scene, pairs)
            for line in distances[:, joined].T:
                axes.plot(scene.time, line, color="#b9bcc0", linewidth=0.4, zorder=1.5)
            if joined.any():
                highest = max(highest, float(np.quantile(distances[:, joined], 0.98)))
        for name, line in zip(names, lines.T, strict=True):
            _plot(axes, scene.time, line, name)
        _limit(axes, 2.0 * scene.radius, f"$2r_{{\\max}}$ =\n{2.0 * scene.radius:.2f} m")
        rests = rest_lengths(scene)
        top = max(1.08 * highest, 2.8 * scene.radius, 1.1 * max((r[2] for r in rests), default=0))
        axes.set_ylim(0.0, top)
        _rests(axes, rests, float(scene.time[-1]), top)
        few = scene.size <= MANY_ROBOTS
        axes.set_ylabel("distance of robots (m)" if few else "nearest neighbour (m)")
        return style.save(figure, path, dpi=400)


def _robot_names(scene: Scene) -> list[_Name]:
    prefix = "robot " if scene.size <= MANY_ROBOTS else ""
    colors = [style.robot_color(k) for k in range(scene.size)]
    return [(f"{prefix}{k}", color, color) for k, color in enumerate(colors)]


def _plot(axes: Axes, time: Array, line: Array, name: _Name) -> None:
    """A line in its colour; a pair's in the colours of both robots, in turns."""
    for part in _strokes(name):
        axes.plot(time, line, **part)


def _strokes(name: _Name) -> list[dict[str, Any]]:
    _, color, second = name
    strokes: list[dict[str, Any]] = [{"color": color, "linewidth": 1.05}]
    if second != color:
        strokes.append(
            {"color": second, "linewidth": 1.05, "linestyle": (0, (3.2, 3.2)),
             "dash_capstyle": "butt"}
        )  # fmt: skip
    return strokes


def _frame(scene: Scene, names: list[_Name]) -> tuple[Figure, Axes]:
    """Axes under a legend row and a band that tells who leads when."""
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D

    most = 4 if len(names) <= 4 else 6
    rows = -(-len(names) // most)
    per_row = -(-len(names) // rows)
    # A legend fills its columns first; people read rows.
    order = [k for column in range(per_row) for k in range(column, len(names), per_row)]
    names = [names[k] for k in order]
    legend = rows * _ROW
    height = _BOTTOM + _HEIGHT + _GAP + _BAND + 0.05 + legend
    figure = style.new_figure(_WIDTH, height)
    width = (_WIDTH - _LEFT - _RIGHT) / _WIDTH
    left = _LEFT / _WIDTH
    axes = figure.add_axes((left, _BOTTOM / height, width, _HEIGHT / height))
    low = _BOTTOM + _HEIGHT + _GAP
    band = figure.add_axes((left, low / height, width, _BAND / height))
    start, end = float(scene.time[0]), float(scene.time[-1])
    end = end if end > start else start + 1.0
    for each in (axes, band):
        each.set_xlim(start, end)
    _draw_band(band, scene)
    axes.set_xlabel("time (s)", labelpad=1)
    axes.grid(True, linewidth=0.3, color="#dadcdf")
    axes.set_axisbelow(True)
    handles: list[Any] = [
        tuple(Line2D([], [], **part) for part in _strokes(name)) for name in names
    ]
    kinds: dict[Any, Any] = {tuple: HandlerTuple(ndivide=1, pad=0.0)}
    figure.legend(
        handles=handles,
        labels=[name[0] for name in names],
        handler_map=kinds,
        loc="upper center",
        bbox_to_anchor=(left + width / 2.0, 1.0 - 0.02 / height),
        ncols=per_row,
        labelspacing=0.25,
        columnspacing=1.0,
        handlelength=1.7,
    )
    return figure, axes


def _draw_band(band: Axes, scene: Scene) -> None:
    """The leader's colour over time; grey where nobody leads."""
    leaders = np.array([status.leader for status in scene.status])
    changes = [0, *(np.flatnonzero(np.diff(leaders)) + 1).tolist(), len(leaders) - 1]
    for first, last in pairwise(changes):
        leader = int(leaders[first])
        color = style.robot_color(leader) if leader >= 0 else "#e3e4e6"
        band.axvspan(scene.time[first], scene.time[last], facecolor=color, edgecolor="none")
    band.set_xticks([])
    band.set_yticks([])
    for spine in band.spines.values():
        spine.set_linewidth(0.4)
    band.annotate(
        "leader",
        (1.0, 0.5),
        xytext=(3, 0),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=7,
        va="center",
        color=style.GREY,
    )


def _limit(axes: Axes, value: float, name: str) -> None:
    axes.axhspan(0.0, value, facecolor="#f6d5d9", edgecolor="none", alpha=0.55, zorder=0.4)
    axes.axhline(value, color=style.LIMIT, linewidth=0.8, linestyle=(0, (5, 2)), zorder=2.4)
    _margin_note(axes, value, name, style.LIMIT)


def _rests(axes: Axes, rests: list[tuple[float, float, float]], end: float, top: float) -> None:
    """Dotted lines for the springs' rest lengths; those that still hold get a note."""
    noted: list[float] = []
    for start, stop, length in rests:
        axes.plot([start, stop], [length, length], color=style.INK, linewidth=0.6, zorder=2.3,
                  linestyle=(0, (1, 1.6)))  # fmt: skip
        clear = all(abs(length - other) > 0.075 * top for other in noted)
        if stop >= end and clear and length < 0.98 * top:
            _margin_note(axes, length, f"{length:.2f} m", style.INK)
            noted.append(length)


def _margin_note(axes: Axes, value: float, text: str, color: str) -> None:
    axes.annotate(
        text,
        (1.0, value),
        xytext=(3, 0),
        xycoords=axes.get_yaxis_transform(),
        textcoords="offset points",
        fontsize=7,
        va="center",
        linespacing=0.95,
        color=color,
    )


def _ever_connected(scene: Scene, pairs: NDArray[np.int64]) -> NDArray[np.bool_]:
    joined = {
        (min(a, b), max(a, b))
        for status in scene.status[:: max(1, len(scene.status) // 200)]
        for a, b in np.asarray(status.connections, dtype=int).reshape(-1, 2).tolist()
    }
    return np.array([(int(a), int(b)) in joined for a, b in pairs], dtype=bool)
