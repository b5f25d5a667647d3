"""Who is where when: activities, progress along the own path, and the gap to the nearest robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_extreme, draw_legend, draw_lines, stacked_panels
from cavalcade.drawing.plans.motion import FLIES, activities, along
from cavalcade.drawing.scene import PlanScene, runs
from cavalcade.geometry import Array
from cavalcade.geometry.distances import nearest_gaps
from cavalcade.geometry.trajectory import common_clock, team_poses

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = (style.WAITING, style.WALKING, style.FLYING, style.TURNING)
_LABELS = ("stands", "walks", "in flight", "turns on the spot")
_MARGINS = style.Margins(left=0.46, right=0.12, bottom=0.34, top=0.22)
_BETWEEN = 0.14
_FAR = 3.0
"""Gaps are shown up to this, m: what is farther apart is of no concern."""


def draw_timing(scene: PlanScene, path: Path) -> Path | None:
    """Draw it a page wide; None without trajectories."""
    if not scene.known:
        return None
    lanes = min(2.2, max(0.35, 0.13 * scene.size + 0.1))
    heights = [lanes, 1.5, 1.3][: 3 if len(scene.known) > 1 else 2]
    gaps = [_BETWEEN] * (len(heights) - 1)
    span = (0.0, max(scene.makespan, 0.1))
    with style.paper_style():
        figure, panels = stacked_panels(style.PAGE, _MARGINS, heights, gaps, span)
        _draw_lanes(panels[0], scene)
        _draw_progress(panels[1], scene)
        if len(panels) > 2:
            _draw_gaps(panels[2], scene)
        panels[0].set_title(scene.name, loc="left", pad=3)
        if not scene.plan.solved:
            panels[0].text(0.5, 1.02, scene.result[:60], transform=panels[0].transAxes,
                           ha="center", va="bottom", fontsize=7, color=style.LIMIT)  # fmt: skip
        return style.save(figure, path)


def team_gaps(scene: PlanScene) -> tuple[Array, Array]:
    """Times `(K,)` and the gap `(K, n)` from each known body to the nearest other one, m."""
    known = scene.known
    times = common_clock([path for _, path in known])
    poses = np.ascontiguousarray(team_poses([path for _, path in known], times))
    bodies = np.array([scene.models[robot].body for robot, _ in known])
    return times, np.asarray(nearest_gaps(poses, bodies))


def _draw_lanes(axes: Axes, scene: PlanScene) -> None:
    from matplotlib.patches import Patch

    seen = set()
    for robot, path in scene.known:
        for kind, first, last in runs(activities(path)):
            start, stop = float(path.time[first]), float(path.time[last])
            axes.barh(robot, stop - start, left=start, height=0.66, color=_COLOURS[kind], lw=0)
            seen.add(kind)
        rest = scene.makespan - path.duration
        if rest > 1e-9:
            axes.barh(robot, rest, left=path.duration, height=0.2, color=style.WAITING, lw=0)
        axes.plot([path.duration] * 2, [robot - 0.4, robot + 0.4], color=style.INK, linewidth=0.8)
    axes.set_ylim(scene.size - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)
    if scene.size <= 20:
        axes.set_yticks(range(scene.size))
        for robot, label in enumerate(axes.get_yticklabels()):
            label.set_color(style.robot_color(robot))
            label.set_fontweight("bold")
            label.set_fontsize(6.5 if scene.size <= 14 else 5.5)
    axes.set_ylabel("robot", labelpad=2)
    handles = [Patch(color=_COLOURS[kind], label=_LABELS[kind]) for kind in sorted(seen)]
    draw_legend(axes, handles, columnspacing=1.2, handlelength=1.0, handleheight=0.6)


def _draw_progress(axes: Axes, scene: PlanScene) -> None:
    """Travelled length over time: waits are level, flights blue."""
    lines = [(path.time, along(path)) for _, path in scene.known]
    longest = max(float(travelled[-1]) for _, travelled in lines)
    axes.set_ylim(0.0, 1.06 * max(longest, 0.1))
    draw_lines(axes, lines, [style.robot_line(robot) for robot, _ in scene.known], 1.1)
    for (robot, path), (_, travelled) in zip(scene.known, lines, strict=True):
        color = style.robot_color(robot)
        for kind, first, last in runs(activities(path)):
            piece = slice(first, last + 1)
            if kind == FLIES:
                axes.plot(path.time[piece], travelled[piece], color=style.FLYING, linewidth=2.6,
                          zorder=4)  # fmt: skip
        axes.plot(path.duration, travelled[-1], **style.mark("o", 2.4, color, 1.0, color), zorder=5,
                  clip_on=False)  # fmt: skip
    axes.set_ylabel("along own path (m)", labelpad=2)


def _draw_gaps(axes: Axes, scene: PlanScene) -> None:
    """The gap of each footprint to the nearest other one; the smallest is named."""
    times, gaps = team_gaps(scene)
    shown = np.minimum(gaps, _FAR * 1.1)
    row = int(np.argmin(gaps.min(axis=1)))
    least = float(gaps[row].min())
    top = min(_FAR, 1.08 * float(max(shown.max(), 0.2)))
    axes.axhline(0.0, color=style.LIMIT, linewidth=0.8)
    axes.set_ylim(-0.04 * top, top)
    looks = [style.robot_line(robot) for robot, _ in scene.known]
    draw_lines(axes, [(times, line) for line in shown.T], looks, 0.9)
    draw_extreme(axes, times[row], least, f"least {least:.2f} m at {times[row]:.1f} s", rise=9)
    axes.set_ylabel("footprint gap (m)", labelpad=2)
