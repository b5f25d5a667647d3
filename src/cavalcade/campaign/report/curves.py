"""How success, time and formation depend on the level: obstacles, robots, or what else varies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cavalcade.campaign.report.verdict import Cell, Spread
from cavalcade.campaign.statistics import wilson

FEW_LEVELS = 10
"""So many levels or fewer are shown one by one."""

FEWEST_TRIALS = 10
"""Scenarios of which no cell has so many trials in feasible worlds have no curve."""

BINS = 8
"""More levels are put into so many bins of equal width."""


@dataclass(frozen=True)
class Point:
    """The trials of one level or bin of levels.

    Attributes:
        low, high: Lowest and highest level of the bin; the same for a single level.
        trials: Feasible ones.
        successes: Of these.
        time_ratio: Of those that succeeded.
        formation_error: Of those that succeeded, m.
        planning_time: Of those that succeeded, s.
    """

    low: float
    high: float
    trials: int
    successes: int
    time_ratio: Spread
    formation_error: Spread
    planning_time: Spread

    @property
    def middle(self) -> float:
        """Where the point is drawn."""
        return (self.low + self.high) / 2.0

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the success."""
        return wilson(self.successes, self.trials)

    @property
    def label(self) -> str:
        """The levels, for people."""
        ends = [f"{end:g}" for end in (self.low, self.high)]
        return ends[0] if ends[0] == ends[1] else f"{ends[0]}–{ends[1]}"


@dataclass(frozen=True)
class Curve:
    """One cell over its levels.

    Attributes:
        cell: Which.
        axis: What the level is the number of.
        points: In ascending order.
    """

    cell: Cell
    axis: str
    points: tuple[Point, ...]

    @property
    def ends(self) -> tuple[float, ...]:
        """Lowest and highest levels of all points."""
        return tuple(end for point in self.points for end in (point.low, point.high))


def curves_of(cells: Sequence[Cell]) -> dict[str, list[Curve]]:
    """Curves by scenario, all of one scenario over the same bins; none for a single level."""
    found: dict[str, list[Curve]] = {}
    for scenario in dict.fromkeys(cell.scenario for cell in cells):
        here = [cell for cell in cells if cell.scenario == scenario]
        trials = [trial for cell in here for trial in cell.feasible if trial.level is not None]
        levels = sorted({trial.level for trial in trials if trial.level is not None})
        most = max(len(cell.feasible) for cell in here)
        if len(levels) < 2 or most < FEWEST_TRIALS:
            continue
        axis = next((trial.level_name for trial in trials if trial.level_name), None) or "level"
        edges = _edges(levels)
        found[scenario] = [Curve(cell, axis, _points(cell, edges)) for cell in here]
    return found


def _edges(levels: Sequence[float]) -> list[tuple[float, float]]:
    """Bins as (lowest, highest) level, both inside, none overlapping."""
    if len(levels) <= FEW_LEVELS:
        return [(level, level) for level in levels]
    whole = all(float(level).is_integer() for level in levels)
    low, high = levels[0], levels[-1]
    if whole:
        # Widths differ by one at most.
        starts = np.round(np.linspace(low, high + 1, BINS + 1))
        return [(float(a), float(b - 1)) for a, b in pairwise(starts)]
    ends = np.linspace(low, high, BINS + 1)
    # Open at the upper end, but for the last one.
    return [
        (float(a), float(b if k == BINS - 1 else np.nextafter(b, a)))
        for k, (a, b) in enumerate(pairwise(ends))
    ]


def _points(cell: Cell, edges: Sequence[tuple[float, float]]) -> tuple[Point, ...]:
    points = []
    for low, high in edges:
        inside = [t for t in cell.feasible if t.level is not None and low <= t.level <= high]
        if not inside:
            continue
        done = [trial for trial in inside if trial.success]
        points.append(
            Point(
                low,
                high,
                len(inside),
                len(done),
                Spread.of(trial.time_ratio for trial in done),
                Spread.of(trial.number("formation_error_m.mean") for trial in done),
                Spread.of(trial.number("planning_time_s") for trial in done),
            )
        )
    return tuple(points)
