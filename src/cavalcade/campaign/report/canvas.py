"""The look of a report's charts, and the artist who writes them into its folder."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.campaign.report.cells import Cell
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.report.wording import code
from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as MatplotlibFigure

SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7A5195", "#5B5B5B")
"""Okabe and Ito's colours in an order that keeps neighbours far apart, then two darker ones."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")

ROW = 0.17
"""Height of a row of a chart with a row per cell, inches."""

OUTCOME_COLORS = {
    "collision": "#b00020",
    "fallen": "#7d2a5b",
    "invalid": "#CC79A7",
    "crashed": "#1b1b1b",
    "stuck": "#E69F00",
    "stopped": "#D55E00",
    "timeout": "#0072B2",
    "budget": "#56B4E9",
    "infeasible": "#009E73",
    "overtime": "#7A5195",
    "refused": "#9aa0a6",
}
"""Of failures, the gravest first."""
OTHER = "#c9ccd0"

_DPI = 220

_SVG: Any = {"svg.fonttype": "path", "svg.hashsalt": "cavalcade"}
"""Vectors come out the same every time."""


def series_color(index: int) -> str:
    """Of a variant, or of a disturbance."""
    return SERIES[index % len(SERIES)]


def series_marker(index: int) -> str:
    """Tells series apart in grey, too, and those of the same colour where the colours run out."""
    return MARKERS[(index + index // len(SERIES)) % len(MARKERS)]


def side_by_side(
    count: int, margins: style.Margins, between: float, height: float
) -> tuple[MatplotlibFigure, list[Axes]]:
    """Panels as wide together as a page; room around and between them and height in inches."""
    left, right, bottom, top = margins
    width = (style.PAGE - left - right - (count - 1) * between) / count
    figure = style.new_figure(style.PAGE, top + height + bottom)
    places = [left + k * (width + between) for k in range(count)]
    return figure, [style.add_panel(figure, x, bottom, width, height) for x in places]


def rows_figure(
    labels: Sequence[str], panels: int, *, top: float
) -> tuple[MatplotlibFigure, list[Axes]]:
    """Panels that share named rows, the first on top; row k stands at y = k.

    `top` is the room over the panels, inches.
    """
    longest = max((len(label) for label in labels), default=0)
    left = min(0.14 + 0.052 * longest, 0.45 * style.PAGE)
    margins = style.Margins(left, right=0.12, bottom=0.36, top=top)
    figure, axes = side_by_side(panels, margins, 0.16, ROW * max(len(labels), 2))
    for k, axis in enumerate(axes):
        axis.set_ylim(max(len(labels), 2) - 0.5, -0.5)
        axis.set_yticks(range(len(labels)), labels if k == 0 else [""] * len(labels))
        axis.tick_params(axis="y", length=0)
        draw_grid(axis, "x")
    return figure, axes


def separate(axes: Sequence[Axes], groups: Sequence[str]) -> None:
    """Thin lines between rows of different groups."""
    for k in range(1, len(groups)):
        if groups[k] != groups[k - 1]:
            for axis in axes:
                axis.axhline(k - 0.5, color=style.GRID, linewidth=0.6, zorder=0.6)


@dataclass(frozen=True)
class Figure:
    """A picture that has been written, with its caption.

    Attributes:
        name: File name under `figures/`.
        caption: Its text, with markup.
        source: The picture itself as a `data:` address, as vectors where it has them.
        is_chart: Whether it has vectors, so that it may be shown at any size.
    """

    name: str
    caption: str
    source: str
    is_chart: bool


MOST_ROWS = 36
"""A chart with more rows is drawn in parts."""


class Artist:
    """Draws into a folder, and keeps the files' names; without a folder it draws nothing."""

    def __init__(self, folder: Path | None, order: Order) -> None:
        self.folder = folder
        self.names: list[str] = []
        self._order = order

    def chart(
        self, caption: str, draw: Callable[..., MatplotlibFigure], *args: Any, name: str
    ) -> list[Figure]:
        """The chart that `draw(*args)` makes; nothing where nothing is drawn.

        Raises:
            OutputError: The picture cannot be written.
        """
        if self.folder is None:
            return []
        import matplotlib

        with style.paper_style(), matplotlib.rc_context(_SVG):
            figure = draw(*args)
            path = style.save(figure, self.folder / f"{safe_name(name)}.png", dpi=_DPI)
            vectors = io.BytesIO()
            figure.savefig(vectors, format="svg", metadata={"Date": None, "Creator": None})
        self.names.append(path.name)
        return [Figure(path.name, caption, _address("svg+xml", vectors.getvalue()), True)]

    def charts(
        self,
        caption: str,
        draw: Callable[[Sequence[Cell], Order], MatplotlibFigure],
        cells: Sequence[Cell],
        name: str,
    ) -> list[Figure]:
        """One chart of the cells, or one per scenario where there are many rows."""
        if len(cells) <= MOST_ROWS:
            return self.chart(caption, draw, cells, self._order, name=name) if cells else []
        figures: list[Figure] = []
        for scenario in self._order.scenarios:
            part = [cell for cell in cells if cell.scenario == scenario]
            text = f"{code(scenario)}: {caption[0].lower()}{caption[1:]}"
            if part:
                figures += self.chart(text, draw, part, self._order, name=f"{name}-{scenario}")
        return figures

    def raster(self, caption: str, draw: Callable[[Path], Path | None], name: str) -> Figure | None:
        """The picture that `draw` writes to a path; None where it writes none, or has no folder."""
        if self.folder is None:
            return None
        path = draw(self.folder / f"{safe_name(name)}.png")
        if path is None:
            return None
        self.names.append(path.name)
        return Figure(path.name, caption, _address("png", path.read_bytes()), False)

    def tidy(self) -> None:
        """Remove what an earlier report drew and this one did not."""
        if self.folder is None:
            return
        for picture in self.folder.glob("*.png"):
            if picture.name not in self.names:
                picture.unlink(missing_ok=True)


def _address(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"


def safe_name(name: str) -> str:
    """The name as part of a file's name."""
    return re.sub(r"[^\w.-]+", "_", name).lstrip(".")[:120] or "figure"
