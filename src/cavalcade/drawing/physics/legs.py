"""What the legs did in a run in physics: speeds, height of the trunk, torques, and the gait."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.charts import (
    draw_extreme,
    draw_grid,
    draw_legend,
    draw_limit,
    draw_lines,
    draw_note,
    stacked_panels,
)
from cavalcade.drawing.physics.signals import (
    busiest_window,
    loaded_spans,
    peaks,
    planar_speed,
    spread,
)
from cavalcade.drawing.scene import runs
from cavalcade.geometry import GRAVITY, Array
from cavalcade.recording.physics_track import LOADED, PhysicsTrack
from cavalcade.robots.description import QuadrupedDescription

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARGINS = style.Margins(left=0.47, right=0.34, bottom=0.34, top=0.24)
_MOST_ROWS = 8
"""Robots with a row of their own."""

_WINDOW = 3.0
"""Of the gait diagram, s."""

_COMMANDED, _FLIGHT = "#9aa0a6", "#cfdcfa"


def draw_legs(
    name: str,
    track: PhysicsTrack,
    robots: Sequence[QuadrupedDescription],
    commands: tuple[Array, Array],
    path: Path,
) -> Path:
    """Draw it a page wide.

    `commands`: times `(K,)` s on the track's clock, and the body-frame velocities `(K, N, 3)`
    that hold from then on.
    """
    from matplotlib.patches import Patch

    rows = min(track.size, _MOST_ROWS)
    heights, gaps = [0.42] * rows + [1.0, 1.0], [0.05] * (rows - 1) + [0.16] * 2
    span = (float(track.time[0]), float(track.time[-1]))
    with style.paper_style():
        figure, panels = stacked_panels(style.PAGE, _MARGINS, heights, gaps, span)
        _draw_speeds(panels[:rows], track, commands)
        _draw_height(panels[rows], track, [one.stand_height for one in robots])
        _draw_torques(panels[rows + 1], track, np.array([one.torque_limits for one in robots]))
        panels[0].set_title(name, loc="left", pad=3)
        handles: list[Any] = [
            style.key("real", color=style.INK, linewidth=1.0),
            style.key("commanded", color=_COMMANDED, linewidth=0.8),
        ]
        if track.flying.any():
            handles.append(Patch(facecolor=_FLIGHT, edgecolor="none", label="in flight"))
        if track.contacts:
            handles.append(style.key("unwanted contact", **style.mark("|", 5, style.LIMIT, 1.0)))
        draw_legend(panels[0], handles, columnspacing=1.2)
        return style.save(figure, path)


def draw_gait(
    name: str, track: PhysicsTrack, robots: Sequence[QuadrupedDescription], path: Path
) -> Path:
    """Draw it a page wide, robot by robot; bars as strong as what they carry."""
    rows = min(track.size, _MOST_ROWS)
    heights, gaps = [0.56] * rows, [0.09] * (rows - 1)
    span = busiest_window(track, _WINDOW)
    with style.paper_style():
        figure, panels = stacked_panels(style.PAGE, _MARGINS, heights, gaps, span)
        for robot, axes in enumerate(panels):
            _draw_feet(axes, track, robot, GRAVITY * robots[robot].mass)
            axes.set_xlim(*span)
            _number_row(axes, robot)
        panels[0].set_title(f"{name}: feet that carry", loc="left", pad=3)
        panels[0].set_title("full colour: half the weight", loc="right", pad=3, fontsize=7,
                            color=style.GREY)  # fmt: skip
        return style.save(figure, path)


def _number_row(axes: Axes, robot: int) -> None:
    """The robot's number on the right of its row."""
    style.note(axes, str(robot), (1.0, 0.5), (4, 0), xycoords="axes fraction", va="center",
               fontsize=8, fontweight="bold", color=style.robot_color(robot))  # fmt: skip


def _draw_speeds(
    panels: Sequence[Axes], track: PhysicsTrack, commands: tuple[Array, Array]
) -> None:
    """Each robot's speed over ground in a row of its own, and what was commanded."""
    speed = planar_speed(track)
    times, wanted = commands[0], np.linalg.norm(commands[1][..., :2], axis=2)
    top = max(1.15 * float(np.quantile(np.concatenate([speed, wanted]), 0.998)), 0.1)
    # Two or three round ticks from 0.
    step = next(s for s in (0.05, 0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 5.0, 1e9) if top / s < 2.6)
    for robot, axes in enumerate(panels):
        axes.step(times, wanted[:, robot], where="post", color=_COMMANDED, linewidth=0.6,
                  zorder=2)  # fmt: skip
        axes.plot(track.time, speed[:, robot], color=style.robot_color(robot), linewidth=1.0,
                  zorder=3)  # fmt: skip
        axes.set_ylim(0.0, top)
        axes.set_yticks(np.arange(0.0, top, step))
        draw_grid(axes, "y")
        _number_row(axes, robot)
        _mark_events(axes, track, robot)
    rows = len(panels)
    panels[rows // 2].set_ylabel("speed (m/s)", labelpad=3, y=0.5 if rows % 2 else 1.06)


def _draw_height(axes: Axes, track: PhysicsTrack, stand: list[float]) -> None:
    """Mean height of each trunk over about a cycle, and what it sways between.

    Where robots leap it is the height itself.
    """
    times, (low, mean, high) = spread(track.time, track.base[..., 2], columns=300)
    if track.flying.any():
        times, mean = track.time, track.base[..., 2]
        low = high = mean
    for robot in range(track.size):
        axes.fill_between(times, low[:, robot], high[:, robot], color=style.robot_color(robot),
                          alpha=0.22, linewidth=0.0, zorder=2.5)  # fmt: skip
    bottom, top = float(low.min()), float(high.max())
    if top - bottom < 0.25:
        for level in sorted(set(stand)):
            axes.axhline(level, color=style.INK, linewidth=0.6, linestyle=(0, (1, 1.6)), zorder=2)
            draw_note(axes, level, "stands", style.GREY)
        bottom, top = min(bottom, *stand), max(top, *stand)
    # Millimetres are not to look like centimetres.
    pad = max(0.12 * (top - bottom), 0.5 * (0.06 - (top - bottom)))
    axes.set_ylim(bottom - pad, top + pad)
    looks = [style.robot_line(robot) for robot in range(track.size)]
    draw_lines(axes, [(times, line) for line in mean.T], looks, 1.0)
    draw_grid(axes, "y")
    axes.set_ylabel("trunk height (m)", labelpad=3)


def _draw_torques(axes: Axes, track: PhysicsTrack, limits: Array) -> None:
    """The largest torque of each robot's joints in shares of their limits; the worst is named."""
    share: Array = np.abs(track.torques) / limits
    times, highest = peaks(track.time, 100.0 * share.max(axis=2), columns=500)
    axes.set_ylim(0.0, 116.0)
    looks = [style.robot_line(robot) for robot in range(track.size)]
    draw_lines(axes, [(times, line) for line in highest.T], looks, 0.7)
    draw_limit(axes, 100.0, 200.0, "limit")
    when, worst, joint = np.unravel_index(int(np.argmax(share)), share.shape)
    value = 100.0 * float(share[when, worst, joint])
    part = f"{('hip', 'thigh', 'calf')[joint % 3]} {style.LEGS[joint // 3][0]}"
    text = f"{value:.0f} %: {part}, robot {worst}"
    draw_extreme(axes, float(track.time[when]), value, text, rise=5 if value < 90.0 else -9)
    draw_grid(axes, "y")
    axes.set_ylabel("largest torque (%)", labelpad=3)


def _mark_events(axes: Axes, track: PhysicsTrack, robot: int) -> None:
    """Flights in blue, unwanted contacts as ticks below, the time after a fall in red."""
    for flying, first, last in runs(track.flying[:, robot].tolist()):
        if flying:
            span = (float(track.time[max(first - 1, 0)]), float(track.time[last - 1]))
            axes.axvspan(*span, facecolor=_FLIGHT, edgecolor="none", zorder=0.4)
    hits = [event.time for event in track.contacts if event.robot == robot]
    tick = style.mark("|", 5, style.LIMIT, 1.0)
    axes.plot(hits, np.zeros(len(hits)), **tick, clip_on=False, zorder=5)
    fall = next((event.time for event in track.falls if event.robot == robot), None)
    if fall is not None:
        end = float(track.time[-1])
        axes.axvspan(fall, end, facecolor=style.BEYOND, edgecolor="none", zorder=0.4)
        top = axes.get_xaxis_transform()
        style.note(axes, "fell", (fall, 1.0), (2, -2), xycoords=top, va="top", color=style.LIMIT)


def _draw_feet(axes: Axes, track: PhysicsTrack, robot: int, weight: float) -> None:
    from matplotlib.colors import to_rgb

    start, end = axes.get_xlim()
    force = track.foot_forces[:, robot, :, 2]
    color = np.array(to_rgb(style.robot_color(robot)))
    inside = (track.time > start - 0.1) & (track.time < end + 0.1)
    rows = np.flatnonzero(inside)
    share = np.clip(force[rows] / (0.5 * weight), 0.0, 1.0)
    strength = np.where(force[rows] >= LOADED, 0.18 + 0.82 * share, 0.0).T[..., None]
    image = 1.0 - strength * (1.0 - color)
    # A sample tells of the time since the one before.
    edges = np.concatenate([[track.time[max(rows[0] - 1, 0)]], track.time[rows]])
    for leg in range(4):
        axes.pcolormesh(edges, [leg - 0.39, leg + 0.39], image[leg][None], rasterized=True)
        for first, last in loaded_spans(track.time, force[:, leg]):
            if last > start and first < end:
                axes.plot([first, last, last, first, first],
                          [leg - 0.39, leg - 0.39, leg + 0.39, leg + 0.39, leg - 0.39],
                          color=0.75 * color, linewidth=0.4)  # fmt: skip
    axes.set_ylim(3.6, -0.6)
    axes.set_yticks(range(4), ("FL", "FR", "RL", "RR"))
    axes.tick_params(axis="y", length=0)
    draw_grid(axes, "x")
