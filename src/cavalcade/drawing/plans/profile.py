"""Body, feet and ground from the side, along each robot's path."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.plans.footholds import LEGS
from cavalcade.drawing.plans.scene import FLYING, WALKING, PlanScene, along, runs
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, Trajectory
from cavalcade.world import Terrain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST = 6
_LEFT, _RIGHT, _BOTTOM, _TOP, _BETWEEN = 0.46, 0.10, 0.34, 0.24, 0.16
_PUSH = "#f4a582"
"""Take-off and landing."""


def draw_profile(scene: PlanScene, path: Path) -> Path | None:
    """Draw it a page wide, the first robots one below the other; None on flat ground."""
    if scene.terrain is None or not scene.known:
        return None
    shown = scene.known[:_MOST]
    height = 1.5 if len(shown) == 1 else 1.0
    total = _BOTTOM + _TOP + height * len(shown) + _BETWEEN * (len(shown) - 1)
    longest = max(float(along(one)[-1]) for _, one in shown)
    with style.paper_style():
        figure = style.new_figure(style.PAGE, total)
        width = (style.PAGE - _LEFT - _RIGHT) / style.PAGE
        panels = []
        for row, (robot, trajectory) in enumerate(shown):
            bottom = total - _TOP - (row + 1) * height - row * _BETWEEN
            axes = figure.add_axes((_LEFT / style.PAGE, bottom / total, width, height / total))
            axes.set_xlim(0.0, max(longest, 0.1))
            _draw_one(axes, scene.terrain, trajectory, scene.footholds[robot])
            if len(scene.known) > 1:
                axes.text(0.995, 0.93, f"robot {robot}", transform=axes.transAxes, ha="right",
                          va="top", fontsize=7, fontweight="bold",
                          color=style.robot_color(robot))  # fmt: skip
            axes.set_ylabel("height (m)", labelpad=2)
            axes.tick_params(labelbottom=row == len(shown) - 1)
            panels.append(axes)
        panels[-1].set_xlabel("along the path (m)", labelpad=1)
        more = len(scene.known) - len(shown)
        panels[0].set_title(
            scene.name + (f" (first {len(shown)} of {len(scene.known)} robots)" if more else ""),
            loc="left", pad=3,
        )  # fmt: skip
        _draw_legend(panels[0], any(len(feet) for feet in scene.footholds))
        return style.save(figure, path)


def _draw_one(axes: Axes, terrain: Terrain, path: Trajectory, feet: Array) -> None:
    s = along(path)
    # Samples of the path may be coarser than the ground's cells.
    fine = np.linspace(0.0, s[-1], max(2, int(s[-1] / 0.02)))
    moving = np.concatenate([[True], np.diff(s) > 1e-9])
    places = np.column_stack(
        [np.interp(fine, s[moving], path.position[moving, axis]) for axis in (0, 1)]
    )
    ground = terrain.heights_at(places)
    low = float(ground.min())
    top = float(max(path.position[:, 2].max(), ground.max()))
    room = 0.1 * (top - low) + 0.05
    axes.set_ylim(low - room, top + 1.6 * room)
    axes.fill_between(fine, ground, low - room, color="#d9cbb0", lw=0, zorder=1)
    axes.plot(fine, ground, color="#5e5340", linewidth=0.8, zorder=2)
    for leg, (_, colour, _) in enumerate(LEGS):
        mine = feet[feet[:, 2] == leg]
        if len(mine):
            axes.plot(
                _beside(path, s, mine), mine[:, 5], linestyle="none", marker="o",
                markersize=1.5, color=colour, zorder=3,
            )  # fmt: skip
    for phase, first, last in runs(path.phase[:-1]):
        colour = {FLIGHT: FLYING, TAKE_OFF: _PUSH, LANDING: _PUSH}.get(phase, WALKING)
        piece = slice(first, last + 1)
        axes.plot(s[piece], path.position[piece, 2], color=colour, linewidth=1.3, zorder=4)


def _beside(path: Trajectory, s: Array, feet: Array) -> Array:
    """Along the path `(M,)`, where it is nearest to each foothold around its time, m."""
    found = np.empty(len(feet))
    for m, (down, up, _, x, y, _) in enumerate(feet):
        first, last = np.searchsorted(path.time, (down - 0.5, up + 0.5))
        piece = slice(int(first), max(int(last), int(first) + 1))
        away = np.hypot(path.position[piece, 0] - x, path.position[piece, 1] - y)
        found[m] = s[piece][int(np.argmin(away))]
    return found


def _draw_legend(axes: Axes, stepping: bool) -> None:
    from matplotlib.lines import Line2D

    names = [("walking", WALKING), ("take-off, landing", _PUSH), ("flight", FLYING)]
    handles: list[Any] = [Line2D([], [], color=c, linewidth=1.4, label=n) for n, c in names]
    handles.append(Line2D([], [], color="#5e5340", linewidth=0.8, label="ground"))
    if stepping:
        handles.append(
            Line2D([], [], color=LEGS[0][1], marker="o", markersize=2.0, linestyle="none",
                   label="footholds (colours as in footholds.png)")
        )  # fmt: skip
    axes.legend(
        handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=len(handles),
        columnspacing=0.9,
    )  # fmt: skip
