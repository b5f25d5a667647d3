"""Draws the figures of a report into their folder and remembers what it drew."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cavalcade.campaign.report.blocks import Block, Drawn, Figure, code
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.report.verdict import Cell

MOST_ROWS = 36
"""A chart with more rows is drawn in parts."""


class Artist:
    """Draws into a folder; without one it draws nothing.

    Attributes:
        folder: Of the figures, or None.
        names: Files drawn so far.
    """

    def __init__(self, folder: Path | None, order: Order) -> None:
        self.folder = folder
        self.names: list[str] = []
        self._order = order

    def figure(
        self, caption: str, draw: Callable[..., Drawn], *args: Any, name: str
    ) -> list[Block]:
        """The block of a chart; none where nothing is drawn."""
        if self.folder is None:
            return []
        drawn = draw(*args, self.folder, safe_name(name))
        self.names.append(drawn.name)
        return [Figure(drawn, caption)]

    def charts(
        self, caption: str, draw: Callable[..., Drawn], cells: Sequence[Cell], name: str
    ) -> list[Block]:
        """One chart, or one per scenario where there are many rows."""
        if len(cells) <= MOST_ROWS:
            return self.figure(caption, draw, cells, self._order, name=name) if cells else []
        blocks: list[Block] = []
        for scenario in self._order.scenarios:
            part = [cell for cell in cells if cell.scenario == scenario]
            text = f"{code(scenario)}: {caption[0].lower()}{caption[1:]}"
            blocks += self.figure(text, draw, part, self._order, name=f"{name}-{scenario}")
        return blocks

    def tidy(self) -> None:
        """Remove what an earlier report drew and this one did not."""
        if self.folder is None:
            return
        for picture in self.folder.glob("*.png"):
            if picture.name not in self.names:
                picture.unlink(missing_ok=True)


def safe_name(name: str) -> str:
    """The name as part of a file's name."""
    return re.sub(r"[^\w.-]+", "_", name).lstrip(".")[:120] or "figure"
