"""Variants, and disturbances, compared on the same worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from cavalcade.campaign.report.trials import Order, Trial
from cavalcade.campaign.statistics import (
    PairedProportions,
    PairedValues,
    paired_proportions,
    paired_values,
)

ALL = "all scenarios"
"""Scenario of a comparison over the worlds of all groups; no group may be called so."""


@dataclass(frozen=True)
class Quantity:
    """Something measured that is compared.

    Attributes:
        name: For people.
        unit: Its unit there.
        factor: From the measured unit to that one.
        of: Takes it from a trial; None where it was not measured.
        digits: Decimals worth showing.
        more, less: What a positive and a negative difference is called.
    """

    name: str
    unit: str
    factor: float
    of: Callable[[Trial], float | None]
    digits: int
    more: str
    less: str


QUANTITIES = (
    Quantity("time", "s", 1.0, lambda trial: trial.time, 1, "slower", "faster"),
    Quantity(
        "formation error",
        "cm",
        100.0,
        lambda trial: trial.number("formation_error_m.mean"),
        1,
        "looser formation",
        "tighter formation",
    ),
    Quantity(
        "smallest gap", "cm", 100.0, lambda trial: trial.gap, 1, "keeps wider gaps", "comes closer"
    ),
)
"""Compared over the pairs of which both trials succeeded."""

PLAN_QUANTITIES = (
    QUANTITIES[0],
    Quantity("summed length", "m", 1.0, lambda trial: trial.length, 2, "longer", "shorter"),
    Quantity(
        "planning time",
        "s",
        1.0,
        lambda trial: trial.number("planning_time_s"),
        3,
        "longer to plan",
        "sooner planned",
    ),
    QUANTITIES[2],
)
"""The same where robots have goals of their own."""


@dataclass(frozen=True)
class Comparison:
    """Two treatments of the same worlds.

    Attributes:
        scenario: Group of worlds, or `ALL`.
        setting: What both have in common: a disturbance, or a variant.
        first, second: The names of what is compared; differences are second less first.
        success: In feasible worlds; None without pairs.
        collision: Trials with an avoidable collision, in all worlds; None without pairs.
        values: Per quantity; None with fewer than two pairs.
        quantities: `QUANTITIES` or `PLAN_QUANTITIES`.
    """

    scenario: str
    setting: str
    first: str
    second: str
    success: PairedProportions | None
    collision: PairedProportions | None
    values: tuple[PairedValues | None, ...]
    quantities: tuple[Quantity, ...] = QUANTITIES


def compare_variants(trials: Sequence[Trial], order: Order) -> list[Comparison]:
    """Each variant against its reference, per scenario and over all, under each disturbance.

    The reference is the first variant unless the suite names another.
    """
    return [
        comparison
        for disturbance in order.disturbances
        for comparison in _compare(
            [trial for trial in trials if trial.disturbance == disturbance],
            lambda trial: trial.variant,
            order.variants,
            order.scenarios,
            disturbance,
            order.references,
        )
    ]


def compare_disturbances(trials: Sequence[Trial], order: Order) -> list[Comparison]:
    """Each disturbance against the first, per scenario and over all, for each variant."""
    return [
        comparison
        for variant in order.variants
        for comparison in _compare(
            [trial for trial in trials if trial.variant == variant],
            lambda trial: trial.disturbance,
            order.disturbances,
            order.scenarios,
            variant,
            {},
        )
    ]


def _compare(
    trials: Sequence[Trial],
    treatment: Callable[[Trial], str],
    names: Sequence[str],
    scenarios: Sequence[str],
    setting: str,
    references: Mapping[str, str],
) -> list[Comparison]:
    found = []
    groups = (*scenarios, ALL) if len(scenarios) > 1 else tuple(scenarios)
    for scenario in groups:
        inside = [trial for trial in trials if scenario in (ALL, trial.scenario)]
        worlds = {
            name: {trial.world: trial for trial in inside if treatment(trial) == name}
            for name in names
        }
        for name in names:
            reference = references.get(name, names[0])
            if reference == name:
                continue
            first, second = worlds.get(reference, {}), worlds[name]
            pairs = [(first[world], second[world]) for world in first if world in second]
            if pairs:
                found.append(_comparison(scenario, setting, reference, name, pairs))
    return found


def _comparison(
    scenario: str, setting: str, first: str, second: str, pairs: Sequence[tuple[Trial, Trial]]
) -> Comparison:
    feasible = [pair for pair in pairs if pair[0].feasible and pair[1].feasible]
    both = [pair for pair in pairs if pair[0].success and pair[1].success]
    quantities = PLAN_QUANTITIES if pairs[0][0].planned else QUANTITIES
    return Comparison(
        scenario,
        setting,
        first,
        second,
        paired_proportions([a.success for a, _ in feasible], [b.success for _, b in feasible]),
        paired_proportions(
            [a.avoidable > 0 for a, _ in pairs], [b.avoidable > 0 for _, b in pairs]
        ),
        tuple(
            paired_values([quantity.of(a) for a, _ in both], [quantity.of(b) for _, b in both])
            for quantity in quantities
        ),
        quantities,
    )
