"""The trials of a campaign as a list that is filtered and sorted."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from cavalcade.campaign.table import read_table
from cavalcade.errors import InputError
from cavalcade.values import did_you_mean

Row = Mapping[str, Any]

_SEARCHED = ("trial", "scenario", "variant", "disturbance", "outcome", "detail")
"""Where a word without a column is looked for."""

_TESTS: dict[str, Callable[[Any, Any], bool]] = {
    "!=": operator.ne,
    "<=": operator.le,
    ">=": operator.ge,
    "=": operator.eq,
    "<": operator.lt,
    ">": operator.gt,
}
_CONDITION = re.compile(r"([A-Za-z_][\w.]*)(!=|<=|>=|=|<|>)(.*)")


class TrialList:
    """A campaign's table, also of one that still goes on.

    Args:
        folder: Of the campaign.

    Attributes:
        folder: Of the campaign.
        rows: All trials.
        columns: What can be asked for and sorted by.

    Raises:
        RecordingError: It cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        kinds, self.rows = read_table(folder)
        used = {name for row in self.rows for name, value in row.items() if value is not None}
        plain = [name for name, kind in kinds.items() if not kind.endswith("[]")]
        self.columns = tuple(name for name in plain if name in used or not self.rows)

    def chosen(self, wanted: str = "", by: str = "trial", falling: bool = False) -> list[Row]:
        """The trials that fulfil all conditions, in the order of a column; nulls come last.

        `wanted` has words such as `crowd`, which names or outcome contain, and conditions such as
        `outcome=collision`, `variant!=published` or `makespan_s>60`.

        Raises:
            InputError: There is no such column, or a text is compared by size.
        """
        tests = [self._test(word) for word in wanted.split()]
        rows = [row for row in self.rows if all(test(row) for test in tests)]
        self._check(by)
        known = sorted((row for row in rows if row.get(by) is not None), key=lambda row: row[by])
        if falling:
            known.reverse()
        return known + [row for row in rows if row.get(by) is None]

    def _test(self, word: str) -> Callable[[Row], bool]:
        match = _CONDITION.fullmatch(word)
        if match is None:
            said = word.lower()
            return lambda row: any(said in str(row.get(name) or "").lower() for name in _SEARCHED)
        column, sign, text = match.groups()
        self._check(column)
        numbers = any(
            isinstance(row.get(column), int | float) and not isinstance(row.get(column), bool)
            for row in self.rows
        )
        if numbers:
            return _number_test(word, column, sign, text)
        if sign not in ("=", "!="):
            raise InputError(f"{column} is no number; expected = or != in {word!r}")
        compare = _TESTS[sign]
        return lambda row: compare(_plain(row.get(column)), text.lower())

    def _check(self, column: str) -> None:
        if column not in self.columns:
            hint = did_you_mean(column, self.columns)
            raise InputError(f"there is no column {column!r}{hint}")


def outcomes(rows: list[Row]) -> str:
    """How many trials there are of each outcome, the most frequent first."""
    counts: dict[str, int] = {}
    for row in rows:
        name = str(row.get("outcome") or "unknown")
        counts[name] = counts.get(name, 0) + 1
    ranked = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return ", ".join(f"{count} {name}" for name, count in ranked)


def _number_test(word: str, column: str, sign: str, text: str) -> Callable[[Row], bool]:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if math.isnan(number):
        raise InputError(f"expected a number after {sign} in {word!r}")
    compare = _TESTS[sign]
    return lambda row: row.get(column) is not None and compare(row[column], number)


def _plain(value: Any) -> str:
    return "" if value is None else str(value).lower()
