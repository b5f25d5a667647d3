"""Tables of the report with a row per paired comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from cavalcade.campaign.report.cells import ALL
from cavalcade.campaign.report.comparisons import Comparison, Factor, Quantity, references_of
from cavalcade.campaign.report.tables import Table, table_of
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


def proportion_table(
    comparisons: Sequence[Comparison],
    factor: Factor,
    setting: str,
    take: Callable[[Comparison], PairedProportions | None],
    what: str,
) -> Table:
    """How often `what`, which `take` gives, happened under two treatments.

    Args:
        comparisons: At least one.
        factor: What is compared.
        setting: What the comparisons' setting is called; empty where there is only one.
        take: What is compared of a comparison.
        what: Its name in the plural.
    """
    references = references_of(comparisons)
    columns: Sequence[tuple[str, Callable[[PairedProportions], str]]] = (
        ("pairs", lambda f: count(f.pairs)),
        (
            "with reference" if len(references) > 1 else code(references[0]),
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
    return _comparison_table(comparisons, factor, setting, take, columns)


def value_table(
    comparisons: Sequence[Comparison], factor: Factor, setting: str, quantity: Quantity
) -> Table:
    """Differences of a quantity; arguments as of `proportion_table`."""
    factor_, digits = quantity.factor, quantity.digits + 1
    columns: Sequence[tuple[str, Callable[[PairedValues], str]]] = (
        ("pairs", lambda f: count(f.pairs)),
        (
            f"mean difference ({quantity.unit}) {_CONFIDENCE}",
            lambda f: difference(f.mean.scaled(factor_), digits),
        ),
        (
            f"median difference ({quantity.unit}) {_CONFIDENCE}",
            lambda f: difference(f.median.scaled(factor_), digits),
        ),
        ("in words", lambda f: value_text(f, quantity)),
    )
    return _comparison_table(
        comparisons, factor, setting, lambda c: c.values.get(quantity), columns
    )


def _comparison_table(
    comparisons: Sequence[Comparison],
    factor: Factor,
    setting: str,
    take: Callable[[Comparison], _Found | None],
    columns: Sequence[tuple[str, Callable[[_Found], str]]],
) -> Table:
    """A row per comparison of which there is something to take, named in front."""
    several = len(references_of(comparisons)) > 1
    named = [(c, found) for c in comparisons if (found := take(c)) is not None]
    front = [
        ("scenario", [ALL if c.scenario == ALL else code(c.scenario) for c, _ in named]),
        (setting, [code(c.setting) for c, _ in named]),
        (factor, [code(c.second) for c, _ in named]),
        ("reference" if several else "", [code(c.first) for c, _ in named]),
    ]
    shown = [(name, texts) for name, texts in front if name]
    made = [(name, [text(found) for _, found in named]) for name, text in columns]
    head, texts = zip(*shown, *made, strict=True)
    return table_of(head, zip(*texts, strict=True), len(shown), last=True)


def comparison_tables(
    comparisons: Sequence[Comparison], factor: Factor, setting: str
) -> list[tuple[str, Table | None]]:
    """Title and table of successes, collisions and each quantity; arguments as before.

    The table of collisions is None where no trial of any pair had one.
    """
    arguments = (comparisons, factor, setting)
    hit = any(c.collision and c.collision.neither < c.collision.pairs for c in comparisons)
    successes = proportion_table(*arguments, lambda c: c.success, "successes")
    collisions = proportion_table(*arguments, lambda c: c.collision, "collisions") if hit else None
    found: list[tuple[str, Table | None]] = [
        ("Success in feasible worlds", successes),
        ("Trials with an avoidable collision", collisions),
    ]
    for quantity in dict.fromkeys(one for c in comparisons for one in c.values):
        table = value_table(*arguments, quantity)
        if table.rows:
            found.append((f"{quantity.name.capitalize()}, where both succeeded", table))
    return found
