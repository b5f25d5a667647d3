"""A scenario before it is run: the arena, the team at its starts, its goals, what will happen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import (
    draw_arrow,
    draw_heading,
    draw_own_goal,
    draw_robot,
    draw_team_goal,
)
from cavalcade.drawing.maps import add_polygon, draw_arena, map_figure
from cavalcade.drawing.outlines import shape_ring
from cavalcade.drawing.scene import Team
from cavalcade.geometry import Array, transform_points
from cavalcade.world import Shape, shape_from_mapping

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from cavalcade.scenario import Event, Scenario, World

_MARGINS = style.Margins(left=0.36, right=0.06, bottom=0.32, top=0.22)


def draw_scenario(scenario: Scenario, world: World, path: Path) -> Path:
    """Draw it as wide as a page or as high as fits; returns the file written.

    Raises:
        OutputError: The picture cannot be written.
    """
    team = Team(scenario, world)
    with style.paper_style():
        figure, axes = map_figure(team.bounds, _MARGINS, style.PAGE, 6.5)
        draw_arena(axes, team)
        _draw_own_goals(axes, scenario)
        if scenario.task.formation is not None:
            goals = np.array(scenario.task.goals, dtype=float).reshape(-1, 3)
            _draw_goals(axes, goals, _slots(scenario))
        _draw_events(axes, scenario.execution.events)
        for robot, (start, model) in enumerate(zip(scenario.starts, team.models, strict=True)):
            draw_robot(axes, np.array(start, dtype=float), model, style.robot_color(robot))
        kinds = {model.name for model in team.models}
        robots = f"{team.size} {kinds.pop()}" if len(kinds) == 1 else "mixed"
        axes.set_title(str(scenario.name), loc="left", pad=3)
        axes.set_title(
            f"{robots}, {scenario.task.headline}",
            loc="right",
            pad=3,
            fontsize=7,
            fontstyle="italic",
            color=style.GREY,
        )
        return style.save(figure, path)


def _draw_own_goals(axes: Axes, scenario: Scenario) -> None:
    """Goals of single robots at the end of a thin line in the robot's colour."""
    for robot, (start, goal, model) in enumerate(
        zip(scenario.starts, scenario.goals, scenario.models, strict=False)
    ):
        color, pose = style.robot_color(robot), np.array(goal)
        axes.plot(*zip(start[:2], goal[:2], strict=True), color=color, linewidth=0.7,
                  linestyle=(0, (4, 2)), zorder=3.0)  # fmt: skip
        draw_own_goal(axes, pose, model, color)
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
    for number, goal in enumerate(goals, start=1):
        if len(slots):
            places = transform_points(goal, slots)
            axes.plot(*places.T, **style.mark("o", 3.4, style.GREY), zorder=3.1)
        draw_heading(axes, goal, 0.7)
        draw_team_goal(axes, goal)
        if len(goals) > 1:
            x, y, yaw = (float(part) for part in goal)
            behind = (-8.0 * np.cos(yaw), -8.0 * np.sin(yaw))
            style.note(axes, str(number), (x, y), behind, ha="center", va="center", fontsize=7.5,
                       zorder=7, path_effects=style.halo(1.6))  # fmt: skip


def _draw_events(axes: Axes, events: Sequence[Event]) -> None:
    """Obstacles that will come, go or move, as ghosts with the times of it."""
    notes: dict[Shape, list[str]] = {}
    for event in events:
        change = event.add or event.remove or event.move
        if change is None:
            continue
        shape = shape_from_mapping(change.to_dict())
        verb = "goes" if event.remove is not None else "moves" if event.move else "comes"
        notes.setdefault(shape, []).append(f"{verb} at {event.at:g} s")
        if event.move is not None:
            middle = shape_ring(shape).mean(axis=0)
            draw_arrow(axes, middle, np.array(event.move.to), style.MOVER)
    for shape, times in notes.items():
        ring = shape_ring(shape)
        hatch = None if all(note.startswith("goes") for note in times) else "////"
        add_polygon(axes, ring, facecolor="none", edgecolor=style.MOVER, linewidth=0.8,
                    linestyle=(0, (3, 1.5)), hatch=hatch, zorder=1.3)  # fmt: skip
        top = float(ring[:, 0].mean()), float(ring[:, 1].max())
        style.note(axes, ", ".join(times), top, (0, 3), ha="center", va="bottom", fontsize=6.5,
                   color=style.MOVER, zorder=7, path_effects=style.halo(1.5))  # fmt: skip
