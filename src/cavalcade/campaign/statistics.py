"""Intervals and paired comparisons for figures that come from a finite number of trials.

All intervals are two-sided with 95 % confidence unless a docstring says otherwise. They are
random only through the trials: the same trials give the same figures.

Sources: Wilson, J. Am. Stat. Assoc. 22 (1927) 209; Clopper and Pearson, Biometrika 26 (1934) 404;
Hanley and Lippman-Hand, J. Am. Med. Assoc. 249 (1983) 1743 (the rule of three); McNemar,
Psychometrika 12 (1947) 153; Newcombe, Stat. Med. 17 (1998) 2635 (method 10, paired proportions).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.95
"""Of all intervals and bounds."""

FEWEST = 6
"""A sign test can tell nothing of fewer pairs, and whether they are normal nobody can."""


@dataclass(frozen=True)
class Estimate:
    """A figure with its interval, all in the figure's own unit.

    Attributes:
        value: The figure.
        low, high: Ends of its interval; infinite where the trials are too few for an end.
    """

    value: float
    low: float
    high: float

    @property
    def includes_zero(self) -> bool:
        """Whether the interval leaves it open on which side of zero the truth lies."""
        return self.low <= 0.0 <= self.high

    def scaled(self, factor: float) -> Estimate:
        """The same in another unit; `factor` is positive."""
        return Estimate(self.value * factor, self.low * factor, self.high * factor)


@dataclass(frozen=True)
class PairedProportions:
    """How often something happened under two treatments of the same worlds.

    Attributes:
        both, first_only, second_only, neither: Numbers of pairs.
        difference: Share under the second less share under the first, -1 to 1.
        p_value: McNemar's exact one: how likely so lopsided a split of the pairs that differ is
            if none of the treatments is better.
    """

    both: int
    first_only: int
    second_only: int
    neither: int
    difference: Estimate
    p_value: float

    @property
    def pairs(self) -> int:
        """Number of pairs."""
        return self.both + self.first_only + self.second_only + self.neither


@dataclass(frozen=True)
class PairedValues:
    """A measured quantity under two treatments of the same worlds.

    Attributes:
        pairs: Number of pairs.
        mean: Mean of second less first, with Student's t interval; fewer than `FEWEST` pairs are
            too few for one.
        median: Median of second less first, with the sign test's interval, which supposes
            nothing about the distribution.
    """

    pairs: int
    mean: Estimate
    median: Estimate


def wilson(hits: int, trials: int) -> tuple[float, float]:
    """Wilson's score interval of a proportion; (0, 1) without trials.

    Raises:
        ValueError: `hits` is not between 0 and `trials`.
    """
    _check_counts(hits, trials)
    if trials == 0:
        return 0.0, 1.0
    from scipy.stats import binomtest

    found = binomtest(hits, trials).proportion_ci(CONFIDENCE, method="wilson")
    # Rounding may leave the ends a hair inside of what was observed.
    return min(float(found.low), hits / trials), max(float(found.high), hits / trials)


def upper_bound(hits: int, trials: int) -> float:
    """One-sided Clopper–Pearson bound: the largest share that the count does not speak against.

    Without hits it is `1 - 0.05 ** (1 / trials)`, which the rule of three rounds to `3 / trials`.

    Raises:
        ValueError: `hits` is not between 0 and `trials`.
    """
    _check_counts(hits, trials)
    if trials == 0:
        return 1.0
    from scipy.stats import binomtest

    test = binomtest(hits, trials, alternative="less")
    return float(test.proportion_ci(CONFIDENCE, method="exact").high)


def paired_proportions(first: Sequence[bool], second: Sequence[bool]) -> PairedProportions | None:
    """Compare how often something happened in the same worlds; None without pairs.

    The interval is Newcombe's method 10: Wilson's intervals of both shares, joined with the
    correlation of the pairs. The p-value is exact, so that for few differing pairs it may exceed
    0.05 although the interval excludes zero.

    Args:
        first, second: `(P,)` whether it happened; entry k of both comes from the same world.

    Raises:
        ValueError: They have different lengths.
    """
    a = np.asarray(first, dtype=bool)
    b = np.asarray(second, dtype=bool)
    if a.shape != b.shape:
        raise ValueError("paired values must come in equal numbers")
    if not len(a):
        return None
    both, first_only = int(np.sum(a & b)), int(np.sum(a & ~b))
    second_only, neither = int(np.sum(~a & b)), int(np.sum(~a & ~b))
    counts = (both, first_only, second_only, neither)
    p_value = mcnemar_exact(first_only, second_only)
    return PairedProportions(*counts, newcombe_paired(*counts), p_value)


def newcombe_paired(both: int, first_only: int, second_only: int, neither: int) -> Estimate:
    """Difference of paired shares, second less first, with Newcombe's interval (method 10).

    Raises:
        ValueError: A count is negative, or there are no pairs.
    """
    counts = (both, first_only, second_only, neither)
    pairs = sum(counts)
    if pairs == 0 or min(counts) < 0:
        raise ValueError("expected counts of pairs, at least one pair")
    hits = (both + second_only, both + first_only)
    p2, p1 = hits[0] / pairs, hits[1] / pairs
    (l2, u2), (l1, u1) = wilson(hits[0], pairs), wilson(hits[1], pairs)
    phi = _correlation(*counts)
    below = (p2 - l2) ** 2 - 2.0 * phi * (p2 - l2) * (u1 - p1) + (u1 - p1) ** 2
    above = (u2 - p2) ** 2 - 2.0 * phi * (u2 - p2) * (p1 - l1) + (p1 - l1) ** 2
    value = (second_only - first_only) / pairs
    low, high = value - math.sqrt(max(below, 0.0)), value + math.sqrt(max(above, 0.0))
    return Estimate(value, max(low, -1.0), min(high, 1.0))


def mcnemar_exact(first_only: int, second_only: int) -> float:
    """McNemar's exact two-sided p-value; 1 where no pair differs."""
    differing = first_only + second_only
    if differing == 0:
        return 1.0
    from scipy.stats import binomtest

    return float(binomtest(first_only, differing, 0.5).pvalue)


def paired_values(
    first: Sequence[float | None], second: Sequence[float | None]
) -> PairedValues | None:
    """Compare a quantity in the same worlds; pairs with a value missing do not count.

    Args:
        first, second: `(P,)`; entry k of both comes from the same world. None, nan and inf
            count as missing.

    Returns:
        The comparison, or None with fewer than two pairs.

    Raises:
        ValueError: They have different lengths.
    """
    found = [
        b - a
        for a, b in zip(first, second, strict=True)
        if a is not None and b is not None and math.isfinite(a) and math.isfinite(b)
    ]
    if len(found) < 2:
        return None
    differences = np.array(found)
    return PairedValues(len(found), mean_interval(differences), median_interval(differences))


def mean_interval(values: Sequence[float] | np.ndarray) -> Estimate:
    """The mean of one value or more, `(P,)`, with Student's t interval.

    With fewer than `FEWEST` values it has no ends.
    """
    from scipy.stats import t

    sample = np.asarray(values, dtype=float)
    mean = float(sample.mean())
    if len(sample) < FEWEST:
        return Estimate(mean, -math.inf, math.inf)
    error = float(sample.std(ddof=1)) / math.sqrt(len(sample))
    half = float(t.ppf(0.5 + CONFIDENCE / 2.0, len(sample) - 1)) * error
    return Estimate(mean, mean - half, mean + half)


def median_interval(values: Sequence[float] | np.ndarray) -> Estimate:
    """The median of one value or more, `(P,)`, with the interval of the sign test.

    Its ends are values of the sample, chosen by the binomial distribution, so that it covers the
    median of whatever distribution with at least 95 %; with fewer than six values it has no ends.
    """
    from scipy.stats import binom

    sample = np.sort(np.asarray(values, dtype=float))
    # The r-th smallest and r-th largest cover if at most r - 1 values lie on the wrong side.
    rank = int(binom.ppf((1.0 - CONFIDENCE) / 2.0, len(sample), 0.5))
    middle = float(np.median(sample))
    if rank == 0:
        return Estimate(middle, -math.inf, math.inf)
    return Estimate(middle, float(sample[rank - 1]), float(sample[-rank]))


def _check_counts(hits: int, trials: int) -> None:
    if not 0 <= hits <= trials:
        raise ValueError(f"expected 0 <= hits <= trials, not {hits} of {trials}")


def _correlation(both: int, first_only: int, second_only: int, neither: int) -> float:
    """Newcombe's phi of the pairs, a positive one with his continuity correction."""
    margins = (
        (both + first_only) * (second_only + neither) * (both + second_only)
        * (first_only + neither)
    )  # fmt: skip
    if margins == 0:
        return 0.0
    product = float(both * neither - first_only * second_only)
    if product > 0:
        product = max(product - (both + first_only + second_only + neither) / 2.0, 0.0)
    return product / math.sqrt(margins)
