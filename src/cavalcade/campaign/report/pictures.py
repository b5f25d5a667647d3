"""One trial in one panel: the driven paths, and where it was tightest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.campaign.report.canvas import mark
from cavalcade.drawing import style
from cavalcade.drawing.actors import (
    draw_arena,
    draw_goals,
    draw_robot,
    draw_tracks,
    set_ticks,
    set_view,
)
from cavalcade.drawing.distances import obstacle_distances
from cavalcade.drawing.scene import Scene, scene_of
from cavalcade.geometry import Array, transform_points

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from cavalcade.recording.frames import Recording
    from cavalcade.robots import RobotModel
    from cavalcade.scenario import Scenario, World

_LEFT, _RIGHT, _BOTTOM, _TOP = 0.36, 0.06, 0.46, 0.20
_WIDEST, _TALLEST = 5.4, 4.6
_SMALL = 6.0
"""A body shorter than this, in points, needs a dot to be seen."""
_SPACING = 0.08
_MOST_POINTS = 250_000


@dataclass(frozen=True)
class Tightest:
    """Where a body came closest to something.

    Attributes:
        cycle: Index of the recorded cycle.
        place: `(2,)` point of the body's outline, map frame, m.
        gap: Distance there, m.
    """

    cycle: int
    place: Array
    gap: float


def draw_paths(
    scenario: Scenario,
    world: World,
    recording: Recording,
    summary: Mapping[str, Any],
    path: Path,
) -> Path | None:
    """Draw driven paths over the world, bodies at start (white) and end, and the tightest place.

    Bodies stand there as outlines, and moving obstacles are drawn, as they were at that moment.

    Args:
        scenario: That was run.
        world: Its ground at the start.
        recording: What happened.
        summary: The content of `summary.json`.
        path: The picture to write.

    Returns:
        The file; None for a recording without a single cycle.

    Raises:
        OutputError: It cannot be written.
    """
    if len(recording.time) == 0:
        return None
    scene = scene_of(scenario, world, recording)
    view = scene.view()
    span = view[2:] - view[:2]
    aspect = float(span[1] / span[0])
    width = min(_WIDEST - _LEFT - _RIGHT, _TALLEST / aspect)
    height = width * aspect
    page, total = max(_LEFT + width + _RIGHT, 3.0), _BOTTOM + height + _TOP
    with style.paper_style():
        figure = style.new_figure(page, total)
        axes = figure.add_axes((_LEFT / page, _BOTTOM / total, width / page, height / total))
        set_view(axes, view)
        set_ticks(axes, view, width)
        draw_arena(axes, scene.arena)
        found = tightest(scene, world)
        moment = len(scene.time) - 1 if found is None else found.cycle
        draw_tracks(axes, scene.tracks, float(scene.time[moment]))
        draw_goals(axes, scene.status[-1])
        _draw_team(axes, scene, width * 72.0 / float(span[0]))
        note = _draw_tightest(axes, scene, found, summary)
        axes.set_xlabel("$x$ (m)", labelpad=1)
        axes.set_ylabel("$y$ (m)", labelpad=1)
        reason = str(summary.get("reason") or "")
        axes.set_title(f"{reason}, $t$ = {scene.time[-1]:.1f} s", loc="left", pad=3)
        figure.text(_LEFT / page, 0.05 / total, note, fontsize=7, color=style.LIMIT, va="bottom")
        return style.save(figure, path, dpi=200)


def _draw_team(axes: Axes, scene: Scene, scale: float) -> None:
    """Paths, bodies at the start in white, bodies at the end in colour; `scale` in points per m."""
    for robot, model in enumerate(scene.models):
        color = style.robot_color(robot)
        axes.plot(
            *scene.poses[:, robot, :2].T,
            color=color,
            linestyle=style.robot_dash(robot),
            linewidth=0.9,
            zorder=2.5,
        )
        start, end = scene.poses[0, robot], scene.poses[-1, robot]
        for pose, fill in ((start, "white"), (end, color)):
            if model.length * scale < _SMALL:
                mark(axes, pose[:2], color, 4.2, 0.6, fill=fill, zorder=5.8)
        draw_robot(axes, start, model, color, lost=True)
        draw_robot(axes, end, model, color)


def _draw_tightest(
    axes: Axes, scene: Scene, found: Tightest | None, summary: Mapping[str, Any]
) -> str:
    """Ring the tightest place, with the bodies as they stood; returns the line that says so."""
    if found is None:
        return ""
    collisions = summary.get("collisions") or {}
    hits = sum(int(value or 0) for value in collisions.values())
    for pose, model in zip(scene.poses[found.cycle], scene.models, strict=True):
        corners = np.array(transform_points(pose, _outline(model)))
        axes.plot(*np.vstack([corners, corners[:1]]).T, color=style.INK, linewidth=0.5, zorder=6.3)
    mark(axes, found.place, style.LIMIT, 11, 1.1, fill="none", zorder=9)
    if hits:
        axes.plot(*found.place, marker="x", markersize=5.5, color=style.LIMIT,
                  markeredgewidth=1.3, zorder=9.1)  # fmt: skip
    when = f"$t$ = {scene.time[found.cycle]:.1f} s"
    if hits:
        return f"{hits} contact{'s' * (hits > 1)}; ring and outlines: {when}"
    gap = summary.get("min_footprint_gap_m")
    known = f" {gap:.3f} m" if isinstance(gap, float) else ""
    return f"smallest gap{known}; ring and outlines: {when}"


def tightest(scene: Scene, world: World) -> Tightest | None:
    """The cycle and place where an outline, taken as points, came closest to anything.

    None for a robot alone in a world without end.
    """
    outlines = [_outline(model) for model in scene.models]
    points = max(len(outline) for outline in outlines)
    stride = max(1, len(scene.time) * scene.size * points // _MOST_POINTS)
    cycles = np.arange(0, len(scene.time), stride)
    if cycles[-1] != len(scene.time) - 1:
        cycles = np.append(cycles, len(scene.time) - 1)
    best: Tightest | None = None
    for robot, outline in enumerate(outlines):
        places = np.stack([transform_points(scene.poses[k, robot], outline) for k in cycles])
        headed = np.concatenate([places, np.zeros((*places.shape[:2], 1))], axis=2)
        gaps = obstacle_distances(replace(scene, time=scene.time[cycles], poses=headed), world)
        for other, model in enumerate(scene.models):
            if other != robot:
                away = _body_distance(places, scene.poses[cycles, other], model)
                gaps = np.minimum(gaps, away)
        row, point = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
        gap = float(gaps[row, point])
        if np.isfinite(gap) and (best is None or gap < best.gap):
            best = Tightest(int(cycles[row]), places[row, point], gap)
    return best


def _outline(model: RobotModel) -> Array:
    """Points `(P, 2)` along the footprint's outline, counter-clockwise, body frame."""
    half = np.array([model.length, model.width]) / 2.0
    corners = half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    sides = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        count = int(np.ceil(float(np.hypot(*(b - a))) / _SPACING))
        sides.append(a + np.arange(count)[:, None] / count * (b - a))
    return np.concatenate(sides)


def _body_distance(points: Array, poses: Array, model: RobotModel) -> Array:
    """Distance `(C, P)` of points `(C, P, 2)` to a body at poses `(C, 3)`, 0 inside."""
    off = points - poses[:, None, :2]
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    along = np.abs(c * off[..., 0] + s * off[..., 1]) - model.length / 2.0
    across = np.abs(c * off[..., 1] - s * off[..., 0]) - model.width / 2.0
    return np.asarray(np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0)))
