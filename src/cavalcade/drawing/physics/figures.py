"""Figures of a run in physics: how well the legs carried it out, and how they did it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.drawing.physics.signals import (
    LOADED,
    busiest_window,
    loaded_spans,
    peaks,
    planar_speed,
    spread,
    torque_share,
)
from cavalcade.drawing.physics.skeleton import descriptions_of
from cavalcade.geometry import Array
from cavalcade.geometry.constants import GRAVITY
from cavalcade.recording.physics_track import PhysicsTrack

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cavalcade.scenario import Scenario

LEGS_FIGURE, GAIT_FIGURE = "legs.png", "gait.png"

_LEFT, _RIGHT, _BOTTOM, _TOP = 0.47, 0.34, 0.34, 0.24
_ROW, _PANEL, _GAP, _BETWEEN = 0.42, 1.0, 0.05, 0.16
_MOST = 8
"""Robots with a row of their own."""

_WINDOW = 3.0
"""Of the gait diagram, s."""

_LEGS = ("front left", "front right", "rear left", "rear right")


def make_physics_figures(
    scenario: Scenario,
    track: PhysicsTrack,
    commands_time: Array | None,
    commands: Array | None,
    out_dir: str | Path,
) -> list[Path]:
    """Draw what the legs did into `out_dir`, which is made if it is missing.

    Args:
        scenario: The scenario that was run.
        track: What the robots did.
        commands_time: `(K,)` s, on the track's clock, and
        commands: `(K, N, 3)` body-frame velocities that hold from then on; None for none.
        out_dir: Where the pictures go.

    Returns:
        `legs.png` (speeds, height of the trunk, torques) and `gait.png` (which feet carry how much
        over three seconds); nothing of a track with less than two samples.

    Raises:
        OutputError: A picture cannot be written.
        RecordingError: The track is not that of the scenario's robots.
    """
    if len(track.time) < 2:
        return []
    descriptions = descriptions_of(scenario, track)
    folder = style.make_directory(out_dir)
    limits = np.array([one.torque_limits for one in descriptions])
    weights = np.array([GRAVITY * one.mass for one in descriptions])
    stand = [one.stand_height for one in descriptions]
    with style.paper_style():
        return [
            _draw_legs(scenario, track, commands_time, commands, limits, stand, folder),
            _draw_gait(scenario, track, weights, folder),
        ]


def _draw_legs(
    scenario: Scenario,
    track: PhysicsTrack,
    commands_time: Array | None,
    commands: Array | None,
    limits: Array,
    stand: list[float],
    folder: Path,
) -> Path:
    rows = min(track.size, _MOST)
    heights = [_ROW] * rows + [_PANEL, _PANEL]
    gaps = [_GAP] * (rows - 1) + [_BETWEEN] * 2
    figure, panels = _stacked(heights, gaps)
    for axes in panels:
        axes.set_xlim(float(track.time[0]), float(track.time[-1]))
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
    speed = planar_speed(track)
    wanted = None if commands is None else np.linalg.norm(commands[..., :2], axis=2)
    seen = speed if wanted is None else np.concatenate([speed, wanted])
    top = max(1.15 * float(np.quantile(seen, 0.998)), 0.1)
    for robot, axes in enumerate(panels[:rows]):
        if commands_time is not None and wanted is not None:
            axes.step(commands_time, wanted[:, robot], where="post", color="#9aa0a6",
                      linewidth=0.6, zorder=2)  # fmt: skip
        axes.plot(track.time, speed[:, robot], color=style.robot_color(robot), linewidth=1.0,
                  zorder=3)  # fmt: skip
        axes.set_ylim(0.0, top)
        axes.grid(True, axis="y", linewidth=0.3, color="#e3e5e8")
        axes.annotate(str(robot), (1.0, 0.5), xytext=(4, 0), xycoords="axes fraction",
                      textcoords="offset points", va="center", fontsize=8, fontweight="bold",
                      color=style.robot_color(robot))  # fmt: skip
        axes.set_yticks(_few(top))
        _mark_events(axes, track, robot)
    panels[rows // 2].set_ylabel("speed (m/s)", labelpad=3, y=0.5 if rows % 2 else 1.06)
    _draw_height(panels[rows], track, stand)
    _draw_torques(panels[rows + 1], track, limits)
    panels[-1].set_xlabel("time (s)", labelpad=1)
    panels[0].set_title(str(scenario.name), loc="left", pad=3)
    _explain(panels[0], track, wanted is not None)
    return style.save(figure, folder / LEGS_FIGURE)


def _draw_height(axes: Axes, track: PhysicsTrack, stand: list[float]) -> None:
    """Mean height of each trunk over about a cycle, and what it sways between."""
    times, (low, mean, high) = spread(track.time, track.base[..., 2], columns=300)
    for robot in range(track.size):
        color = style.robot_color(robot)
        axes.fill_between(times, low[:, robot], high[:, robot], color=color, alpha=0.22,
                          linewidth=0.0, zorder=2.5)  # fmt: skip
        axes.plot(times, mean[:, robot], color=color, linewidth=1.0,
                  linestyle=style.robot_dash(robot), zorder=3)  # fmt: skip
    bottom, top = float(low.min()), float(high.max())
    if top - bottom < 0.25:
        for level in sorted(set(stand)):
            axes.axhline(level, color=style.INK, linewidth=0.6, linestyle=(0, (1, 1.6)), zorder=2)
            _note(axes, level, "stands", style.GREY)
        bottom, top = min(bottom, *stand), max(top, *stand)
    # Millimetres are not to look like centimetres.
    pad = max(0.12 * (top - bottom), 0.5 * (0.06 - (top - bottom)))
    axes.set_ylim(bottom - pad, top + pad)
    axes.grid(True, axis="y", linewidth=0.3, color="#e3e5e8")
    axes.set_ylabel("trunk height (m)", labelpad=3)


def _draw_torques(axes: Axes, track: PhysicsTrack, limits: Array) -> None:
    """The largest torque of each robot's joints in shares of their limits; the worst is named."""
    share = torque_share(track, limits)
    largest = 100.0 * share.max(axis=2)
    times, highest = peaks(track.time, largest, columns=500)
    for robot in range(track.size):
        axes.plot(times, highest[:, robot], color=style.robot_color(robot), linewidth=0.7,
                  linestyle=style.robot_dash(robot), zorder=3)  # fmt: skip
    axes.axhline(100.0, color=style.LIMIT, linewidth=0.8, linestyle=(0, (5, 2)), zorder=2.4)
    axes.axhspan(100.0, 200.0, facecolor="#f6d5d9", edgecolor="none", alpha=0.55, zorder=0.4)
    _note(axes, 100.0, "limit", style.LIMIT)
    when, worst, joint = np.unravel_index(int(np.argmax(share)), share.shape)
    value = 100.0 * float(share[when, worst, joint])
    at = float(track.time[when])
    late = at > track.time[0] + 0.7 * track.duration
    axes.plot(at, value, marker="o", markersize=3.2, markerfacecolor="white",
              markeredgecolor=style.INK, markeredgewidth=0.8, zorder=6)  # fmt: skip
    axes.annotate(
        f"{value:.0f} %: {('hip', 'thigh', 'calf')[joint % 3]} {_LEGS[joint // 3]}, robot {worst}",
        (at, value), xytext=(-5 if late else 5, 5), textcoords="offset points", fontsize=7,
        ha="right" if late else "left", zorder=7,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.6},
    )  # fmt: skip
    axes.set_ylim(0.0, 116.0)
    axes.grid(True, axis="y", linewidth=0.3, color="#e3e5e8")
    axes.set_ylabel("largest torque (%)", labelpad=3)


def _draw_gait(scenario: Scenario, track: PhysicsTrack, weights: Array, folder: Path) -> Path:
    """Which feet carry, robot by robot; bars as strong as what they carry."""
    rows = min(track.size, _MOST)
    figure, panels = _stacked([0.56] * rows, [0.09] * (rows - 1))
    start, end = busiest_window(track, _WINDOW)
    for robot, axes in enumerate(panels):
        _draw_feet(axes, track, robot, float(weights[robot]), start, end)
        axes.set_xlim(start, end)
        axes.tick_params(labelbottom=axes is panels[-1])
        axes.annotate(str(robot), (1.0, 0.5), xytext=(4, 0), xycoords="axes fraction",
                      textcoords="offset points", va="center", fontsize=8, fontweight="bold",
                      color=style.robot_color(robot))  # fmt: skip
    panels[-1].set_xlabel("time (s)", labelpad=1)
    panels[0].set_title(f"{scenario.name}: feet that carry", loc="left", pad=3)
    panels[0].annotate("full colour: half the weight", (1.0, 1.0), xytext=(0, 3),
                       xycoords="axes fraction", textcoords="offset points", ha="right",
                       va="bottom", fontsize=7, color=style.GREY)  # fmt: skip
    return style.save(figure, folder / GAIT_FIGURE)


def _draw_feet(
    axes: Axes, track: PhysicsTrack, robot: int, weight: float, start: float, end: float
) -> None:
    from matplotlib.colors import to_rgb

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
    axes.grid(True, axis="x", linewidth=0.3, color="#e3e5e8")
    axes.set_axisbelow(True)


def _mark_events(axes: Axes, track: PhysicsTrack, robot: int) -> None:
    """Unwanted contacts as ticks below, the time after a fall in red."""
    hits = [event.time for event in track.contacts if event.robot == robot]
    if hits:
        axes.plot(hits, np.zeros(len(hits)), marker="|", markersize=5, markeredgewidth=1.0,
                  linestyle="none", color=style.LIMIT, clip_on=False, zorder=5)  # fmt: skip
    fall = next((event.time for event in track.falls if event.robot == robot), None)
    if fall is not None:
        axes.axvspan(fall, float(track.time[-1]), facecolor="#f6d5d9", edgecolor="none", zorder=0.4)
        axes.annotate("fell", (fall, 1.0), xycoords=axes.get_xaxis_transform(), xytext=(2, -2),
                      textcoords="offset points", va="top", fontsize=7,
                      color=style.LIMIT)  # fmt: skip


def _explain(axes: Axes, track: PhysicsTrack, commanded: bool) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=style.INK, linewidth=1.0, label="real")]
    if commanded:
        handles.append(Line2D([], [], color="#9aa0a6", linewidth=0.8, label="commanded"))
    if track.contacts:
        handles.append(
            Line2D([], [], color=style.LIMIT, marker="|", linestyle="none", markersize=5,
                   label="unwanted contact")
        )  # fmt: skip
    axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.01),
                ncols=len(handles))  # fmt: skip


def _stacked(heights: list[float], gaps: list[float]) -> tuple[Figure, list[Axes]]:
    """A page-wide figure with panels of these heights one below the other, inches."""
    total = _BOTTOM + _TOP + sum(heights) + sum(gaps)
    figure = style.new_figure(style.PAGE, total)
    width = (style.PAGE - _LEFT - _RIGHT) / style.PAGE
    panels: list[Axes] = []
    top = total - _TOP
    for height, gap in zip(heights, [*gaps, 0.0], strict=True):
        top -= height
        panels.append(figure.add_axes((_LEFT / style.PAGE, top / total, width, height / total)))
        top -= gap
    return figure, panels


def _note(axes: Axes, value: float, text: str, color: str) -> None:
    axes.annotate(text, (1.0, value), xytext=(3, 0), xycoords=axes.get_yaxis_transform(),
                  textcoords="offset points", va="center", fontsize=7, color=color)  # fmt: skip


def _few(top: float) -> NDArray[np.float64]:
    """Two or three round ticks from 0."""
    step = next(s for s in (0.05, 0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 5.0, 1e9) if top / s < 2.6)
    return np.arange(0.0, top, step)
