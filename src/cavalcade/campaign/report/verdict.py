"""What the trials of one scenario, variant and disturbance come to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from cavalcade.campaign.report.trials import Order, Trial
from cavalcade.campaign.statistics import quantile, upper_bound, wilson

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

HIGH = 0.95
LOW = 0.05


@dataclass(frozen=True)
class Cell:
    """All trials of one scenario, variant and disturbance.

    Attributes:
        scenario, variant, disturbance: Which.
        trials: In the suite's order.
    """

    scenario: str
    variant: str
    disturbance: str
    trials: tuple[Trial, ...]

    @cached_property
    def feasible(self) -> tuple[Trial, ...]:
        """Those in worlds that can be crossed."""
        return tuple(trial for trial in self.trials if trial.feasible)

    @cached_property
    def succeeded(self) -> tuple[Trial, ...]:
        """Those that succeeded, in whatever world."""
        return tuple(trial for trial in self.trials if trial.success)

    @property
    def feasible_successes(self) -> int:
        """Successes in feasible worlds."""
        return sum(trial.success for trial in self.feasible)

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the success in feasible worlds."""
        return wilson(self.feasible_successes, len(self.feasible))

    @property
    def planned(self) -> bool:
        """Whether the robots have goals of their own."""
        return any(trial.planned for trial in self.trials)

    @property
    def commanded(self) -> bool:
        """Whether the robots were told how to walk, without a planner."""
        return any(trial.commanded for trial in self.trials)

    @property
    def in_physics(self) -> bool:
        """Whether the robots have legs and dynamics."""
        return any(trial.in_physics for trial in self.trials)

    @property
    def run(self) -> tuple[Trial, ...]:
        """Those of which the robots moved, so that the checker had something to judge."""
        return tuple(trial for trial in self.trials if trial.summary)

    @property
    def hit(self) -> int:
        """Trials with an avoidable collision."""
        return sum(trial.avoidable > 0 for trial in self.trials)

    @property
    def touched(self) -> int:
        """Trials with any collision."""
        return sum(trial.contacts > 0 for trial in self.trials)

    @property
    def hit_bound(self) -> float:
        """95 % upper bound of the share of trials with an avoidable collision."""
        return upper_bound(min(self.hit, len(self.run)), len(self.run))

    @cached_property
    def outcomes(self) -> Mapping[str, int]:
        """How often it ended how, in the order of the report."""
        return in_order(Counter(trial.outcome for trial in self.trials))

    def spread(self, key: str) -> Spread:
        """Of a figure of the summary over the trials that ran."""
        return Spread.of(trial.number(key) for trial in self.trials)

    @property
    def time(self) -> Spread:
        """Seconds of the trials that succeeded."""
        return Spread.of(trial.time for trial in self.succeeded)

    @property
    def time_ratio(self) -> Spread:
        """Over the lower bound, of the trials that succeeded."""
        return Spread.of(trial.time_ratio for trial in self.succeeded)

    @property
    def length(self) -> Spread:
        """Summed lengths in m, of the trials that succeeded."""
        return Spread.of(trial.length for trial in self.succeeded)

    @property
    def length_ratio(self) -> Spread:
        """Summed lengths over the lower bounds, of the trials that succeeded."""
        return Spread.of(trial.length_ratio for trial in self.succeeded)

    @property
    def single_time_ratio(self) -> Spread:
        """Planning time over that of the robots alone, of the trials that succeeded."""
        return Spread.of(trial.single_time_ratio for trial in self.succeeded)

    @property
    def planning_time(self) -> Spread:
        """Seconds of the trials that ran."""
        return self.spread("planning_time_s")

    @property
    def formation_error(self) -> Spread:
        """Mean error of a trial in m, of the trials that succeeded."""
        return Spread.of(trial.number("formation_error_m.mean") for trial in self.succeeded)


@dataclass(frozen=True)
class Spread:
    """Quantiles of a measured quantity; None where nothing was measured.

    Attributes:
        count: Number of values.
        least, p5, p25, median, p75, p95, most: Of the values.
    """

    count: int
    least: float | None
    p5: float | None
    p25: float | None
    median: float | None
    p75: float | None
    p95: float | None
    most: float | None

    @classmethod
    def of(cls, values: Iterable[float | None]) -> Spread:
        """Of the values that are there."""
        sample = [value for value in values if value is not None]
        return cls(
            len(sample), *(quantile(sample, q) for q in (0.0, LOW, 0.25, 0.5, 0.75, HIGH, 1.0))
        )


def cells_of(trials: Sequence[Trial], order: Order) -> list[Cell]:
    """The cells in the suite's order: scenario, disturbance, variant; empty ones left out."""
    members: dict[tuple[str, str, str], list[Trial]] = {}
    for trial in order.sorted(trials):
        members.setdefault((trial.scenario, trial.variant, trial.disturbance), []).append(trial)
    return [
        Cell(scenario, variant, disturbance, tuple(members[scenario, variant, disturbance]))
        for scenario in order.scenarios
        for disturbance in order.disturbances
        for variant in order.variants
        if (scenario, variant, disturbance) in members
    ]


def in_order(counts: Mapping[str, int]) -> dict[str, int]:
    """Counts by outcome in the order of the report; unknown outcomes last."""
    names = [name for name in OUTCOMES if name in counts]
    return {name: counts[name] for name in (*names, *sorted(set(counts) - set(names)))}
