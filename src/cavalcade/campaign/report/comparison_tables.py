"""Tables of the report with a row per paired comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from cavalcade.campaign.report.comparisons import Comparison, Factor, Quantity, references_of
from cavalcade.campaign.report.tables import Table, scenario_text, table_of
from cavalcade.campaign.report.wording import (
    code,
    count,
    difference,
    p_value,
    proportion_text,
    share,
    value_text,
)
from cavalcade.campaign.statistics import PairedProportions, PairedValues

_Found = TypeVar("_Found", PairedProportions, PairedValues)

_CONFIDENCE = "[95\N{NO-BREAK SPACE}%]"


def comparison_tables(
    comparisons: Sequence[Comparison], factor: Factor, setting: str
) -> list[tuple[str, Table | None]]:
    """Title and table of successes, collisions and each quantity.

    The table of collisions is None where no trial of any pair had one.

    Args:
        comparisons: At least one.
        factor: What is compared.
        setting: What the comparisons' setting is called; empty where there is only one.
    """
    references = references_of(comparisons)
    several = len(references) > 1

    def table(
        take: Callable[[Comparison], _Found | None],
        columns: Sequence[tuple[str, Callable[[_Found], str]]],
    ) -> Table:
        """A row per comparison of which there is something to take, named in front."""
        named = [(c, found) for c in comparisons if (found := take(c)) is not None]
        front = [
            ("scenario", [scenario_text(c.scenario) for c, _ in named]),
            (setting, [code(c.setting) for c, _ in named]),
            (factor, [code(c.second) for c, _ in named]),
            ("reference" if several else "", [code(c.first) for c, _ in named]),
        ]
        made = [(name, [text(found) for _, found in named]) for name, text in columns]
        return table_of([one for one in front if one[0]], made, last=True)

    def proportions(what: str) -> Sequence[tuple[str, Callable[[PairedProportions], str]]]:
        """How often it happened under both treatments."""
        return (
            ("pairs", lambda f: count(f.pairs)),
            (
                "with reference" if several else code(references[0]),
                lambda f: share(f.both + f.first_only, f.pairs),
            ),
            (f"this {factor}", lambda f: share(f.both + f.second_only, f.pairs)),
            ("one only", lambda f: f"{count(f.first_only)} / {count(f.second_only)}"),
            (
                f"difference (points) {_CONFIDENCE}",
                lambda f: difference(f.difference.scaled(100.0), 1),
            ),
            ("p", lambda f: p_value(f.p_value)),
            ("in words", lambda f: proportion_text(f, what)),
        )

    successes = table(lambda c: c.success, proportions("successes"))
    hit = any(c.collision and c.collision.neither < c.collision.pairs for c in comparisons)
    collisions = table(lambda c: c.collision, proportions("collisions")) if hit else None
    found = [
        ("Success in feasible worlds", successes),
        ("Trials with an avoidable collision", collisions),
    ]
    for quantity in dict.fromkeys(one for c in comparisons for one in c.values):
        made = table(partial(_value, quantity=quantity), _differences(quantity))
        if made.rows:
            found.append((f"{quantity.name.capitalize()}, where both succeeded", made))
    return found


def _value(comparison: Comparison, quantity: Quantity) -> PairedValues | None:
    return comparison.values.get(quantity)


def _differences(quantity: Quantity) -> Sequence[tuple[str, Callable[[PairedValues], str]]]:
    factor, digits = quantity.factor, quantity.digits + 1
    return (
        ("pairs", lambda f: count(f.pairs)),
        (
            f"mean difference ({quantity.unit}) {_CONFIDENCE}",
            lambda f: difference(f.mean.scaled(factor), digits),
        ),
        (
            f"median difference ({quantity.unit}) {_CONFIDENCE}",
            lambda f: difference(f.median.scaled(factor), digits),
        ),
        ("in words", lambda f: value_text(f, quantity)),
    )
