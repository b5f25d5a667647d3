"""Drawing the arena and the team on matplotlib axes; all lengths in m, map frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.outlines import body_ring
from cavalcade.drawing.scene import Arena, Track
from cavalcade.geometry import Array, inverse_transform_points, transform_points
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def set_view(axes: Axes, view: Array) -> None:
    """Show the part `(4,)` (lowest x, lowest y, highest x, highest y) to scale."""
    axes.set_xlim(view[0], view[2])
    axes.set_ylim(view[1], view[3])
    axes.set_aspect("equal", adjustable="box")


def set_ticks(axes: Axes, view: Array, inches: float, *, first: bool = True) -> None:
    """The same round steps on both axes; labels of neighbouring panels keep their distance."""
    from matplotlib.ticker import MaxNLocator

    span = view[2:] - view[:2]
    most = max(2, min(8, int(inches / 0.3)))
    longest = float(span.max()) if span[0] >= 0.5 * span[1] else float(2.0 * span[0])
    steps = MaxNLocator(nbins=most, steps=[1, 2, 5, 10]).tick_values(0.0, longest)
    step = float(steps[1] - steps[0])
    for axis, (low, high) in enumerate(zip(view[:2], view[2:], strict=True)):
        ticks = np.arange(np.ceil(low / step - 1e-6), np.floor(high / step + 1e-6) + 1) * step
        if axis == 0 and not first:
            ticks = ticks[ticks > low + 0.06 * span[0]]
        (axes.set_xticks, axes.set_yticks)[axis](ticks)


def fill_rings(axes: Axes, rings: Iterable[Array], **options: Any) -> None:
    """Fill rings `(K, 2)` together, so that clockwise ones are holes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    closed = [np.concatenate([ring, ring[:1]]) for ring in rings]
    if not closed:
        return
    codes = []
    for ring in closed:
        codes += [Path.MOVETO, *[Path.LINETO] * (len(ring) - 2), Path.CLOSEPOLY]
    axes.add_patch(PathPatch(Path(np.concatenate(closed), codes), **options))


def draw_arena(axes: Axes, arena: Arena) -> None:
    """The map's border, unknown ground, walls and shapes."""
    from matplotlib.patches import Polygon

    fill_rings(axes, arena.unknown, facecolor=style.UNKNOWN, edgecolor="none", zorder=0.5)
    fill_rings(
        axes, arena.walls, facecolor=style.WALL, edgecolor=style.WALL, linewidth=0.2, zorder=1
    )
    # Edges below, fills above: shapes that overlap show one common outline.
    for ring in arena.shapes:
        axes.add_patch(Polygon(ring, fill=False, edgecolor=style.INK, linewidth=0.7, zorder=1.05))
        axes.add_patch(Polygon(ring, facecolor=style.SHAPE, edgecolor="none", zorder=1.1))
    axes.add_patch(
        Polygon(arena.border, fill=False, edgecolor=style.INK, linewidth=0.9, zorder=1.2)
    )


def draw_tracks(axes: Axes, tracks: Iterable[Track], time: float) -> None:
    """Obstacles of events as they stand at that time, with the way they came."""
    from matplotlib.patches import Polygon

    for track in tracks:
        if not track.start <= time < track.end:
            continue
        offset = track.offset_at(time)
        axes.add_patch(
            Polygon(
                track.ring + offset,
                facecolor="#d9b8a5",
                edgecolor=style.MOVER,
                linewidth=0.6,
                hatch="//////",
                zorder=1.15,
            )
        )
        travelled = track.ring.mean(axis=0) + track.offset[track.time <= time]
        if len(travelled) > 1:
            way = np.vstack([travelled, track.ring.mean(axis=0) + offset])
            axes.plot(*way.T, color=style.MOVER, linewidth=0.6, linestyle=":", zorder=1.14)


def draw_robot(
    axes: Axes,
    pose: Array,
    model: RobotModel,
    color: str,
    *,
    leader: bool = False,
    lost: bool = False,
    star: float = 5.0,
) -> None:
    """A robot as its oriented footprint with a bright head; the leader carries a star."""
    from matplotlib.patches import Polygon

    axes.add_patch(
        Polygon(
            body_ring(pose, model),
            facecolor="white" if lost else color,
            edgecolor=color if lost else style.INK,
            linewidth=0.45,
            zorder=6,
        )
    )
    front, half = model.length / 2.0, model.width / 2.0
    nose = [(front, 0.0), (front * 0.45, half * 0.72), (front * 0.45, -half * 0.72)]
    axes.add_patch(
        Polygon(
            transform_points(pose, nose),
            facecolor=color if lost else "white",
            edgecolor="none",
            zorder=6.1,
        )
    )
    if leader:
        axes.plot(
            *transform_points(pose, [(-0.16 * model.length, 0.0)]).T,
            marker="*",
            markersize=star,
            markerfacecolor="#ffe14d",
            markeredgecolor=style.INK,
            markeredgewidth=0.35,
            linestyle="none",
            zorder=9,
        )


def draw_springs(axes: Axes, positions: Array, status: PlannerStatus) -> None:
    """The springs between connected robots, as thin lines."""
    for a, b in np.asarray(status.connections, dtype=int).reshape(-1, 2):
        axes.plot(
            *positions[[a, b]].T, color=style.INK, linewidth=0.55, alpha=0.75, zorder=4, dashes=()
        )


def draw_goals(axes: Axes, status: PlannerStatus, size: float = 3.2) -> None:
    """The formation's goal (slots and heading) and each robot's present goal."""
    if status.state == "inactive":
        return
    if status.goal is not None and len(status.slots):
        slots = transform_points(status.goal, status.slots)
        axes.plot(
            *slots.T,
            marker="+",
            markersize=size + 0.6,
            markeredgewidth=0.6,
            color=style.GREY,
            linestyle="none",
            zorder=3,
        )
        draw_heading(axes, status.goal)
    for robot, goal in enumerate(status.goals):
        if status.roles[robot] < 0:
            continue
        axes.plot(
            *goal,
            marker="o",
            markersize=size,
            markerfacecolor="white",
            markeredgecolor=style.robot_color(robot),
            markeredgewidth=0.8,
            zorder=5,
        )


def draw_heading(axes: Axes, pose: Array, length: float = 0.55) -> None:
    """A small arrow for a goal's place and heading."""
    tip = transform_points(pose, [(length, 0.0)])[0]
    axes.annotate(
        "",
        xy=tuple(tip),
        xytext=(pose[0], pose[1]),
        arrowprops={
            "arrowstyle": "-|>,head_length=0.22,head_width=0.11",
            "color": style.GREY,
            "linewidth": 0.6,
            "shrinkA": 0,
            "shrinkB": 0,
        },
        annotation_clip=True,
        zorder=3,
    )


def label_places(poses: Array, models: Sequence[RobotModel], view: Array, gap: float) -> Array:
    """Places `(N, 2)` for one label per robot, clear of all robots and of each other.

    Args:
        poses: `(N, 3)` robots' poses.
        models: Their models.
        view: `(4,)` the part that is shown.
        gap: Space between a body's edge and the middle of its label, m.
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
