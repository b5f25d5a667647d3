"""Charts over time or along a path: panels one below the other, and what is noted on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from cavalcade.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
