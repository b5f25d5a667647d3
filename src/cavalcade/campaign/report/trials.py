"""Trial lines as values that the report counts and compares."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cavalcade.campaign.draws.model import EXPECTED, SOLVED
from cavalcade.campaign.methods import METHOD_VARIANTS
from cavalcade.campaign.scrubbing import scrubbed

NO_DISTURBANCE = "none"


@dataclass(frozen=True)
class Trial:
    """One line of `trials.jsonl`; keys that a line lacks get the values said here.

    Attributes:
        name: Unique id.
        scenario: The group of worlds it belongs to.
        variant: Of the planner.
        disturbance: `none` unless the suite names several.
        seed: What its world was drawn from.
        outcome: How it ended.
        detail: One line about it, without paths.
        success: Arrived, and the checker found nothing that could have been avoided.
        feasible: The world can be crossed, by a test that does not use the planner.
        level: Where the world lies on the suite's curve, or None.
        level_name: What that is the number of.
        contacts: Collisions that the checker found; of these
        avoidable: could have been avoided.
        violations: What the checker said first.
        summary: The run's figures; empty where there are none.
        expected: `solved`, or how a problem without a plan has to be refused, see `draws`.
        time_ratio: Makespan over the longest lower bound at top speed; of plans for goals of
            single robots over the makespan of the slowest robot alone.
        length_ratio: Of such plans: summed lengths over summed lower bounds.
        single_time_ratio: Of such plans: planning time over that of all robots alone.
        planned: Whether the robots have goals of their own.
        line: The line itself.
    """

    name: str
    scenario: str
    variant: str
    disturbance: str = NO_DISTURBANCE
    seed: int = 0
    outcome: str = "unknown"
    detail: str = ""
    success: bool = False
    feasible: bool = True
    level: float | None = None
    level_name: str | None = None
    contacts: int = 0
    avoidable: int = 0
    violations: tuple[str, ...] = ()
    summary: Mapping[str, Any] = field(default_factory=dict)
    expected: str = SOLVED
    time_ratio: float | None = None
    length_ratio: float | None = None
    single_time_ratio: float | None = None
    planned: bool = False
    line: Mapping[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def world(self) -> tuple[str, int]:
        """What trials of other variants and disturbances share with this one."""
        return self.scenario, self.seed

    def number(self, key: str) -> float | None:
        """The summary's figure of that dotted key; None if it has none or it is not finite."""
        value: Any = self.summary
        for part in key.split("."):
            value = value.get(part) if isinstance(value, Mapping) else None
        return known(value)

    def measured(self, key: str) -> float | None:
        """What the campaign measured beside the summary; None if it has nothing of that key."""
        said = self.line.get("measured")
        return known(said.get(key)) if isinstance(said, Mapping) else None

    @property
    def commanded(self) -> bool:
        """Whether the robots were told how to walk, without a planner."""
        return self.summary.get("method") == "commands"

    @property
    def in_physics(self) -> bool:
        """Whether the robots had legs and dynamics."""
        return self.number("physics.max_tilt_rad") is not None

    @property
    def hopeless(self) -> bool:
        """Whether there is no plan by construction, so that refusing is the success."""
        return self.expected in EXPECTED

    @property
    def length(self) -> float | None:
        """Summed length of the robots' ways, m; None unless it succeeded."""
        lengths = self.summary.get("path_length_m") if self.success else None
        if not isinstance(lengths, Sequence) or not lengths:
            return None
        parts = [known(length) for length in lengths]
        return None if None in parts else sum(part for part in parts if part is not None)

    @property
    def said(self) -> str:
        """What there is to say about how it ended: the detail, else the first violation."""
        return self.detail or (self.violations[0] if self.violations else "")

    @property
    def gap(self) -> float | None:
        """Smallest gap between footprints, or to an obstacle, m."""
        return self.number("min_footprint_gap_m")

    @property
    def time(self) -> float | None:
        """When the last robot was at its place for good, s; None unless it succeeded."""
        if not self.success:
            return None
        makespan = self.number("makespan_s")
        return makespan if makespan is not None else self.number("sim_time_s")


def known(value: Any) -> float | None:
    """The value as a finite number, else None."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if math.isfinite(value) else None


def read_trials(lines: Iterable[Mapping[str, Any]]) -> list[Trial]:
    """The trials of the lines; of several lines of one trial the last counts."""
    latest = {str(line.get("trial")): line for line in lines}
    return [_trial(name, line) for name, line in latest.items()]


def _trial(name: str, line: Mapping[str, Any]) -> Trial:
    summary = line.get("summary") or {}
    level_name = line.get("level_name")
    variant = str(line.get("variant") or "?")
    planned = variant in METHOD_VARIANTS
    measured = line.get("measured") or {}
    return Trial(
        name=name,
        scenario=str(line.get("scenario") or "?"),
        variant=variant,
        disturbance=str(line.get("disturbance") or NO_DISTURBANCE),
        seed=int(line.get("seed") or 0),
        outcome=str(line.get("outcome") or "unknown"),
        detail=scrubbed(str(line.get("detail") or "")),
        success=line.get("success") is True,
        feasible=line.get("feasible") is not False,
        level=known(line.get("level")),
        level_name=str(level_name) if level_name else None,
        contacts=int(line.get("contacts") or 0),
        avoidable=int(line.get("avoidable") or 0),
        violations=tuple(scrubbed(str(text)) for text in line.get("violations") or ()),
        summary=summary if isinstance(summary, Mapping) else {},
        expected=str(line.get("expected") or SOLVED),
        time_ratio=known(measured.get("makespan_ratio" if planned else "time_ratio")),
        length_ratio=known(measured.get("length_ratio")),
        single_time_ratio=known(measured.get("single_time_ratio")),
        planned=planned,
        line=line,
    )


@dataclass(frozen=True)
class Order:
    """The order in which the suite names its scenarios, variants and disturbances.

    Attributes:
        scenarios, variants, disturbances: Those that there are.
        references: What a variant is compared with, where that is not the first one.
    """

    scenarios: tuple[str, ...]
    variants: tuple[str, ...]
    disturbances: tuple[str, ...]
    references: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, suite: object, trials: Sequence[Trial]) -> Order:
        """The suite's own order where it has one; names it does not know follow by the alphabet.

        Without an order of the suite, `cavalcade` and `none` come first among their kind.
        """
        groups = getattr(suite, "worlds", None) or ()
        named = [str(getattr(group, "name", "")) for group in groups]
        variants = [str(name) for name in getattr(suite, "variants", None) or ("cavalcade",)]
        disturbances = [
            str(name) for name in getattr(suite, "disturbances", None) or (NO_DISTURBANCE,)
        ]
        return cls(
            _arranged(named, {trial.scenario for trial in trials}),
            _arranged(variants, {trial.variant for trial in trials}),
            _arranged(disturbances, {trial.disturbance for trial in trials}),
            dict(getattr(suite, "references", None) or {}),
        )

    def sorted(self, trials: Iterable[Trial]) -> list[Trial]:
        """The trials in the suite's order: scenario, seed, disturbance, variant."""
        return sorted(
            trials,
            key=lambda trial: (
                self.scenarios.index(trial.scenario),
                trial.seed,
                self.disturbances.index(trial.disturbance),
                self.variants.index(trial.variant),
                trial.name,
            ),
        )


def _arranged(named: Iterable[str], present: set[str]) -> tuple[str, ...]:
    first = [name for name in dict.fromkeys(named) if name in present]
    return (*first, *sorted(present - set(first)))
