"""The live plots of a drive."""

from __future__ import annotations

from typing import Any

import numpy as np

from cavalcade.studio.drive.history import History

CHARTS = (
    ("Gaps between footprints (m)", (("obstacles", "to obstacles"), ("robots", "between robots"))),
    ("Formation error (m)", (("formation", "largest"),)),
    ("Planner's cycle (ms)", (("cycle", "cycle"),)),
)
"""Title, and the curves in it with their names."""

COLORS = ("#1f9ed1", "#e8871e")
LIMIT_COLOR = "#e03131"
HEIGHT = 150


class Plots:
    """Charts over the last minute; each with a limit, where there is one.

    Args:
        gui: `viser`'s, within the container that they stand in.
    """

    def __init__(self, gui: Any) -> None:
        none = np.zeros(2)
        self._limits: dict[str, float] = {}
        self._charts = []
        for title, curves in CHARTS:
            series: list[dict[str, Any]] = [{"label": "time (s)"}]
            series += [
                {"label": label, "stroke": color, "width": 1.5}
                for (_, label), color in zip(curves, COLORS, strict=False)
            ]
            series.append({"label": "limit", "stroke": LIMIT_COLOR, "width": 1, "dash": (4, 4)})
            self._charts.append(
                gui.add_uplot(
                    data=tuple(none for _ in series),
                    series=tuple(series),
                    scales={"x": {"time": False}, "y": {"range": (0.0, None)}},
                    axes=tuple(_axis(size) for size in (30, 45)),
                    title=title,
                    height=HEIGHT,
                    legend={"show": len(curves) > 1},
                )
            )

    def set_limits(self, period: float) -> None:
        """Gaps may not become 0; a cycle is to take less than a period, s."""
        self._limits = {CHARTS[0][0]: 0.0, CHARTS[2][0]: 1e3 * period}

    def show(self, history: History) -> None:
        """Draw what is kept now."""
        if len(history) < 2:
            return
        for (title, curves), chart in zip(CHARTS, self._charts, strict=True):
            time, _ = history.curve(curves[0][0])
            values = [history.curve(name)[1] for name, _ in curves]
            limit = self._limits.get(title)
            line = np.full(len(time), np.nan if limit is None else limit)
            chart.data = (time, *values, line)


def _axis(size: int) -> dict[str, Any]:
    grey = "#888888"
    return {"stroke": grey, "size": size, "grid": {"stroke": "#88888833", "width": 1}}
