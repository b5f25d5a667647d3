import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cavalcade.campaign.report.wording import (
    bound,
    difference,
    interval,
    number,
    p_value,
    share,
    signed,
)
from cavalcade.campaign.statistics import Estimate, upper_bound, wilson


@pytest.mark.parametrize(
    ("hits", "trials", "text"),
    [
        (0, 0, "–"),
        (1, 1, "100.0 %"),
        (0, 9, "0.0 %"),
        (9999, 10000, "99.99 %"),
        (1, 3000, "0.03 %"),
    ],
)
def test_share(hits, trials, text):
    assert share(hits, trials) == text


@given(st.integers(1, 20000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_rounding_never_flatters(count):
    hits, trials = count
    low, high = wilson(hits, trials)
    told = [float(end) / 100.0 for end in interval((low, high), trials).strip("[]").split(", ")]
    assert told[0] <= low + 1e-9
    assert told[1] >= high - 1e-9
    most = upper_bound(hits, trials)
    assert float(bound(most, trials).split()[0]) / 100.0 >= most - 1e-9
    assert (share(hits, trials) == "100.0 %") == (hits == trials)
    assert (share(hits, trials) == "0.0 %") == (hits == 0)


def test_signs():
    assert signed(-1.25, 2) == "−1.25"
    assert signed(0.004, 2) == "0.00"
    assert signed(3.0, 1) == "+3.0"
    assert number(-0.0001, 2) == "0.00"
    assert number(None) == "–"
    assert difference(Estimate(1.0, -math.inf, math.inf), 1) == "+1.0 (too few pairs)"


def test_p_values():
    assert p_value(0.00001) == "< 0.001"
    assert p_value(0.0703) == "0.070"
    assert p_value(1.0) == "1.00"
