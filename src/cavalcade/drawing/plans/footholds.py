"""Where the feet stand, by leg: the whole team, and one stretch enlarged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.actors import set_ticks, set_view
from cavalcade.drawing.plans.scene import FLYING, WALKING, PlanScene, activities, leaps, runs
from cavalcade.drawing.terrain import draw_ground
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEGS = (
    ("front left", "#0072B2", "o"),
    ("front right", "#E69F00", "s"),
    ("rear left", "#009E73", "^"),
    ("rear right", "#B5478D", "D"),
)
_LEFT, _RIGHT, _BOTTOM, _TOP, _BETWEEN = 0.38, 0.06, 0.34, 0.36, 0.46
_TALLEST = 5.0
_WINDOW = 2.4
"""Side of the enlarged part, m."""


def draw_footholds(scene: PlanScene, path: Path) -> Path | None:
    """Draw it a page wide; None where no foot steps."""
    if not any(len(feet) for feet in scene.footholds):
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
        for left, inches, part in (
            (_LEFT, width, view),
            (_LEFT + width + _BETWEEN, height, window),
        ):
            axes = figure.add_axes((left / page, _BOTTOM / total, inches / page, height / total))
            set_view(axes, part)
            set_ticks(axes, part, inches)
            draw_ground(axes, scene)
            _draw_feet(axes, scene, 72.0 * inches / float(part[2] - part[0]), part is window)
            set_view(axes, part)
            axes.set_xlabel("$x$ (m)", labelpad=1)
            if part is view:
                axes.set_ylabel("$y$ (m)", labelpad=1)
                axes.set_title(scene.name, loc="left", pad=13)
                _draw_frame(axes, window)
                _draw_legend(axes)
            else:
                axes.set_title("enlarged", loc="left", pad=3, fontsize=7, fontstyle="italic")
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
        robots = [k for k, feet in enumerate(scene.footholds) if len(feet)]
        paths = [path for k, path in scene.known if k in robots]
        longest = max(paths, key=lambda path: path.length)
        centre = longest.poses_at(np.array([0.3 * longest.duration]))[0, :2]
    low = np.clip(centre - 0.5 * side, view[:2], view[2:] - side)
    return np.concatenate([low, low + side])


def _draw_feet(axes: Axes, scene: PlanScene, size: float, enlarged: bool) -> None:
    """Paths thin, footholds on them; `size` in points per m."""
    marker = float(np.clip(0.055 * size, 0.9, 5.0))
    for _, path in scene.known if enlarged or scene.size <= 8 else ():
        for kind, first, last in runs(activities(path)):
            axes.plot(
                *path.position[first : last + 1, :2].T,
                color=FLYING if kind == 2 else WALKING,
                linewidth=1.4 if enlarged else 0.6,
                alpha=0.7,
                zorder=3,
            )
    for feet in scene.footholds:
        for leg, (_, colour, shape) in enumerate(LEGS):
            mine = feet[feet[:, 2] == leg]
            axes.plot(
                mine[:, 3], mine[:, 4], linestyle="none", marker=shape if enlarged else "o",
                markersize=marker, markerfacecolor=colour,
                markeredgecolor="white" if enlarged else "none", markeredgewidth=0.4, zorder=4,
            )  # fmt: skip


def _draw_frame(axes: Axes, window: Array) -> None:
    from matplotlib.patches import Rectangle

    axes.add_patch(
        Rectangle(
            (window[0], window[1]), window[2] - window[0], window[3] - window[1], fill=False,
            edgecolor=style.INK, linewidth=0.8, zorder=6,
        )
    )  # fmt: skip


def _draw_legend(axes: Axes) -> None:
    from matplotlib.lines import Line2D

    handles: list[Any] = [
        Line2D([], [], linestyle="none", marker=shape, color=colour, markersize=3.6, label=name)
        for name, colour, shape in LEGS
    ]
    axes.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.005), ncols=4,
        handletextpad=0.1, columnspacing=0.7, borderaxespad=0.1,
    )  # fmt: skip
