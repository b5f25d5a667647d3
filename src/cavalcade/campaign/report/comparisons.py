"""Variants, and disturbances, compared on the same worlds, with a row per comparison."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

from cavalcade.campaign.report.cells import ALL
from cavalcade.campaign.report.tables import Table, scenario_text, table_of
from cavalcade.campaign.report.trials import TrialTable
from cavalcade.campaign.report.wording import (
    NO_DIFFERENCE,
    TOO_FEW,
    code,
    count,
    difference,
    p_value,
    share,
)
from cavalcade.campaign.statistics import (
    PairedProportions,
    PairedValues,
    paired_proportions,
    paired_values,
)

_Found = TypeVar("_Found", PairedProportions, PairedValues)

_CONFIDENCE = "[95\N{NO-BREAK SPACE}%]"

Factor = Literal["variant", "disturbance"]
"""What is compared; the other one is the setting that both trials of a pair have in common."""


@dataclass(frozen=True)
class Quantity:
    """Something measured that is compared.

    Attributes:
        name: For people.
        unit: Its unit there.
        factor: From the measured unit to that one.
        column: Of the table `trials`.
        digits: Decimals worth showing.
        more, less: What a positive and a negative difference is called.
    """

    name: str
    unit: str
    factor: float
    column: str
    digits: int
    more: str
    less: str


_TIME = Quantity("time", "s", 1.0, "time", 1, "slower", "faster")
_ERROR = Quantity(
    "formation error", "cm", 100.0, "formation_error", 1, "looser formation", "tighter formation"
)
_GAP = Quantity("smallest gap", "cm", 100.0, "gap", 1, "keeps wider gaps", "comes closer")

QUANTITIES = (_TIME, _ERROR, _GAP)
"""Compared over the pairs of which both trials succeeded."""

PLAN_QUANTITIES = (
    _TIME,
    Quantity("summed length", "m", 1.0, "length", 2, "longer", "shorter"),
    Quantity("planning time", "s", 1.0, "planning_time", 3, "longer to plan", "sooner planned"),
    _GAP,
)
"""The same where robots have individual goals."""

_COLUMNS = tuple(dict.fromkeys(one.column for one in (*QUANTITIES, *PLAN_QUANTITIES)))


@dataclass(frozen=True)
class Comparison:
    """Two treatments of the same worlds.

    Attributes:
        scenario: Group of worlds, or `ALL`.
        setting: What both have in common: a disturbance, or a variant.
        first, second: The names of what is compared; differences are second less first.
        success: In feasible worlds; None without pairs.
        collision: Trials with an avoidable collision, in all worlds; None without pairs.
        values: Of each of `QUANTITIES` or `PLAN_QUANTITIES`; None with fewer than two pairs.
    """

    scenario: str
    setting: str
    first: str
    second: str
    success: PairedProportions | None
    collision: PairedProportions | None
    values: Mapping[Quantity, PairedValues | None]


def compare(table: TrialTable, factor: Factor) -> list[Comparison]:
    """Each variant, or disturbance, against its reference on the same worlds.

    That is done per scenario and over all, under each setting of the other factor. The reference
    is the first one unless the suite names another for a variant. Problems that are infeasible
    by construction do not count.
    """
    order = table.order
    names, settings = order.variants, order.disturbances
    references: Mapping[str, str] = order.references
    if factor == "disturbance":
        names, settings, references = settings, names, {}
    scenarios = order.scenarios
    groups = (*scenarios, ALL) if len(scenarios) > 1 else scenarios
    found = []
    for setting in settings:
        pairs = {
            (reference, name): _pairs(table, factor, setting, reference, name)
            for name in names
            if (reference := references.get(name, names[0])) != name
        }
        for scenario in groups:
            for (reference, name), every in pairs.items():
                inside = [pair for pair in every if scenario in (ALL, pair["scenario"])]
                if inside:
                    found.append(_comparison(scenario, setting, reference, name, inside))
    return found


_Pair = dict[str, Any]


def _pairs(table: TrialTable, factor: Factor, setting: str, first: str, second: str) -> list[_Pair]:
    """Two trials in the same world each; what is known of both stands in pairs."""
    other = "disturbance" if factor == "variant" else "variant"
    both = ("success", "feasible", "avoidable", *_COLUMNS)
    columns = ", ".join(f'["a"."{name}", "b"."{name}"]' for name in both)
    query = f"""
        SELECT a.scenario, a.planned, {columns}
        FROM trials a JOIN trials b USING (scenario, seed, {other})
        WHERE a.{factor} = ? AND b.{factor} = ? AND {other} = ?
            AND NOT a.unsolvable AND NOT b.unsolvable
        ORDER BY a.place
    """
    names = ("scenario", "planned", *both)
    return [
        dict(zip(names, row, strict=True)) for row in table.rows(query, (first, second, setting))
    ]


def _comparison(
    scenario: str, setting: str, first: str, second: str, pairs: Sequence[_Pair]
) -> Comparison:
    feasible = [pair["success"] for pair in pairs if all(pair["feasible"])]
    hits = [[count > 0 for count in pair["avoidable"]] for pair in pairs]
    succeeded = [pair for pair in pairs if all(pair["success"])]
    quantities = PLAN_QUANTITIES if pairs[0]["planned"] else QUANTITIES
    return Comparison(
        scenario,
        setting,
        first,
        second,
        paired_proportions([a for a, _ in feasible], [b for _, b in feasible]),
        paired_proportions([a for a, _ in hits], [b for _, b in hits]),
        {
            quantity: paired_values(
                [pair[quantity.column][0] for pair in succeeded],
                [pair[quantity.column][1] for pair in succeeded],
            )
            for quantity in quantities
        },
    )


def references_of(comparisons: Sequence[Comparison]) -> list[str]:
    """What is compared with, each once."""
    return list(dict.fromkeys(comparison.first for comparison in comparisons))


def comparison_tables(
    comparisons: Sequence[Comparison], factor: Factor, setting: str
) -> list[tuple[str, Table | None]]:
    """Title and table of successes, collisions and each quantity, of at least one comparison.

    The table of collisions is None where no trial of any pair had one. `setting` is what the
    comparisons' setting is called; empty where there is only one.
    """
    references = references_of(comparisons)
    several = len(references) > 1

    def table(
        results: Sequence[_Found | None],
        columns: Sequence[tuple[str, Callable[[_Found], str]]],
    ) -> Table:
        """A row per comparison that has a result, named in front."""
        named = [(c, one) for c, one in zip(comparisons, results, strict=True) if one is not None]
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

    successes = table([c.success for c in comparisons], proportions("successes"))
    hit = any(c.collision and c.collision.neither < c.collision.pairs for c in comparisons)
    collisions = None
    if hit:
        collisions = table([c.collision for c in comparisons], proportions("collisions"))
    found = [
        ("Success in feasible worlds", successes),
        ("Trials with an avoidable collision", collisions),
    ]
    for quantity in dict.fromkeys(one for c in comparisons for one in c.values):
        made = table([c.values.get(quantity) for c in comparisons], _differences(quantity))
        if made.rows:
            found.append((f"{quantity.name.capitalize()}, where both succeeded", made))
    return found


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


def proportion_text(found: PairedProportions, what: str) -> str:
    """What the comparison of how many `what` there were comes to."""
    if found.difference.includes_zero:
        return NO_DIFFERENCE
    points = abs(100.0 * found.difference.value)
    return f"{'more' if found.difference.value > 0 else 'fewer'} {what} by {points:.1f} points"


def value_text(found: PairedValues, quantity: Quantity) -> str:
    """What the comparison of a quantity comes to."""
    if math.isinf(found.mean.high):
        return TOO_FEW
    if found.mean.includes_zero:
        return NO_DIFFERENCE
    amount = abs(found.mean.value) * quantity.factor
    word = quantity.more if found.mean.value > 0 else quantity.less
    return f"{word} by {amount:.{quantity.digits}f} {quantity.unit}"
