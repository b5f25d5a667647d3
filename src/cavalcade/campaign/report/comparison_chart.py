"""Paired differences with their intervals, as marks about zero."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from cavalcade.campaign.report import canvas
from cavalcade.campaign.report.blocks import Drawn
from cavalcade.campaign.report.comparisons import Comparison
from cavalcade.campaign.statistics import Estimate
from cavalcade.drawing import style


def draw_comparisons(
    comparisons: Sequence[Comparison], settings: bool, folder: Path, name: str
) -> Drawn:
    """Differences of success and of each quantity; hollow marks where none is shown.

    Args:
        comparisons: One per row.
        settings: Name the setting, too.
        folder, name: Where it is written.
    """
    usual = comparisons[0].first
    labels = [
        " · ".join([c.scenario, *([c.setting] if settings else []), c.second])
        + (f" against {c.first}" if c.first != usual else "")
        for c in comparisons
    ]
    quantities = comparisons[0].quantities
    titles = ["success (points)", *(f"{q.name} ({q.unit})" for q in quantities)]
    seconds = list(dict.fromkeys(c.second for c in comparisons))
    with canvas.chart_style():
        figure, axes = canvas.rows_figure(labels, len(titles), top=0.06)
        canvas.separate(axes, [f"{c.scenario} {c.setting}" for c in comparisons])
        for k, (axis, title) in enumerate(zip(axes, titles, strict=True)):
            axis.axvline(0.0, color=style.INK, linewidth=0.7, zorder=1)
            low, high = 0.0, 0.0
            for row, comparison in enumerate(comparisons):
                estimate = _estimate(comparison, k)
                if estimate is None or not math.isfinite(estimate.high - estimate.low):
                    continue
                color = canvas.series_color(1 + seconds.index(comparison.second))
                axis.plot([estimate.low, estimate.high], [row, row], color=color, linewidth=1.4)
                axis.plot(
                    estimate.value,
                    row,
                    marker="o",
                    markersize=3.8,
                    markerfacecolor="white" if estimate.includes_zero else color,
                    markeredgecolor=color,
                    markeredgewidth=0.9,
                    zorder=4,
                )
                low, high = min(low, estimate.low), max(high, estimate.high)
            pad = 0.08 * (high - low) or 1.0
            axis.set_xlim(low - pad, high + pad)
            axis.locator_params(axis="x", nbins=5)
            axis.set_xlabel(title)
        return canvas.save(figure, folder, name)


def _estimate(comparison: Comparison, panel: int) -> Estimate | None:
    if panel == 0:
        return comparison.success.difference.scaled(100.0) if comparison.success else None
    found = comparison.values[panel - 1]
    return found.mean.scaled(comparison.quantities[panel - 1].factor) if found else None
