"""Charts over time or along a path: panels one below the other, and what is noted on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TURNS, _PER_TURN = 60, 10
"""Lines that run together take so many turns over the width, each of so many samples."""


def stacked_panels(
    width: float,
    margins: style.Margins,
    heights: Sequence[float],
    gaps: Sequence[float],
    span: tuple[float, float],
    label: str = "time (s)",
) -> tuple[Figure, list[Axes]]:
    """A figure with panels one below the other, from the top, that share their horizontal axis.

    Lengths are in inches; the axis goes over `span` and is called `label`.
    """
    top = margins.bottom + sum(heights) + sum(gaps)
    figure = style.new_figure(width, top + margins.top)
    panels = []
    for height, gap in zip(heights, [*gaps, 0.0], strict=True):
        top -= height
        inner = width - margins.left - margins.right
        panels.append(style.add_panel(figure, margins.left, top, inner, height))
        panels[-1].set_xlim(*span)
        panels[-1].tick_params(labelbottom=len(panels) == len(heights))
        top -= gap
    panels[-1].set_xlabel(label, labelpad=1)
    return figure, panels


def draw_lines(
    axes: Axes, lines: Sequence[tuple[Array, Array]], looks: Sequence[dict[str, Any]], width: float
) -> None:
    """Lines of times and values `(T,)` with their options, none hidden below others.

    Where several run together, within a line's `width` in points, each is on top in turns. The
    vertical axis has its range already.
    """
    for (time, values), look in zip(lines, looks, strict=True):
        axes.plot(time, values, **look, linewidth=width, zorder=3)
    if len(lines) < 2:
        return
    first, last = (float(end) for end in axes.get_xlim())
    marks = np.linspace(first, last, _TURNS * _PER_TURN + 1)
    shown = np.array(
        [np.interp(marks, time, values, left=np.nan, right=np.nan) for time, values in lines]
    )
    low, high = axes.get_ylim()
    near = width * (high - low) * axes.figure.dpi / (72.0 * axes.bbox.height)
    turn = np.arange(len(marks)) // _PER_TURN
    with np.errstate(invalid="ignore"):
        for k, look in enumerate(looks):
            together = np.abs(shown - shown[k]) < near
            size, rank = together.sum(axis=0), together[:k].sum(axis=0)
            mine = (size > 1) & (turn % np.maximum(size, 1) == rank)
            piece = {**look, "linestyle": "-", "solid_capstyle": "butt"}
            axes.plot(marks, np.where(mine, shown[k], np.nan), **piece, linewidth=width, zorder=3.1)


def draw_grid(axes: Axes, axis: Any = "both") -> None:
    """Faint lines below all that is drawn."""
    axes.grid(True, axis=axis, linewidth=0.3, color=style.GRID)
    axes.set_axisbelow(True)


def draw_legend(axes: Axes, handles: Sequence[Any], side: str = "right", **options: Any) -> None:
    """A legend in one row over the axes, ending or beginning with them."""
    options = {"ncols": len(handles), "columnspacing": 0.9, **options}
    loc: Any = f"lower {side}"
    # Two points above the axes, however high those are.
    place = (1.0 if side == "right" else 0.0, 1.0 + 2.0 / 72.0 * axes.figure.dpi / axes.bbox.height)
    axes.legend(handles=handles, loc=loc, bbox_to_anchor=place, **options)


def draw_note(axes: Axes, value: float, text: str, color: str) -> None:
    """A note on the right margin, at the height of a value."""
    options = {"xycoords": axes.get_yaxis_transform(), "va": "center", "linespacing": 0.95}
    style.note(axes, text, (1.0, value), (3, 0), color=color, **options)


def draw_limit(axes: Axes, value: float, beyond: float, name: str) -> None:
    """A dashed line that must not be crossed, the side `beyond` it in pale red."""
    axes.axhspan(value, beyond, facecolor=style.BEYOND, edgecolor="none", alpha=0.55, zorder=0.4)
    axes.axhline(value, color=style.LIMIT, linewidth=0.8, linestyle=(0, (5, 2)), zorder=2.4)
    draw_note(axes, value, name, style.LIMIT)


def draw_extreme(axes: Axes, x: float, y: float, text: str, rise: float) -> None:
    """Ring a point and say beside it, so many points higher, what it is."""
    axes.plot(x, y, **style.mark("o", 3.4, style.INK), zorder=6)
    low, high = axes.get_xlim()
    late = x > low + 0.7 * (high - low)
    side, beside = ("right", -6) if late else ("left", 6)
    box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.6}
    style.note(axes, text, (x, y), (beside, rise), ha=side, zorder=7, bbox=box)
