"""What the trials of one scenario, variant and disturbance come to, in all and over levels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from cavalcade.campaign.report.trials import TrialTable
from cavalcade.campaign.statistics import upper_bound, wilson

ALL = "all scenarios"
"""Scenario of what is counted over the worlds of all groups; no group may be called so."""

OUTCOMES = (
    "arrived",
    "done",
    "solved",
    "timeout",
    "stuck",
    "stopped",
    "budget",
    "infeasible",
    "collision",
    "fallen",
    "invalid",
    "overtime",
    "refused",
    "crashed",
)
"""Outcomes in the order of the report."""

FEW_LEVELS = 10
"""So many levels or fewer are shown one by one."""

FEWEST_TRIALS = 10
"""Scenarios of which no cell has so many trials in feasible worlds have no curve."""

BINS = 8
"""More levels are put into so many bins of equal width."""


@dataclass(frozen=True)
class Spread:
    """Quantiles and mean of a measured quantity; None where nothing was measured."""

    least: float | None
    p5: float | None
    p25: float | None
    median: float | None
    p75: float | None
    p95: float | None
    p99: float | None
    most: float | None
    mean: float | None


_SHARES = [0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 1.0]

_OF_SUCCESSES = (
    "time",
    "time_ratio",
    "length",
    "length_ratio",
    "single_time_ratio",
    "formation_error",
    "solving_time",
)
"""Quantities whose spread is that of the trials that succeeded."""


@dataclass(frozen=True)
class Cell:
    """All trials of one scenario, variant and disturbance.

    Attributes:
        scenario, disturbance, variant: Which; the scenario may be `ALL`.
        part: Which of the parts that its trials were put in; see `cells_of`.
        planned: Whether robots have individual goals.
        commanded: Whether robots were told how to walk, without a planner.
        in_physics: Whether robots have legs and dynamics.
        expected: `solved`, or how a problem without a plan has to be refused, see `samplers`.
        trials: Number of trials.
        feasible: Of these, in worlds that can be crossed.
        feasible_successes: Of those.
        successes: In whatever world.
        ran: Trials of which the checker had something to judge.
        hit: Trials with an avoidable collision.
        touched: Trials with any collision.
        fell: Trials with a fall.
        robots, seconds: Sums over the trials that ran; simulated time in s.
        crossings, strict_crossings: Robots that came across a gap or step, and of these as a leap
            has to be.
        outcomes: How often it ended how, in the order of the report.
        failures, excused: The same of trials that failed in feasible and in other worlds.
        spreads: Of each column of numbers; times and ratios are those of trials that succeeded.
    """

    scenario: str
    disturbance: str
    variant: str
    part: int
    planned: bool
    commanded: bool
    in_physics: bool
    expected: str
    trials: int
    feasible: int
    feasible_successes: int
    successes: int
    ran: int
    hit: int
    touched: int
    fell: int
    robots: int
    seconds: float
    crossings: int
    strict_crossings: int
    outcomes: Mapping[str, int]
    failures: Mapping[str, int]
    excused: Mapping[str, int]
    spreads: Mapping[str, Spread]

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the success in feasible worlds."""
        return wilson(self.feasible_successes, self.feasible)

    @property
    def hit_bound(self) -> float:
        """95 % upper bound of the share of trials with an avoidable collision."""
        return upper_bound(min(self.hit, self.ran), self.ran)


_COUNTS = """
    bool_or(planned), bool_or(commanded), bool_or(in_physics),
    arg_min(expected, place),
    count(*),
    count(*) FILTER (feasible),
    count(*) FILTER (feasible AND success),
    count(*) FILTER (success),
    count(*) FILTER (ran),
    count(*) FILTER (avoidable > 0),
    count(*) FILTER (contacts > 0),
    count(*) FILTER (ran AND falls > 0),
    coalesce(sum(robots) FILTER (ran), 0)::BIGINT,
    coalesce(sum(duration) FILTER (ran), 0.0),
    coalesce(sum(crossings) FILTER (ran), 0)::BIGINT,
    coalesce(sum(strict_crossings) FILTER (ran), 0)::BIGINT,
    histogram(outcome),
    histogram(outcome) FILTER (feasible AND NOT success),
    histogram(outcome) FILTER (NOT feasible AND NOT success)
"""
_NOTHING = Spread(*(None,) * 9)


def cells_of(
    table: TrialTable, where: str = "true", *, over_scenarios: bool = False, part: str = "0"
) -> list[Cell]:
    """The cells in the suite's order: scenario, disturbance, variant; empty ones left out.

    Args:
        table: The trials.
        where: Which of them count, as an SQL expression.
        over_scenarios: Count the trials of all scenarios together.
        part: SQL expression of a whole number; trials of different ones are in different cells.
    """
    measured = {
        name: "success" if name in _OF_SUCCESSES else "true"
        for name, kind, *_ in table.rows("DESCRIBE trials")
        if kind == "DOUBLE"
    }
    spreads = ", ".join(
        f'list_append(quantile_cont("{name}", {_SHARES}) FILTER ({chosen}), '
        f'avg("{name}") FILTER ({chosen}))'
        for name, chosen in measured.items()
    )
    scenario = f"'{ALL}'" if over_scenarios else "min(scenario)"
    keys = ("" if over_scenarios else "scenario_at, ") + "disturbance_at, variant_at"
    query = f"""
        SELECT {scenario}, min(disturbance), min(variant), {part} AS part, {_COUNTS}, {spreads}
        FROM trials WHERE {where} GROUP BY {keys}, part ORDER BY {keys}, part
    """
    found = []
    for row in table.rows(query):
        *counts, outcomes, failures, excused = row[: -len(measured)]
        histograms = [in_order(each or {}) for each in (outcomes, failures, excused)]
        quantiles = [
            Spread(*each) if each and each[0] is not None else _NOTHING
            for each in row[-len(measured) :]
        ]
        values: list[Any] = [*counts, *histograms, dict(zip(measured, quantiles, strict=True))]
        found.append(Cell(*values))
    return found


def in_order(counts: Mapping[str, int]) -> dict[str, int]:
    """Counts by outcome in the order of the report; unknown outcomes last."""
    names = [name for name in OUTCOMES if name in counts]
    return {name: counts[name] for name in (*names, *sorted(set(counts) - set(names)))}


@dataclass(frozen=True)
class Point:
    """What trials in feasible worlds come to, of one level or of a bin of levels, ends included."""

    low: float
    high: float
    cell: Cell

    @property
    def middle(self) -> float:
        """Where the point is drawn."""
        return (self.low + self.high) / 2.0

    @property
    def label(self) -> str:
        """The levels, for people."""
        ends = [f"{end:g}" for end in (self.low, self.high)]
        return ends[0] if ends[0] == ends[1] else f"{ends[0]}–{ends[1]}"


@dataclass(frozen=True)
class Curve:
    """One cell over its levels, in ascending order; `axis` says what the level is the number of."""

    cell: Cell
    axis: str
    points: tuple[Point, ...]


def curves_of(table: TrialTable, cells: Sequence[Cell]) -> dict[str, list[Curve]]:
    """Curves by scenario, all of one scenario over the same bins; none for a single level."""
    known = "feasible AND NOT unsolvable AND level IS NOT NULL"
    query = f"""
        SELECT scenario, list(DISTINCT level ORDER BY level), min(level_name)
        FROM trials WHERE {known} GROUP BY scenario, scenario_at ORDER BY scenario_at
    """
    found = {}
    for scenario, levels, axis in table.rows(query):
        here = [cell for cell in cells if cell.scenario == scenario]
        if len(levels) < 2 or max(cell.feasible for cell in here) < FEWEST_TRIALS:
            continue
        name = scenario.replace("'", "''")
        bins = bins_of(levels)
        part = f"len(list_filter({[low for low, _ in bins]}::DOUBLE[], lambda low: low <= level))"
        points: dict[tuple[str, str], list[Point]] = {}
        for cell in cells_of(table, f"{known} AND scenario = '{name}'", part=part):
            point = Point(*bins[cell.part - 1], cell)
            points.setdefault((cell.disturbance, cell.variant), []).append(point)
        found[scenario] = [
            Curve(cell, axis or "level", tuple(points.get((cell.disturbance, cell.variant), ())))
            for cell in here
        ]
    return found


def bins_of(levels: Sequence[float]) -> list[tuple[float, float]]:
    """Bins of rising levels as (lowest, highest), both inside, none overlapping."""
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
