"""Charts with a row per scenario, variant and disturbance, or per comparison; and curves."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from cavalcade.campaign.report import canvas
from cavalcade.campaign.report.cells import Cell, Curve, Point, Spread, in_order
from cavalcade.campaign.report.comparisons import Comparison, Quantity
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.statistics import Estimate
from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


FEW_CURVES = 4
"""More curves than these are drawn without their intervals and quartiles."""

_LEGEND_COLUMNS = 6


def cell_label(cell: Cell, order: Order) -> str:
    """Its scenario, and its variant and disturbance where there are several."""
    return " · ".join(getattr(cell, part) for part in order.parts)


def cell_color(cell: Cell, order: Order) -> int:
    """Number of its colour: by variant, or by disturbance where there is one variant."""
    if len(order.variants) > 1:
        return order.variants.index(cell.variant)
    return order.disturbances.index(cell.disturbance)


def draw_success(cells: Sequence[Cell], order: Order) -> Figure:
    """Success in feasible worlds with its interval, and how the others of them ended."""
    labels = [cell_label(cell, order) for cell in cells]
    figure, (left, right) = canvas.rows_figure(labels, 2, top=0.24)
    canvas.separate((left, right), [cell.scenario for cell in cells])
    lowest = 1.0
    for row, cell in enumerate(cells):
        if not cell.feasible:
            _remark(left, "no feasible world", row)
            continue
        low, high = cell.interval
        lowest = min(lowest, low)
        number = cell_color(cell, order)
        color = canvas.series_color(number)
        left.plot([100 * low, 100 * high], [row, row], color=color, linewidth=1.6)
        share = 100 * cell.feasible_successes / cell.feasible
        point = style.mark(canvas.series_marker(number), 4.2, color, 1.0)
        left.plot(share, row, **point, zorder=4)
    step = 0.02 if lowest > 0.93 else 0.1
    floor = max(0.0, int(lowest / step - 1e-9) * step)
    left.set_xlim(100 * floor, 100 + 0.02 * 100 * (1 - floor))
    left.set_xlabel("success in feasible worlds (%), 95 % interval")
    _draw_failures(right, cells)
    return figure


def _draw_failures(axes: Axes, cells: Sequence[Cell]) -> None:
    from matplotlib.patches import Patch

    shares = [Counter(cell.failures) for cell in cells]
    seen = in_order(sum(shares, Counter()))
    longest = 0.0
    for row, (cell, counts) in enumerate(zip(cells, shares, strict=True)):
        start = 0.0
        for outcome in seen:
            width = 100.0 * counts[outcome] / max(cell.feasible, 1)
            color = canvas.OUTCOME_COLORS.get(outcome, canvas.OTHER)
            axes.barh(row, width, left=start, height=0.62, color=color,
                      edgecolor="white", linewidth=0.4)  # fmt: skip
            start += width
        longest = max(longest, start)
    axes.set_xlim(0.0, 1.08 * longest if longest else 1.0)
    axes.set_xlabel("failures in feasible worlds (%), by reason")
    if not seen:
        axes.set_xticks([])
        _remark(axes, "no failures", (len(cells) - 1) / 2.0)
        return
    handles = [
        Patch(facecolor=canvas.OUTCOME_COLORS.get(name, canvas.OTHER), label=name) for name in seen
    ]
    axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=6,
                handlelength=0.8, handleheight=0.8, columnspacing=0.8, borderpad=0.3)  # fmt: skip


def _remark(axes: Axes, text: str, row: float) -> None:
    axes.text(
        0.5,
        row,
        text,
        transform=axes.get_yaxis_transform(),
        fontsize=6.5,
        ha="center",
        va="center",
        fontstyle="italic",
        color=style.GREY,
    )


def draw_spreads(cells: Sequence[Cell], order: Order) -> Figure:
    """Medians, quartiles and 5 % to 95 % of what was measured in single trials."""
    panels = [
        ("time over lower bound", 1.0, "time_ratio"),
        ("formation error (cm)", 100.0, "formation_error"),
        ("smallest gap (cm)", 100.0, "gap"),
        ("cycle, 99 % (ms)", 1.0, "cycle_p99"),
    ]
    if cells[0].planned:
        panels = [
            ("length over bound", 1.0, "length_ratio"),
            ("makespan over alone", 1.0, "time_ratio"),
            panels[2],
            ("planning time (s)", 1.0, "planning_time"),
        ]
    labels = [cell_label(cell, order) for cell in cells]
    figure, axes = canvas.rows_figure(labels, len(panels), top=0.06)
    canvas.separate(axes, [cell.scenario for cell in cells])
    for axis, (title, factor, name) in zip(axes, panels, strict=True):
        top, least = 0.0, math.inf
        for row, cell in enumerate(cells):
            spread = cell.spreads[name]
            least = min(least, math.inf if spread.p5 is None else factor * spread.p5)
            _draw_spread(axis, row, spread, factor, cell_color(cell, order))
            top = max(top, factor * (spread.p95 or 0.0))
        axis.set_xlabel(title)
        # Zero is shown unless all is far from it.
        far = math.isfinite(least) and 2.0 * least > top
        low = least - 0.5 * (top - least) - 0.05 * top if far else 0.0
        axis.set_xlim(low, top + 0.08 * (top - low) if top else 1.0)
        axis.locator_params(axis="x", nbins=4)
    return figure


def _draw_spread(axes: Axes, row: int, spread: Spread, factor: float, number: int) -> None:
    ends = (spread.p5, spread.p25, spread.median, spread.p75, spread.p95)
    if any(end is None for end in ends):
        return
    p5, p25, median, p75, p95 = (factor * end for end in ends if end is not None)
    color = canvas.series_color(number)
    axes.plot([p5, p95], [row, row], color=color, linewidth=0.7)
    axes.plot([p25, p75], [row, row], color=color, linewidth=3.2, solid_capstyle="butt")
    point = style.mark(canvas.series_marker(number), 3.6, color, 0.9)
    axes.plot(median, row, **point, zorder=4)


def draw_comparisons(comparisons: Sequence[Comparison], settings: bool) -> Figure:
    """Differences of success and of each quantity; hollow marks where none is shown.

    There is a row per comparison, which names its setting, too, where `settings` says so.
    """
    usual = comparisons[0].first
    labels = [
        " · ".join([c.scenario, *([c.setting] if settings else []), c.second])
        + (f" against {c.first}" if c.first != usual else "")
        for c in comparisons
    ]
    panels = (None, *comparisons[0].values)
    titles = [f"{one.name} ({one.unit})" if one else "success (points)" for one in panels]
    seconds = list(dict.fromkeys(c.second for c in comparisons))
    figure, axes = canvas.rows_figure(labels, len(titles), top=0.06)
    canvas.separate(axes, [f"{c.scenario} {c.setting}" for c in comparisons])
    for axis, title, panel in zip(axes, titles, panels, strict=True):
        axis.axvline(0.0, color=style.INK, linewidth=0.7, zorder=1)
        low, high = 0.0, 0.0
        for row, comparison in enumerate(comparisons):
            estimate = _estimate(comparison, panel)
            if estimate is None or not math.isfinite(estimate.high - estimate.low):
                continue
            color = canvas.series_color(1 + seconds.index(comparison.second))
            axis.plot([estimate.low, estimate.high], [row, row], color=color, linewidth=1.4)
            fill = "white" if estimate.includes_zero else color
            point = style.mark("o", 3.8, color, 0.9, fill)
            axis.plot(estimate.value, row, **point, zorder=4)
            low, high = min(low, estimate.low), max(high, estimate.high)
        pad = 0.08 * (high - low) or 1.0
        axis.set_xlim(low - pad, high + pad)
        axis.locator_params(axis="x", nbins=5)
        axis.set_xlabel(title)
    return figure


def _estimate(comparison: Comparison, quantity: Quantity | None) -> Estimate | None:
    """The difference of a quantity, or of success, in the panel's unit."""
    if quantity is None:
        return comparison.success.difference.scaled(100.0) if comparison.success else None
    found = comparison.values.get(quantity)
    return found.mean.scaled(quantity.factor) if found else None


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
