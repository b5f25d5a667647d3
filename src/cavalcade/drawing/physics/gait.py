"""Which feet carry when in a run in physics, and how much."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_grid, stacked_panels
from cavalcade.drawing.physics.legs import MARGINS, MOST_ROWS, number_row
from cavalcade.drawing.physics.signals import LOADED, busiest_window, loaded_spans
from cavalcade.geometry.constants import GRAVITY
from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.robots.description import QuadrupedDescription

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WINDOW = 3.0
"""Of the diagram, s."""


def draw_gait(
    name: str, track: PhysicsTrack, robots: Sequence[QuadrupedDescription], path: Path
) -> Path:
    """Draw it a page wide, robot by robot; bars as strong as what they carry."""
    rows = min(track.size, MOST_ROWS)
    heights, gaps = [0.56] * rows, [0.09] * (rows - 1)
    span = busiest_window(track, _WINDOW)
    with style.paper_style():
        figure, panels = stacked_panels(style.PAGE, MARGINS, heights, gaps, span)
        for robot, axes in enumerate(panels):
            _draw_feet(axes, track, robot, GRAVITY * robots[robot].mass)
            axes.set_xlim(*span)
            number_row(axes, robot)
        panels[0].set_title(f"{name}: feet that carry", loc="left", pad=3)
        panels[0].set_title("full colour: half the weight", loc="right", pad=3, fontsize=7,
                            color=style.GREY)  # fmt: skip
        return style.save(figure, path)


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
