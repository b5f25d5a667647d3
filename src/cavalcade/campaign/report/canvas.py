"""The look of a report's charts, and how they are written."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.campaign.report.blocks import Drawn
from cavalcade.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GRID = "#dadcdf"
SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7A5195", "#5B5B5B")
"""Okabe and Ito's colours in an order that keeps neighbours far apart, then two darker ones."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")

ROW = 0.17
"""Height of a row of a chart with a row per cell, inches."""

OUTCOME_COLORS = {
    "collision": "#b00020",
    "fallen": "#7d2a5b",
    "invalid": "#CC79A7",
    "stuck": "#E69F00",
    "stopped": "#D55E00",
    "timeout": "#0072B2",
    "budget": "#56B4E9",
    "infeasible": "#009E73",
    "overtime": "#7A5195",
    "refused": "#9aa0a6",
    "crashed": "#1b1b1b",
}
OTHER = "#c9ccd0"

_SVG: Any = {"svg.fonttype": "path", "svg.hashsalt": "cavalcade"}


@contextmanager
def chart_style() -> Iterator[None]:
    """The style of the figures of runs; vectors come out the same every time."""
    import matplotlib

    with style.paper_style(), matplotlib.rc_context(_SVG):
        yield


def series_color(index: int) -> str:
    """Of a variant, or of a disturbance."""
    return SERIES[index % len(SERIES)]


def series_marker(index: int) -> str:
    """Tells series apart in grey, too, and those of the same colour where the colours run out."""
    return MARKERS[(index + index // len(SERIES)) % len(MARKERS)]


def rows_figure(
    labels: Sequence[str], panels: int, *, top: float = 0.26, bottom: float = 0.36
) -> tuple[Figure, list[Axes]]:
    """Panels side by side that share named rows, the first on top.

    Args:
        labels: Of the rows; row k stands at y = k.
        panels: How many; as wide together as a page.
        top, bottom: Room over and under the panels, inches.
    """
    longest = max((len(label) for label in labels), default=0)
    left = min(0.14 + 0.052 * longest, 0.45 * style.PAGE)
    right, between = 0.12, 0.16
    height = ROW * max(len(labels), 2)
    total = top + height + bottom
    width = (style.PAGE - left - right - (panels - 1) * between) / panels
    figure = style.new_figure(style.PAGE, total)
    axes = []
    for k in range(panels):
        place = (left + k * (width + between)) / style.PAGE
        axis = figure.add_axes(
            (place, bottom / total, width / style.PAGE, height / total),
        )
        axis.set_ylim(max(len(labels), 2) - 0.5, -0.5)
        axis.set_yticks(range(len(labels)), labels if k == 0 else [""] * len(labels))
        axis.tick_params(axis="y", length=0)
        axis.grid(True, axis="x", linewidth=0.3, color=GRID)
        axis.set_axisbelow(True)
        axes.append(axis)
    return figure, axes


def separate(axes: Sequence[Axes], groups: Sequence[str]) -> None:
    """Thin lines between rows of different groups."""
    for k in range(1, len(groups)):
        if groups[k] != groups[k - 1]:
            for axis in axes:
                axis.axhline(k - 0.5, color=GRID, linewidth=0.6, zorder=0.6)


def save(figure: Figure, folder: Path, name: str, dpi: int = 220) -> Drawn:
    """Write the figure as PNG into the folder; its vectors come back with it.

    Raises:
        OutputError: The picture cannot be written.
    """
    path = style.save(figure, folder / f"{name}.png", dpi=dpi)
    vectors = io.BytesIO()
    figure.savefig(vectors, format="svg", metadata={"Date": None, "Creator": None})
    return Drawn(path.name, path.read_bytes(), vectors.getvalue())
