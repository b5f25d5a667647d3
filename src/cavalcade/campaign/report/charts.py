"""Charts with a row per scenario, variant and disturbance."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cavalcade.campaign.report import canvas
from cavalcade.campaign.report.blocks import Drawn
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.report.verdict import Cell, Spread, in_order
from cavalcade.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def cell_label(cell: Cell, order: Order) -> str:
    """Its scenario, and its variant and disturbance where there are several."""
    parts = [cell.scenario]
    if len(order.disturbances) > 1:
        parts.append(cell.disturbance)
    if len(order.variants) > 1:
        parts.append(cell.variant)
    return " · ".join(parts)


def cell_color(cell: Cell, order: Order) -> int:
    """Number of its colour: by variant, or by disturbance where there is one variant."""
    if len(order.variants) > 1:
        return order.variants.index(cell.variant)
    return order.disturbances.index(cell.disturbance)


def draw_success(cells: Sequence[Cell], order: Order, folder: Path, name: str) -> Drawn:
    """Success in feasible worlds with its interval, and how the others of them ended."""
    labels = [cell_label(cell, order) for cell in cells]
    with canvas.chart_style():
        figure, (left, right) = canvas.rows_figure(labels, 2, top=0.24)
        canvas.separate((left, right), [cell.scenario for cell in cells])
        lowest = 1.0
        for row, cell in enumerate(cells):
            if not cell.feasible:
                _remark(left, "no feasible world", 0.5, row)
                continue
            low, high = cell.interval
            lowest = min(lowest, low)
            number = cell_color(cell, order)
            color = canvas.series_color(number)
            left.plot([100 * low, 100 * high], [row, row], color=color, linewidth=1.6)
            left.plot(
                100 * cell.feasible_successes / len(cell.feasible),
                row,
                marker=canvas.series_marker(number),
                markersize=4.2,
                markerfacecolor="white",
                markeredgecolor=color,
                markeredgewidth=1.0,
                zorder=4,
            )
        step = 0.02 if lowest > 0.93 else 0.1
        floor = max(0.0, int(lowest / step - 1e-9) * step)
        left.set_xlim(100 * floor, 100 + 0.02 * 100 * (1 - floor))
        left.set_xlabel("success in feasible worlds (%), 95 % interval")
        _draw_failures(right, cells)
        return canvas.save(figure, folder, name)


def _draw_failures(axes: Axes, cells: Sequence[Cell]) -> None:
    from matplotlib.patches import Patch

    shares = [
        Counter(trial.outcome for trial in cell.feasible if not trial.success) for cell in cells
    ]
    seen = in_order(sum(shares, Counter()))
    longest = 0.0
    for row, (cell, counts) in enumerate(zip(cells, shares, strict=True)):
        start = 0.0
        for outcome in seen:
            width = 100.0 * counts[outcome] / max(len(cell.feasible), 1)
            color = canvas.OUTCOME_COLORS.get(outcome, canvas.OTHER)
            axes.barh(row, width, left=start, height=0.62, color=color,
                      edgecolor="white", linewidth=0.4)  # fmt: skip
            start += width
        longest = max(longest, start)
    axes.set_xlim(0.0, 1.08 * longest if longest else 1.0)
    axes.set_xlabel("failures in feasible worlds (%), by reason")
    if not seen:
        _remark(axes, "no failures", 0.5, (len(cells) - 1) / 2.0)
        return
    handles = [
        Patch(facecolor=canvas.OUTCOME_COLORS.get(name, canvas.OTHER), label=name) for name in seen
    ]
    axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=6,
                handlelength=0.8, handleheight=0.8, columnspacing=0.8, borderpad=0.3)  # fmt: skip


def _remark(axes: Axes, text: str, x: float, row: float) -> None:
    axes.text(
        x,
        row,
        text,
        transform=axes.get_yaxis_transform(),
        fontsize=6.5,
        ha="center",
        va="center",
        fontstyle="italic",
        color=style.GREY,
    )


def draw_spreads(cells: Sequence[Cell], order: Order, folder: Path, name: str) -> Drawn:
    """Medians, quartiles and 5 % to 95 % of what was measured in single trials."""
    panels: list[tuple[str, float, Callable[[Cell], Spread]]] = [
        ("time over lower bound", 1.0, lambda cell: cell.time_ratio),
        ("formation error (cm)", 100.0, lambda cell: cell.formation_error),
        ("smallest gap (cm)", 100.0, lambda cell: cell.spread("min_footprint_gap_m")),
        ("cycle, 99 % (ms)", 1.0, lambda cell: cell.spread("cycle_ms.p99")),
    ]
    if cells[0].planned:
        panels = [
            ("length over bound", 1.0, lambda cell: cell.length_ratio),
            ("makespan over alone", 1.0, lambda cell: cell.time_ratio),
            panels[2],
            ("planning time (s)", 1.0, lambda cell: cell.planning_time),
        ]
    with canvas.chart_style():
        labels = [cell_label(cell, order) for cell in cells]
        figure, axes = canvas.rows_figure(labels, len(panels), top=0.06)
        canvas.separate(axes, [cell.scenario for cell in cells])
        for axis, (title, factor, take) in zip(axes, panels, strict=True):
            top, least = 0.0, math.inf
            for row, cell in enumerate(cells):
                spread = take(cell)
                least = min(least, math.inf if spread.p5 is None else factor * spread.p5)
                _draw_spread(axis, row, spread, factor, cell_color(cell, order))
                top = max(top, factor * (spread.p95 or 0.0))
            axis.set_xlabel(title)
            # Zero is shown unless all is far from it.
            far = math.isfinite(least) and 2.0 * least > top
            low = least - 0.5 * (top - least) - 0.05 * top if far else 0.0
            axis.set_xlim(low, top + 0.08 * (top - low) if top else 1.0)
            axis.locator_params(axis="x", nbins=4)
        return canvas.save(figure, folder, name)


def _draw_spread(axes: Axes, row: int, spread: Spread, factor: float, number: int) -> None:
    ends = (spread.p5, spread.p25, spread.median, spread.p75, spread.p95)
    if any(end is None for end in ends):
        return
    p5, p25, median, p75, p95 = (factor * end for end in ends if end is not None)
    color = canvas.series_color(number)
    axes.plot([p5, p95], [row, row], color=color, linewidth=0.7)
    axes.plot([p25, p75], [row, row], color=color, linewidth=3.2, solid_capstyle="butt")
    mark = canvas.series_marker(number)
    axes.plot(median, row, marker=mark, markersize=3.6, markerfacecolor="white",
              markeredgecolor=color, markeredgewidth=0.9, zorder=4)  # fmt: skip
