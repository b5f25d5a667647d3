"""The curves over levels: success, time and formation error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from cavalcade.campaign.report import canvas
from cavalcade.campaign.report.cells import Curve, Point
from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FEW_CURVES = 4
"""More curves than these are drawn without their intervals and quartiles."""

_LEGEND_COLUMNS = 6


def draw_curves(curves: Sequence[Curve], labels: Sequence[str]) -> Figure:
    """Success, time and formation error, or planning time, over the level, a line per curve."""
    columns = min(len(curves), _LEGEND_COLUMNS)
    top = 0.09 + 0.15 * -(-len(curves) // columns) if len(curves) > 1 else 0.06
    few = len(curves) <= FEW_CURVES
    margins = style.Margins(left=0.42, right=0.06, bottom=0.34, top=top)
    figure, axes = canvas.side_by_side(3, margins, between=0.44, height=1.55)
    handles: list[Any] = []
    for number, curve in enumerate(curves):
        points = curve.points
        shift = _dodge(points, number, len(curves)) if few else 0.0
        spread = "none" if not few else "bars" if len(curves) > 1 else "band"
        handles.append(_draw_line(axes[0], points, _success, 100.0, number, spread, shift))
        spread = "band" if few else "none"
        _draw_line(axes[1], points, partial(_quartiles, "time_ratio"), 1.0, number, spread)
        third, factor = ("solving_time", 1.0) if curve.cell.planned else ("formation_error", 100.0)
        _draw_line(axes[2], points, partial(_quartiles, third), factor, number, spread)
    from matplotlib.ticker import MaxNLocator

    levels = [end for curve in curves for one in curve.points for end in (one.low, one.high)]
    titles = ["success (%)", "time over lower bound", "formation error (cm)"]
    if curves[0].cell.planned:
        titles[1:] = ["makespan over slowest alone", "planning time (s)"]
    for axis, title in zip(axes, titles, strict=True):
        axis.set_ylabel(title)
        axis.set_xlabel(f"number of {curves[0].axis}" if curves[0].axis.endswith("s")
                        else curves[0].axis)  # fmt: skip
        draw_grid(axis)
        axis.margins(x=0.03)
        if all(float(level).is_integer() for level in levels):
            axis.xaxis.set_major_locator(MaxNLocator(nbins=6, integer=True))
    low, _ = axes[0].get_ylim()
    low = max(0.0, min(low, 95.0))
    axes[0].set_ylim(low, 100.0 + 0.02 * (100.0 - low))
    if len(curves) > 1:
        figure.legend(
            handles=handles,
            labels=list(labels),
            loc="upper center",
            ncols=columns,
            bbox_to_anchor=(0.5, 1.0 - 0.02 / figure.get_figheight()),
        )
    return figure


def _dodge(points: Sequence[Point], number: int, count: int) -> float:
    """By how much a curve's marks stand aside, so that the intervals of all can be seen."""
    if len(points) < 2 or count < 2:
        return 0.0
    step = (points[-1].middle - points[0].middle) / (len(points) - 1)
    return min(0.14, 0.6 / count) * step * (number - (count - 1) / 2.0)


_Ends = tuple[float | None, float | None, float | None]
"""Lower end of the band, the figure itself, upper end."""


def _success(point: Point) -> _Ends:
    low, high = point.cell.interval
    return low, point.cell.successes / point.cell.trials, high


def _quartiles(name: str, point: Point) -> _Ends:
    spread = point.cell.spreads[name]
    return spread.p25, spread.median, spread.p75


def _draw_line(
    axes: Axes,
    points: Sequence[Point],
    take: Callable[[Point], _Ends],
    factor: float,
    number: int,
    spread: str,
    shift: float = 0.0,
) -> Any:
    """A line with its marks `shift` aside, and its spread as a `band`, as `bars`, or `none`."""
    known = [
        (point.middle + shift, *(factor * end for end in ends if end is not None))
        for point, ends in ((point, take(point)) for point in points)
        if None not in ends
    ]
    color = canvas.series_color(number)
    x, low, middle, high = zip(*known, strict=True) if known else ((), (), (), ())
    if spread == "band":
        axes.fill_between(x, low, high, color=color, alpha=0.16, linewidth=0.0)
    elif spread == "bars":
        axes.vlines(x, low, high, color=color, linewidth=0.8, alpha=0.7)
    line = axes.plot(x, middle, color=color, linewidth=1.1, marker=canvas.series_marker(number),
                     markersize=3.4, markerfacecolor="white", markeredgewidth=0.9)  # fmt: skip
    return line[0]
