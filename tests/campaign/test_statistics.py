import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, t

from cavalcade.campaign.statistics import (
    Estimate,
    mcnemar_exact,
    mean_interval,
    median_interval,
    newcombe_paired,
    paired_proportions,
    paired_values,
    upper_bound,
    wilson,
)

counts = st.tuples(st.integers(0, 300), st.integers(0, 300)).map(lambda ab: (min(ab), max(ab)))
pairs = st.tuples(*[st.integers(0, 60)] * 4).filter(any)


@pytest.mark.parametrize(
    ("hits", "trials", "low", "high"),
    [  # Newcombe, Stat. Med. 17 (1998) 857, table I, method 3
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0000, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson_gives_the_published_intervals(hits, trials, low, high):
    assert wilson(hits, trials) == (pytest.approx(low, abs=5e-5), pytest.approx(high, abs=5e-5))


def test_wilson_without_trials_knows_nothing():
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize("count", [(-1, 3), (4, 3)])
@pytest.mark.parametrize("function", [wilson, upper_bound])
def test_counts_must_make_sense(function, count):
    with pytest.raises(ValueError, match="hits"):
        function(*count)


@given(counts)
def test_wilson_holds_the_share_and_mirrors(count):
    hits, trials = count
    low, high = wilson(hits, trials)
    assert 0.0 <= low <= high <= 1.0
    if trials:
        assert low <= hits / trials <= high
    mirrored = wilson(trials - hits, trials)
    assert mirrored == (pytest.approx(1.0 - high, abs=1e-12), pytest.approx(1.0 - low, abs=1e-12))


def test_wilson_covers_with_95_percent_on_average():
    shares = np.linspace(0.005, 0.995, 199)
    for trials in (20, 100):
        ends = np.array([wilson(hits, trials) for hits in range(trials + 1)])
        weight = binom.pmf(np.arange(trials + 1), trials, shares[:, None])
        covers = (ends[:, 0] <= shares[:, None]) & (shares[:, None] <= ends[:, 1])
        coverage = (weight * covers).sum(axis=1)
        assert coverage.mean() == pytest.approx(0.95, abs=0.01)
        assert coverage.min() > 0.82


@pytest.mark.parametrize("trials", [30, 100, 1000, 10000])
def test_upper_bound_without_hits_is_the_rule_of_three(trials):
    assert upper_bound(0, trials) == pytest.approx(1.0 - 0.05 ** (1.0 / trials))
    assert upper_bound(0, trials) == pytest.approx(3.0 / trials, rel=0.06)


@given(counts)
def test_upper_bound_leaves_five_percent(count):
    hits, trials = count
    bound = upper_bound(hits, trials)
    if hits == trials:
        assert bound == 1.0
    else:  # the definition: so few hits or fewer have 5 % probability at the bound
        assert binom.cdf(hits, trials, bound) == pytest.approx(0.05, abs=1e-6)


@pytest.mark.parametrize(
    ("table", "low", "high"),
    [
        # Newcombe, Stat. Med. 17 (1998) 2635, table II, method 10; first less second there
        ((36, 12, 2, 0), -0.3404, -0.0569),
        # Fagerland, Lydersen, Laake, Stat. Med. 33 (2014) 2850: Bentur's children
        ((1, 1, 7, 12), 0.026, 0.507),
    ],
)
def test_newcombe_gives_the_published_intervals(table, low, high):
    found = newcombe_paired(*table)
    assert found.value == pytest.approx((table[2] - table[1]) / sum(table))
    assert (found.low, found.high) == (
        pytest.approx(low, abs=5e-4),
        pytest.approx(high, abs=5e-4),
    )


@given(pairs)
def test_newcombe_is_antisymmetric_and_holds_the_difference(table):
    both, first, second, neither = table
    found = newcombe_paired(both, first, second, neither)
    turned = newcombe_paired(both, second, first, neither)
    complement = newcombe_paired(neither, second, first, both)
    assert -1.0 <= found.low <= found.value <= found.high <= 1.0
    for other in (turned, complement):
        assert (other.low, other.value, other.high) == (
            pytest.approx(-found.high, abs=1e-9),
            pytest.approx(-found.value, abs=1e-9),
            pytest.approx(-found.low, abs=1e-9),
        )


def test_newcombe_covers_by_brute_force():
    # All outcomes of 25 pairs, for two sets of probabilities of the four kinds.
    trials = 25
    for chances in ((0.85, 0.03, 0.10, 0.02), (0.6, 0.1, 0.1, 0.2)):
        truth, coverage = chances[2] - chances[1], 0.0
        for a, b, c in product(range(trials + 1), repeat=3):
            d = trials - a - b - c
            if d < 0:
                continue
            ways = math.comb(trials, a) * math.comb(trials - a, b) * math.comb(d + c, c)
            chance = ways * math.prod(p**k for p, k in zip(chances, (a, b, c, d), strict=True))
            if chance < 1e-6:
                continue
            found = newcombe_paired(a, b, c, d)
            coverage += chance * (found.low <= truth <= found.high)
        assert 0.93 < coverage < 0.995


@given(st.integers(0, 30), st.integers(0, 30))
def test_mcnemar_is_the_sign_test(first, second):
    n = first + second
    tail = sum(math.comb(n, k) for k in range(min(first, second) + 1)) / 2**n
    assert mcnemar_exact(first, second) == pytest.approx(min(1.0, 2.0 * tail))


def test_mcnemar_of_a_published_table():
    assert mcnemar_exact(1, 7) == pytest.approx(0.0703, abs=5e-5)  # Fagerland et al., as above


def test_paired_proportions_counts_pairs():
    found = paired_proportions([True, True, False, False, True], [True, False, True, False, False])
    assert found is not None
    assert (found.both, found.first_only, found.second_only, found.neither) == (1, 2, 1, 1)
    assert found.pairs == 5
    assert found.difference.value == pytest.approx(-0.2)
    assert paired_proportions([], []) is None
    with pytest.raises(ValueError, match="equal numbers"):
        paired_proportions([True], [])


def test_treatments_that_never_differ_show_no_difference():
    found = paired_proportions([True] * 100, [True] * 100)
    assert found is not None
    assert found.difference.includes_zero
    assert found.p_value == 1.0
    assert found.difference.high < 0.04  # and little room for one


def test_mean_interval_of_students_sleep_data():
    # Student, Biometrika 6 (1908) 1: hours of sleep gained, second drug less first; the interval
    # is what textbooks print for it.
    first = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
    second = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
    found = paired_values(first, second)
    assert found is not None
    assert found.pairs == 10
    assert (found.mean.value, found.mean.low, found.mean.high) == (
        pytest.approx(1.58),
        pytest.approx(0.7001142, abs=1e-6),
        pytest.approx(2.4598858, abs=1e-6),
    )


@pytest.mark.parametrize("size", [1, 2, 5])
def test_few_values_have_no_interval(size):
    found = mean_interval(np.arange(size, dtype=float))
    assert (found.low, found.high) == (-math.inf, math.inf)


@given(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=60))
def test_mean_interval_against_the_formula(values):
    found = mean_interval(values)
    half = t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / math.sqrt(len(values))
    assert found.high - found.low == pytest.approx(2.0 * half)
    assert found.low <= found.value <= found.high


def test_median_interval_covers_with_95_percent_and_no_wider_would_do():
    for size in (5, 6, 10, 25, 60, 101):
        found = median_interval(np.arange(size, dtype=float))
        if size < 6:
            assert math.isinf(found.low)
            assert math.isinf(found.high)
            continue
        rank = round(found.low) + 1
        assert found.high == size - rank
        assert 1.0 - 2.0 * binom.cdf(rank - 1, size, 0.5) >= 0.95
        assert 1.0 - 2.0 * binom.cdf(rank, size, 0.5) < 0.95


def test_missing_values_take_their_pair_away():
    first = [1.0, None, 3.0, math.nan, 5.0]
    second = [2.0, 2.0, None, 4.0, 7.0]
    found = paired_values(first, second)
    assert found is not None
    assert found.pairs == 2
    assert found.mean.value == pytest.approx(1.5)
    assert paired_values([1.0, None], [2.0, 2.0]) is None
    with pytest.raises(ValueError):
        paired_values([1.0], [])


def test_equal_differences_have_an_interval_of_no_width():
    found = paired_values([1.0] * 8, [3.0] * 8)
    assert found is not None
    assert found.mean == Estimate(2.0, 2.0, 2.0) == found.median
    assert not found.mean.includes_zero
