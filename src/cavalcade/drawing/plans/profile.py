"""Body, feet and ground from the side, along each robot's path."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_legend, stacked_panels
from cavalcade.drawing.plans.motion import along
from cavalcade.drawing.scene import PlanScene, runs
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, Trajectory
from cavalcade.world import Terrain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST = 6
_MARGINS = style.Margins(left=0.46, right=0.10, bottom=0.34, top=0.24)
_BETWEEN = 0.16
_PUSH, _EARTH = "#f4a582", "#5e5340"
"""The colours of take-off and landing, and of the ground's edge."""


def draw_profile(scene: PlanScene, path: Path) -> Path | None:
    """Draw it a page wide, the first robots one below the other; None on flat ground."""
    terrain = scene.world.terrain
    if terrain is None or not scene.known:
        return None
    shown = scene.known[:_MOST]
    rows, team = len(shown), len(scene.known)
    span = (0.0, max(0.1, *(float(along(one)[-1]) for _, one in shown)))
    heights, gaps = [1.5 if rows == 1 else 1.0] * rows, [_BETWEEN] * (rows - 1)
    with style.paper_style():
        figure, panels = stacked_panels(
            style.PAGE, _MARGINS, heights, gaps, span, "along the path (m)"
        )
        for axes, (robot, trajectory) in zip(panels, shown, strict=True):
            _draw_one(axes, terrain, trajectory, scene.plan.footholds[robot])
            if team > 1:
                axes.text(0.995, 0.93, f"robot {robot}", transform=axes.transAxes, ha="right",
                          va="top", fontsize=7, fontweight="bold",
                          color=style.robot_color(robot))  # fmt: skip
            axes.set_ylabel("height (m)", labelpad=2)
        some = f" (first {rows} of {team} robots)" if rows < team else ""
        panels[0].set_title(scene.name + some, loc="left", pad=3)
        _draw_legend(panels[0], any(len(feet) for feet in scene.plan.footholds))
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
    axes.plot(fine, ground, color=_EARTH, linewidth=0.8, zorder=2)
    for leg, (_, color, _) in enumerate(style.LEGS):
        mine = feet[feet[:, 2] == leg]
        foot = style.mark("o", 1.5, color, 1.0, color)
        axes.plot(_beside(path, s, mine), mine[:, 5], **foot, zorder=3)
    for phase, first, last in runs(path.phase[:-1].tolist()):
        color = {FLIGHT: style.FLYING, TAKE_OFF: _PUSH, LANDING: _PUSH}.get(phase, style.WALKING)
        piece = slice(first, last + 1)
        axes.plot(s[piece], path.position[piece, 2], color=color, linewidth=1.3, zorder=4)


def _beside(path: Trajectory, s: Array, feet: Array) -> Array:
    """Along the path `(M,)`, where it is nearest to each foothold around its time, m."""
    found = np.empty(len(feet))
    for m, (down, up, _, x, y, _) in enumerate(feet):
        first, last = np.searchsorted(path.time, (down - 0.5, up + 0.5))
        first = min(first, len(s) - 1)  # robots in physics may step on after their plan's end
        piece = slice(int(first), max(int(last), int(first) + 1))
        away = np.hypot(path.position[piece, 0] - x, path.position[piece, 1] - y)
        found[m] = s[piece][int(np.argmin(away))]
    return found


def _draw_legend(axes: Axes, stepping: bool) -> None:
    names = {"walking": style.WALKING, "take-off, landing": _PUSH, "flight": style.FLYING}
    handles = [style.key(name, color=color, linewidth=1.4) for name, color in names.items()]
    handles.append(style.key("ground", color=_EARTH, linewidth=0.8))
    if stepping:
        color = style.LEGS[0][1]
        foot = style.mark("o", 2.0, color, 1.0, color)
        handles.append(style.key("footholds (colours as in footholds.png)", **foot))
    draw_legend(axes, handles)
