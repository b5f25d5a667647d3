"""One trial in one panel: the driven paths, and where it was tightest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import draw_driven, draw_goals, draw_outline, draw_robot
from cavalcade.drawing.distances import obstacle_distances
from cavalcade.drawing.maps import draw_arena, draw_tracks, map_figure
from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array, transform_points

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from cavalcade.recording.frames import Recording
    from cavalcade.robots import RobotModel
    from cavalcade.scenario import Scenario, World

_MARGINS = style.Margins(left=0.36, right=0.06, bottom=0.46, top=0.20)
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

    The ground is that at the start. Gives the file, or None for a recording without a cycle.

    Raises:
        OutputError: It cannot be written.
    """
    if len(recording.time) == 0:
        return None
    scene, time = Scene(scenario, world, recording), recording.time
    with style.paper_style():
        figure, axes = map_figure(scene.view(), _MARGINS, 5.4, 4.6, narrowest=3.0)
        draw_arena(axes, scene)
        found = tightest(scene)
        moment = len(time) - 1 if found is None else found.cycle
        draw_tracks(axes, recording.obstacles, float(time[moment]))
        draw_goals(axes, recording.status[-1])
        for robot, model in enumerate(scene.models):
            poses, color = recording.poses[:, robot], style.robot_color(robot)
            draw_driven(axes, poses, robot)
            draw_robot(axes, poses[0], model, color, hollow=True)
            draw_robot(axes, poses[-1], model, color)
        note = _draw_tightest(axes, scene, found, summary)
        reason = str(summary.get("reason") or "")
        axes.set_title(f"{reason}, $t$ = {time[-1]:.1f} s", loc="left", pad=3)
        place = (_MARGINS.left / figure.get_figwidth(), 0.05 / figure.get_figheight())
        figure.text(*place, note, fontsize=7, color=style.LIMIT, va="bottom")
        return style.save(figure, path, dpi=200)


def _draw_tightest(
    axes: Axes, scene: Scene, found: Tightest | None, summary: Mapping[str, Any]
) -> str:
    """Ring the tightest place, with the bodies as they stood; returns the line that says so."""
    if found is None:
        return ""
    collisions = summary.get("collisions") or {}
    hits = sum(int(value or 0) for value in collisions.values())
    for pose, model in zip(scene.recording.poses[found.cycle], scene.models, strict=True):
        draw_outline(axes, pose, model, edgecolor=style.INK, linewidth=0.5, zorder=6.3)
    axes.plot(*found.place, **style.mark("o", 11, style.LIMIT, 1.1, "none"), zorder=9)
    if hits:
        axes.plot(*found.place, **style.mark("x", 5.5, style.LIMIT, 1.3), zorder=9.1)
    when = f"$t$ = {scene.recording.time[found.cycle]:.1f} s"
    if hits:
        return f"{hits} contact{'s' * (hits > 1)}; ring and outlines: {when}"
    gap = summary.get("min_footprint_gap_m")
    known = f" {gap:.3f} m" if isinstance(gap, float) else ""
    return f"smallest gap{known}; ring and outlines: {when}"


def tightest(scene: Scene) -> Tightest | None:
    """The cycle and place where an outline, taken as points, came closest to anything.

    None for a robot alone in a world without end.
    """
    time, poses = scene.recording.time, scene.recording.poses
    outlines = [_outline(model) for model in scene.models]
    points = max(len(outline) for outline in outlines)
    stride = max(1, len(time) * scene.size * points // _MOST_POINTS)
    last = len(time) - 1
    cycles = np.unique([*range(0, last, stride), last])
    best: Tightest | None = None
    for robot, outline in enumerate(outlines):
        places = np.stack([transform_points(poses[k, robot], outline) for k in cycles])
        headed = np.concatenate([places, np.zeros((*places.shape[:2], 1))], axis=2)
        seen = replace(scene.recording, time=time[cycles], poses=headed)
        gaps = obstacle_distances(replace(scene, recording=seen))
        for other, model in enumerate(scene.models):
            if other != robot:
                away = _body_distance(places, poses[cycles, other], model)
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
