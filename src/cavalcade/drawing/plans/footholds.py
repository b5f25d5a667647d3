"""Where the feet stand, by leg: the whole team, and one stretch enlarged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_legend
from cavalcade.drawing.maps import add_map, add_polygon, draw_arena, points_per_metre
from cavalcade.drawing.plans.motion import FLIES, activities, leaps
from cavalcade.drawing.scene import PlanScene, runs
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEFT, _RIGHT, _BOTTOM, _TOP, _BETWEEN = 0.38, 0.06, 0.34, 0.36, 0.46
_TALLEST = 5.0
_WINDOW = 2.4
"""Side of the enlarged part, m."""


def draw_footholds(scene: PlanScene, path: Path) -> Path | None:
    """Draw it a page wide; None where no foot steps."""
    if not any(len(feet) for feet in scene.plan.footholds):
        return None
    view = scene.view()
    span = view[2:] - view[:2]
    room = style.PAGE - _LEFT - _RIGHT - _BETWEEN
    # Both pictures are equally high: widths w and h with w * aspect = h.
    aspect = float(span[1] / span[0])
    height = min(_TALLEST, room * aspect / (1.0 + aspect))
    width = height / aspect
    page, total = _LEFT + width + _BETWEEN + height + _RIGHT, _BOTTOM + height + _TOP
    window = _window(scene, view)
    with style.paper_style():
        figure = style.new_figure(page, total)
        whole = add_map(figure, _LEFT, _BOTTOM, width, view)
        whole.set_title(scene.name, loc="left", pad=13)
        enlarged = add_map(figure, _LEFT + width + _BETWEEN, _BOTTOM, height, window)
        enlarged.set_ylabel("")
        enlarged.set_title("enlarged", loc="left", pad=3, fontsize=7, fontstyle="italic")
        for axes in (whole, enlarged):
            draw_arena(axes, scene)
            _draw_feet(axes, scene, axes is enlarged)
        corners = window[[[0, 1], [2, 1], [2, 3], [0, 3]]]
        add_polygon(whole, corners, fill=False, edgecolor=style.INK, linewidth=0.8, zorder=6)
        legs = [
            style.key(name, **style.mark(shape, 3.6, color, 1.0, color))
            for name, color, shape in style.LEGS
        ]
        draw_legend(whole, legs, "left", handletextpad=0.1, columnspacing=0.7, borderaxespad=0.1)
        return style.save(figure, path)


def _window(scene: PlanScene, view: Array) -> Array:
    """The part to enlarge: around the first leap, else on the longest way."""
    side = min(_WINDOW, float((view[2:] - view[:2]).min()))
    centre = None
    for _, path in scene.known:
        found = leaps(path)
        if found:
            centre = path.position[list(found[0]), :2].mean(axis=0)
            break
    if centre is None:
        robots = [k for k, feet in enumerate(scene.plan.footholds) if len(feet)]
        paths = [path for k, path in scene.known if k in robots]
        longest = max(paths, key=lambda path: path.length)
        centre = longest.poses_at(np.array([0.3 * longest.duration]))[0, :2]
    low = np.clip(centre - 0.5 * side, view[:2], view[2:] - side)
    return np.concatenate([low, low + side])


def _draw_feet(axes: Axes, scene: PlanScene, enlarged: bool) -> None:
    """Paths thin, footholds on them."""
    size = float(np.clip(0.055 * points_per_metre(axes), 0.9, 5.0))
    for _, path in scene.known if enlarged or scene.size <= 8 else ():
        for kind, first, last in runs(activities(path)):
            axes.plot(
                *path.position[first : last + 1, :2].T,
                color=style.FLYING if kind == FLIES else style.WALKING,
                linewidth=1.4 if enlarged else 0.6,
                alpha=0.7,
                zorder=3,
            )
    edge = "white" if enlarged else "none"
    for feet in scene.plan.footholds:
        for leg, (_, color, shape) in enumerate(style.LEGS):
            places = feet[feet[:, 2] == leg, 3:5]
            foot = style.mark(shape if enlarged else "o", size, edge, 0.4, color)
            axes.plot(*places.T, **foot, zorder=4)
