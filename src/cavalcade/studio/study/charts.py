"""Curves of one run or two with their limits and a cursor at the time that is shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cavalcade.geometry import Array
from cavalcade.studio.session import Session
from cavalcade.studio.study.curves import Curve

FIRST, SECOND = "#3d8fd1", "#e0853d"
"""Colours of the curves of two runs, on light and on dark."""

_LIMIT, _CURSOR = "#d64550", "#8a9099"
_HEIGHT = 130


class Charts:
    """A chart for each kind of curve, made inside its container.

    Args:
        session: The page's.
        runs: Name and curves of each run.
        time: Where the cursor begins, s.
    """

    def __init__(
        self, session: Session, runs: Sequence[tuple[str, Sequence[Curve]]], time: float
    ) -> None:
        names = dict.fromkeys(curve.name for _, curves in runs for curve in curves)
        self._charts = [
            _Chart(session.server.gui, name, [
                (run, curve) for run, curves in runs for curve in curves if curve.name == name
            ], time)
            for name in names
        ]  # fmt: skip

    def move(self, time: float) -> None:
        """Put the cursor there."""
        for chart in self._charts:
            chart.move(time)


class _Chart:
    """One quantity of all runs."""

    def __init__(self, gui: Any, name: str, curves: Sequence[tuple[str, Curve]], time: float):
        self._time = np.unique(np.concatenate([curve.time for _, curve in curves]))
        self._lines = [
            np.interp(self._time, curve.time, curve.values, left=np.nan, right=np.nan)
            for _, curve in curves
        ]
        limits = {curve.limit for _, curve in curves} - {None}
        self._limit = limits.pop() if len(limits) == 1 else None
        values = np.concatenate([line[np.isfinite(line)] for line in self._lines])
        usual = float(np.quantile(values, 0.995)) if len(values) else 1.0
        self._top = max(1.15 * usual, 1.6 * (self._limit or 0.0), 0.1)
        series: list[dict[str, Any]] = [{"label": "time (s)"}]
        for (run, _), color in zip(curves, (FIRST, SECOND), strict=False):
            series.append({"label": run, "stroke": color, "width": 1.5, "points": {"show": False}})
        if self._limit is not None:
            line = {"stroke": _LIMIT, "width": 1, "dash": (6, 4), "points": {"show": False}}
            series.append({"label": "limit", **line})
        series.append({"label": "now", "stroke": _CURSOR, "width": 1, "points": {"show": False}})
        self._chart = gui.add_uplot(
            self._data(time),
            tuple(series),
            title=name,
            scales={"x": {"time": False}, "y": {"range": (0.0, self._top)}},
            legend={"show": False},
            height=_HEIGHT,
        )

    def move(self, time: float) -> None:
        self._chart.data = self._data(time)

    def _data(self, time: float) -> tuple[Array, ...]:
        """The curves, and two points of the cursor in between."""
        at = int(np.searchsorted(self._time, time))
        where = [at, at]
        columns = [np.insert(self._time, where, time)]
        for line in self._lines:
            here = float(np.interp(time, self._time, line))
            columns.append(np.insert(line, where, here))
        if self._limit is not None:
            columns.append(np.full(len(columns[0]), self._limit))
        cursor = np.full(len(columns[0]), np.nan)
        cursor[at : at + 2] = (0.0, self._top)
        return (*columns, cursor)
