"""A scenario before it is run: the arena, the team at its starts, its goals, what will happen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import draw_arena, draw_heading, draw_robot, set_ticks, set_view
from cavalcade.drawing.outlines import body_ring, shape_ring
from cavalcade.drawing.scene import arena_of
from cavalcade.geometry import Array, transform_points
from cavalcade.world import shape_from_mapping

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from cavalcade.scenario import Event, Scenario, World

_LEFT, _RIGHT, _BOTTOM, _TOP = 0.36, 0.06, 0.32, 0.22
_TALLEST = 6.5


def draw_overview(scenario: Scenario, world: World, path: Path) -> Path:
    """Draw it as wide as a page or as high as fits; returns the file written."""
    arena = arena_of(world, world.shapes)
    view = arena.bounds
    span = view[2:] - view[:2]
    aspect = float(span[1] / span[0])
    width = min(style.PAGE - _LEFT - _RIGHT, _TALLEST / aspect)
    height = width * aspect
    page, total = _LEFT + width + _RIGHT, _BOTTOM + height + _TOP
    with style.paper_style():
        figure = style.new_figure(page, total)
        axes = figure.add_axes((_LEFT / page, _BOTTOM / total, width / page, height / total))
        set_view(axes, view)
        set_ticks(axes, view, width)
        draw_arena(axes, arena)
        models = scenario.models
        starts = np.array(scenario.starts, dtype=float)
        if world.terrain is not None:
            from cavalcade.drawing.terrain import draw_terrain

            draw_terrain(axes, world.terrain)
        _draw_own_goals(axes, scenario)
        if scenario.task.formation is not None:
            goals = np.array(scenario.task.goals, dtype=float).reshape(-1, 3)
            _draw_goals(axes, goals, _slots(scenario))
        _draw_events(axes, scenario.execution.events)
        body = models[0].length * width * 72.0 / float(span[0])
        for robot, (pose, model) in enumerate(zip(starts, models, strict=True)):
            color = style.robot_color(robot)
            if body < 5.0:
                axes.plot(*pose[:2], marker="o", markersize=4.5, color=color, zorder=5.8)
            draw_robot(axes, pose, model, color)
        axes.set_xlabel("$x$ (m)", labelpad=1)
        axes.set_ylabel("$y$ (m)", labelpad=1)
        team = f"{len(models)} {models[0].name}" if len({m.name for m in models}) == 1 else "mixed"
        axes.set_title(str(scenario.name), loc="left", pad=3)
        axes.set_title(
            f"{team}, {scenario.task.headline}",
            loc="right",
            pad=3,
            fontsize=7,
            fontstyle="italic",
            color=style.GREY,
        )
        return style.save(figure, path)


def _draw_own_goals(axes: Axes, scenario: Scenario) -> None:
    """Goals of single robots as outlines in the robot's colour, at the end of a thin line."""
    from matplotlib.patches import Polygon

    for robot, (start, goal, model) in enumerate(
        zip(scenario.starts, scenario.goals, scenario.models, strict=False)
    ):
        color, pose = style.robot_color(robot), np.array(goal)
        axes.plot(*zip(start[:2], goal[:2], strict=True), color=color, linewidth=0.7,
                  linestyle=(0, (4, 2)), zorder=3.0)  # fmt: skip
        axes.add_patch(
            Polygon(body_ring(pose, model), facecolor="white", edgecolor=color, linewidth=1.0,
                    zorder=5.5)
        )  # fmt: skip
        draw_heading(axes, pose, 0.7)


def _slots(scenario: Scenario) -> Array:
    """Slots `(S, 2)` of the formation in its own frame, m."""
    section = scenario.task.the_formation
    if section.slots is not None:
        return np.array(section.slots, dtype=float)
    from cavalcade.execution.formation_policy import formation_of

    return np.asarray(formation_of(section, len(scenario.robots), scenario.planner).slots)


def _draw_goals(axes: Axes, goals: Array, slots: Array) -> None:
    """Each goal with its slots, heading and, if there are several, its number."""
    from matplotlib.patheffects import withStroke

    for number, goal in enumerate(goals, start=1):
        if len(slots):
            places = transform_points(goal, slots)
            axes.plot(*places.T, marker="o", markersize=3.4, markerfacecolor="white",
                      markeredgecolor=style.GREY, markeredgewidth=0.8, linestyle="none",
                      zorder=3.1)  # fmt: skip
        draw_heading(axes, goal, 0.7)
        axes.plot(*goal[:2], marker="D", markersize=4.2, markerfacecolor="white",
                  markeredgecolor=style.INK, markeredgewidth=0.9, zorder=5.5)  # fmt: skip
        if len(goals) > 1:
            axes.annotate(
                str(number),
                (float(goal[0]), float(goal[1])),
                xytext=(-8.0 * np.cos(goal[2]), -8.0 * np.sin(goal[2])),
                textcoords="offset points",
                ha="center",
                va="center",
                fontsize=7.5,
                zorder=7,
                path_effects=[withStroke(linewidth=1.6, foreground="white")],
            )


def _draw_events(axes: Axes, events: Sequence[Event]) -> None:
    """Obstacles that will come, go or move, as ghosts with the time of it."""
    from matplotlib.patches import Polygon
    from matplotlib.patheffects import withStroke

    for event in events:
        change = event.add or event.remove or event.move
        if change is None:
            continue
        mapping = {
            kind: getattr(change, kind).model_dump()
            for kind in ("box", "circle", "polygon")
            if getattr(change, kind) is not None
        }
        ring = shape_ring(shape_from_mapping(mapping))
        axes.add_patch(
            Polygon(ring, facecolor="none", edgecolor=style.MOVER, linewidth=0.8,
                    linestyle=(0, (3, 1.5)), hatch=None if event.remove else "////", zorder=1.3)
        )  # fmt: skip
        middle = ring.mean(axis=0)
        if event.move is not None:
            axes.annotate(
                "",
                xy=(event.move.to[0], event.move.to[1]),
                xytext=(float(middle[0]), float(middle[1])),
                arrowprops={
                    "arrowstyle": "-|>",
                    "color": style.MOVER,
                    "linewidth": 0.8,
                    "shrinkA": 0,
                    "shrinkB": 0,
                },
                zorder=1.35,
            )
        verb = "goes" if event.remove is not None else "moves" if event.move else "comes"
        axes.annotate(f"{verb} at {event.at:g} s", (float(middle[0]), float(ring[:, 1].max())),
                      xytext=(0, 3), textcoords="offset points", ha="center", va="bottom",
                      fontsize=6.5, color=style.MOVER, zorder=7,
                      path_effects=[withStroke(linewidth=1.5, foreground="white")])  # fmt: skip
