"""The team on a map: robots, what holds them together, their goals; all lengths in m, map frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.maps import add_polygon, points_per_metre
from cavalcade.drawing.outlines import body_ring
from cavalcade.geometry import Array, inverse_transform_points, transform_points
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STAR = "#ffe14d"
SMALL = 6.0
"""A body shorter than this, in points, needs a dot to be seen."""


def draw_robot(
    axes: Axes,
    pose: Array,
    model: RobotModel,
    color: str,
    *,
    leader: bool = False,
    hollow: bool = False,
) -> None:
    """A robot as its oriented footprint with a bright head; the leader carries a star."""
    body = model.length * points_per_metre(axes)
    face, head, edge = ("white", color, color) if hollow else (color, "white", style.INK)
    if body < SMALL:
        dot = style.mark("o", 4.2, color if hollow else "white", 0.3, face)
        axes.plot(*pose[:2], **dot, zorder=5.8)
    ring = body_ring(pose, model)
    add_polygon(axes, ring, facecolor=face, edgecolor=edge, linewidth=0.45, zorder=6)
    _draw_head(axes, pose, model, head, 6.1)
    if leader:
        star = style.mark("*", min(6.0, max(3.6, 0.75 * body)), style.INK, 0.35, STAR)
        axes.plot(*transform_points(pose, [(-0.16 * model.length, 0.0)]).T, **star, zorder=9)


def draw_own_goal(axes: Axes, pose: Array, model: RobotModel, color: str) -> None:
    """The goal of a single robot: its footprint there, dashed."""
    ring = body_ring(pose, model)
    add_polygon(axes, ring, facecolor="white", alpha=0.85, edgecolor="none", zorder=4.6)
    draw_outline(axes, pose, model, edgecolor=color, linewidth=1.0, linestyle=(0, (2.2, 1.1)),
                 zorder=4.8)  # fmt: skip
    _draw_head(axes, pose, model, color, 4.9)


def draw_outline(axes: Axes, pose: Array, model: RobotModel, **options: Any) -> None:
    """The footprint's edge alone."""
    add_polygon(axes, body_ring(pose, model), fill=False, **options)


def _draw_head(axes: Axes, pose: Array, model: RobotModel, color: str, zorder: float) -> None:
    front, half = model.length / 2.0, model.width / 2.0
    nose = [(front, 0.0), (front * 0.45, half * 0.72), (front * 0.45, -half * 0.72)]
    ring = transform_points(pose, nose)
    add_polygon(axes, ring, facecolor=color, edgecolor="none", zorder=zorder)


def draw_driven(axes: Axes, poses: Array, robot: int, **options: Any) -> None:
    """The line of a robot's poses `(T, 3)` so far."""
    look = {**style.robot_line(robot), "linewidth": 0.9, "zorder": 2.5, **options}
    axes.plot(*poses[:, :2].T, **look)


def draw_springs(axes: Axes, positions: Array, status: PlannerStatus) -> None:
    """The springs between connected robots, as thin lines."""
    for a, b in np.asarray(status.connections, dtype=int).reshape(-1, 2):
        axes.plot(
            *positions[[a, b]].T, color=style.INK, linewidth=0.55, alpha=0.75, zorder=4, dashes=()
        )


def draw_goals(axes: Axes, status: PlannerStatus) -> None:
    """The formation's goal (slots and heading) and each robot's present goal."""
    if status.state == "inactive":
        return
    if status.goal is not None and len(status.slots):
        slots = transform_points(status.goal, status.slots)
        axes.plot(*slots.T, **style.mark("+", 3.8, style.GREY, 0.6), zorder=3)
        draw_heading(axes, status.goal)
    for robot, goal in enumerate(status.goals):
        if status.roles[robot] >= 0:
            axes.plot(*goal, **style.mark("o", 3.2, style.robot_color(robot)), zorder=5)


def draw_team_goal(axes: Axes, goal: Array) -> None:
    """The place of a formation's goal."""
    axes.plot(*goal[:2], **style.mark("D", 4.2, style.INK, 0.9), zorder=5.5)


def draw_heading(axes: Axes, pose: Array, length: float = 0.55) -> None:
    """A small arrow for a goal's place and heading."""
    tip = transform_points(pose, [(length, 0.0)])[0]
    draw_arrow(axes, pose, tip, style.GREY, "-|>,head_length=0.22,head_width=0.11", 3)


def draw_arrow(
    axes: Axes, start: Array, tip: Array, color: str, head: str = "-|>", zorder: float = 1.35
) -> None:
    """A thin arrow between two places, as far as it lies on the map."""
    from matplotlib.patches import FancyArrowPatch

    look: Any = {"arrowstyle": head, "color": color, "linewidth": 0.6, "mutation_scale": 8.0}
    arrow = FancyArrowPatch(tuple(start[:2]), tuple(tip), shrinkA=0, shrinkB=0, **look)
    arrow.set_zorder(zorder)
    axes.add_patch(arrow)


def label_places(poses: Array, models: Sequence[RobotModel], view: Array, gap: float) -> Array:
    """Places `(N, 2)` for one label per robot, clear of all robots and of each other.

    `gap`: between a body's edge and the middle of its label, m.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    centre = poses[:, :2].mean(axis=0)
    low, high = view[:2] + gap, view[2:] - gap
    placed: list[Array] = []
    for robot, (pose, model) in enumerate(zip(poses, models, strict=True)):
        # Distance from the centre to the body's edge in each direction.
        c, s = np.abs(np.cos(angles)), np.abs(np.sin(angles))
        edge = np.minimum(
            model.length / 2.0 / np.maximum(c, 1e-9), model.width / 2.0 / np.maximum(s, 1e-9)
        )
        ring = np.column_stack([np.cos(angles), np.sin(angles)]) * (edge + gap)[:, None]
        options = transform_points(pose, ring)
        cost = 0.8 * c  # rather beside the body than before or behind it, where its path is
        for other, (place, shape) in enumerate(zip(poses, models, strict=True)):
            if other != robot:
                local = np.abs(inverse_transform_points(place, options))
                beyond = np.maximum(local - (shape.length / 2.0, shape.width / 2.0), 0.0)
                cost += 12.0 * np.maximum(0.0, 1.5 * gap - np.hypot(*beyond.T)) / gap
        for label in placed:
            cost += 12.0 * np.maximum(0.0, 2.2 * gap - np.hypot(*(options - label).T)) / gap
        cost -= 0.6 * np.hypot(*(options - centre).T)
        cost += 100.0 * ((options < low) | (options > high)).any(axis=1)
        placed.append(options[int(np.argmin(cost))])
    return np.array(placed).reshape(-1, 2)
