"""Numbers and names as people read them.

Texts of the report may hold `code` between backticks and **strong** words; anything that comes
from trials goes through `code` or `plain` first.
"""

from __future__ import annotations

import math

from cavalcade.campaign.statistics import Estimate

NONE = "–"
MINUS = "\N{MINUS SIGN}"
NO_DIFFERENCE = "no difference shown"
TOO_FEW = "too few pairs"


def plain(text: str) -> str:
    """The text with nothing in it that a document would take for markup."""
    return text.replace("`", "'").replace("**", "* *")


def code(text: str) -> str:
    """The text as code."""
    return f"`{plain(text) or ' '}`"


def number(value: float | None, digits: int = 2, factor: float = 1.0) -> str:
    """With so many decimals; a dash where there is none."""
    if value is None:
        return NONE
    text = f"{value * factor:.{digits}f}"
    # No minus before a zero; a true minus before all else.
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", MINUS)


def count(value: int) -> str:
    """With thousands set apart."""
    return f"{value:,}"


def share(hits: int, trials: int) -> str:
    """In percent; 100 % is said only where there was no exception, 0 % only without a hit."""
    if trials == 0:
        return NONE
    value = 100.0 * hits / trials
    for digits in (1, 2, 3):
        text = f"{value:.{digits}f}"
        rounded = float(text)
        if (hits < trials and rounded >= 100.0) or (hits > 0 and rounded <= 0.0):
            continue
        return f"{text} %"
    return f"{value:.4f} %"


def interval(ends: tuple[float, float], trials: int) -> str:
    """Of a share, in percent; no end is rounded so that the interval looks narrower."""
    if trials == 0:
        return NONE
    low = math.floor(1000.0 * ends[0] + 1e-9) / 10.0
    high = math.ceil(1000.0 * ends[1] - 1e-9) / 10.0
    return f"[{low:.1f}, {high:.1f}]"


def bound(value: float, trials: int) -> str:
    """An upper bound of a share, in percent, rounded up to two figures."""
    if trials == 0:
        return NONE
    percent = 100.0 * value
    digits = 0 if percent >= 10.0 else 1 if percent >= 1.0 else 2
    return f"{math.ceil(percent * 10**digits - 1e-9) / 10**digits:.{digits}f} %"


def difference(estimate: Estimate, digits: int) -> str:
    """With its sign and interval."""
    if math.isinf(estimate.low) or math.isinf(estimate.high):
        return f"{signed(estimate.value, digits)} ({TOO_FEW})"
    ends = f"[{signed(estimate.low, digits)}, {signed(estimate.high, digits)}]"
    return f"{signed(estimate.value, digits)} {ends}"


def signed(value: float, digits: int) -> str:
    """With its sign; zero has none."""
    text = f"{abs(value):.{digits}f}"
    if float(text) == 0.0:
        return text
    return f"{'+' if value > 0.0 else MINUS}{text}"


def p_value(value: float) -> str:
    """With two figures."""
    if value < 0.001:
        return "< 0.001"
    return f"{value:.3f}" if value < 0.1 else f"{value:.2f}"
