"""Variants, and disturbances, compared on the same worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from cavalcade.campaign.report.cells import ALL
from cavalcade.campaign.report.trials import TrialTable
from cavalcade.campaign.statistics import (
    PairedProportions,
    PairedValues,
    paired_proportions,
    paired_values,
)

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
_GAP = Quantity("smallest gap", "cm", 100.0, "gap", 1, "keeps wider gaps", "comes closer")

QUANTITIES = (
    _TIME,
    Quantity(
        "formation error",
        "cm",
        100.0,
        "formation_error",
        1,
        "looser formation",
        "tighter formation",
    ),
    _GAP,
)
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
