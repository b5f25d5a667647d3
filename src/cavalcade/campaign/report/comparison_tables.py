"""The tables of paired comparisons."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cavalcade.campaign.report.blocks import Block, Heading, Table, Text, code
from cavalcade.campaign.report.comparisons import ALL, Comparison
from cavalcade.campaign.report.wording import (
    collision_words,
    count,
    difference,
    p_value,
    share,
    success_words,
    value_words,
)
from cavalcade.campaign.statistics import PairedProportions


def comparison_tables(comparisons: Sequence[Comparison], kind: str, setting: str) -> list[Block]:
    """Success, collisions and each quantity.

    Args:
        comparisons: At least one.
        kind: What is compared: `variant` or `disturbance`.
        setting: What the comparisons' setting is called; empty where there is only one.
    """
    blocks: list[Block] = [
        Heading("Success in feasible worlds", 3),
        _proportions(comparisons, kind, setting, lambda c: c.success, success_words),
    ]
    hit = [c.collision is not None and c.collision.neither < c.collision.pairs for c in comparisons]
    if any(hit):
        blocks += [
            Heading("Trials with an avoidable collision", 3),
            _proportions(comparisons, kind, setting, lambda c: c.collision, collision_words),
        ]
    else:
        blocks.append(Text("No trial of any pair had an avoidable collision."))
    for k, quantity in enumerate(comparisons[0].quantities):
        table = _values(comparisons, kind, setting, k)
        if table.rows:
            name = quantity.name.capitalize()
            blocks += [Heading(f"{name}, where both succeeded", 3), table]
    return blocks


def references(comparisons: Sequence[Comparison]) -> list[str]:
    """What is compared with, each once."""
    return list(dict.fromkeys(comparison.first for comparison in comparisons))


def _names(comparison: Comparison, setting: str, several: bool) -> tuple[str, ...]:
    scenario = ALL if comparison.scenario == ALL else code(comparison.scenario)
    return (
        scenario,
        *([code(comparison.setting)] if setting else []),
        code(comparison.second),
        *([code(comparison.first)] if several else []),
    )


def _head(setting: str, kind: str, several: bool) -> tuple[str, ...]:
    """Names of the columns; the reference has one where there are several."""
    return (
        "scenario",
        *([setting] if setting else []),
        kind,
        *(["reference"] if several else []),
    )


def _proportions(
    comparisons: Sequence[Comparison],
    kind: str,
    setting: str,
    take: Callable[[Comparison], PairedProportions | None],
    words: Callable[[PairedProportions], str],
) -> Table:
    firsts = references(comparisons)
    several = len(firsts) > 1
    head = _head(setting, kind, several)
    rows = []
    for comparison in comparisons:
        found = take(comparison)
        if found is None:
            continue
        rows.append(
            (
                *_names(comparison, setting, several),
                count(found.pairs),
                share(found.both + found.first_only, found.pairs),
                share(found.both + found.second_only, found.pairs),
                f"{count(found.first_only)} / {count(found.second_only)}",
                difference(found.difference.scaled(100.0), 1),
                p_value(found.p_value),
                words(found),
            )
        )
    columns = (
        *head,
        "pairs",
        "with reference" if several else code(firsts[0]),
        f"this {kind}",
        "one only",
        "difference (points) [95\N{NO-BREAK SPACE}%]",
        "p",
        "in words",
    )
    return Table(columns, tuple(rows), len(head), words=(len(columns) - 1,))


def _values(comparisons: Sequence[Comparison], kind: str, setting: str, index: int) -> Table:
    several = len(references(comparisons)) > 1
    head = _head(setting, kind, several)
    quantity = comparisons[0].quantities[index]
    digits = quantity.digits + 1
    rows = []
    for comparison in comparisons:
        found = comparison.values[index] if quantity in comparison.quantities else None
        if found is None:
            continue
        rows.append(
            (
                *_names(comparison, setting, several),
                count(found.pairs),
                difference(found.mean.scaled(quantity.factor), digits),
                difference(found.median.scaled(quantity.factor), digits),
                value_words(found, quantity),
            )
        )
    columns = (
        *head,
        "pairs",
        f"mean difference ({quantity.unit}) [95\N{NO-BREAK SPACE}%]",
        f"median difference ({quantity.unit}) [95\N{NO-BREAK SPACE}%]",
        "in words",
    )
    return Table(columns, tuple(rows), len(head), words=(len(columns) - 1,))
