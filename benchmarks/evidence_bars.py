"""Bars that a suite has to clear, and the figures they are judged by."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from evidence_trials import Outcome

Z95 = 1.959964
"""Standard normal quantile of a two-sided 95 % interval."""


@dataclass(frozen=True)
class Bar:
    """One requirement and what was found.

    Attributes:
        text: What is required.
        found: What was measured, as text.
        met: Whether it holds.
    """

    text: str
    found: str
    met: bool

    def line(self) -> str:
        """One line for people."""
        return f"  [{'met' if self.met else 'MISSED'}] {self.text}: {self.found}"


def wilson(hits: int, trials: int) -> tuple[float, float]:
    """95 % interval of a proportion (Wilson 1927); (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    share, z2 = hits / trials, Z95**2
    middle = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    half = Z95 / (1 + z2 / trials)
    half *= math.sqrt(share * (1 - share) / trials + z2 / (4 * trials**2))
    return max(0.0, middle - half), min(1.0, middle + half)


def proportion(text: str, hits: int, trials: int, least: float) -> Bar:
    """At least the share `least` of the trials must be hits."""
    low, high = wilson(hits, trials)
    found = f"{hits} of {trials}"
    if trials:
        found += f" = {hits / trials:.1%}, 95 % interval {low:.1%} to {high:.1%}"
    return Bar(f"{text} >= {least:.0%}", found, trials > 0 and hits >= least * trials)


def none_of(text: str, found: Sequence[str], trials: int) -> Bar:
    """Nothing of the kind may occur; `found` names the trials where it did."""
    _, high = wilson(len(found), trials)
    words = f"{len(found)} of {trials} (95 % interval to {high:.1%})"
    return Bar(text, f"{words}: {', '.join(found)}" if found else words, trials > 0 and not found)


def at_most(text: str, value: float | None, limit: float, unit: str = "") -> Bar:
    """The figure must not exceed the limit; None, where it could not be measured, misses it."""
    said = "not measured" if value is None else f"{value:.3f}{unit}"
    return Bar(f"{text} <= {limit:g}{unit}", said, value is not None and value <= limit)


def median(values: Iterable[float]) -> float | None:
    """Their median; None without any."""
    known = list(values)
    return float(np.median(known)) if known else None


def distribution(text: str, values: Iterable[float | None]) -> str:
    """One line with quantiles."""
    known = np.array([value for value in values if value is not None], dtype=float)
    if not len(known):
        return f"  {text}: none"
    low, first, middle, third, high = np.percentile(known, [0, 25, 50, 75, 100])
    p95 = np.percentile(known, 95)
    return (
        f"  {text}: min {low:.3f}, quartiles {first:.3f} {middle:.3f} {third:.3f}, "
        f"95 % {p95:.3f}, max {high:.3f} (n = {len(known)})"
    )


def reasons(outcomes: Sequence[Outcome]) -> str:
    """How the trials ended, with the names of those that failed."""
    failed = [outcome for outcome in outcomes if not outcome.success]
    counts = Counter(outcome.reason for outcome in failed)
    parts = [f"{len(outcomes) - len(failed)} succeeded"]
    for reason, count in counts.most_common():
        names = ", ".join(o.trial.name for o in failed if o.reason == reason)
        parts.append(f"{count} {reason} ({names})")
    return "  ended: " + "; ".join(parts)
