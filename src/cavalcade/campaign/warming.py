"""The kernels of planners for individual goals, in a process before its trials are timed.

Compiled ones are read from the disk when they are first used, which takes longer than many plans.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

from cavalcade.campaign.samplers import unplanned
from cavalcade.campaign.trial import Trial
from cavalcade.errors import InputError

Warmth = tuple[str, bool]
"""A variant of `METHOD_VARIANTS`, and whether the ground is uneven."""


def warmth_of(trials: Iterable[Trial]) -> tuple[Warmth, ...]:
    """What the trials need, by the first world of each group that has any."""
    found: dict[tuple[str, str], Warmth] = {}
    for trial in trials:
        key = (trial.group, trial.variant)
        if trial.sampler.individual_goals and key not in found:
            found[key] = (trial.variant, _uneven(trial))
    return tuple(dict.fromkeys(found.values()))


def _uneven(trial: Trial) -> bool:
    try:
        instance = unplanned(trial.sampler).sample(trial.seed, trial.data)
        return trial.scenario(instance).world.has_heights
    except InputError:  # the trial will say so
        return False


def warm_all(wanted: Sequence[Warmth]) -> None:
    """Compile or read what all of these need; whatever is wrong shows in the trials."""
    for variant, uneven in wanted:
        try:
            warm(variant, uneven)
        except Exception:
            continue


@cache
def warm(variant: str, uneven: bool) -> None:
    """Plan a small problem once in this process, and have it judged."""
    from cavalcade.campaign.judging import judged_plan
    from cavalcade.campaign.methods import planner_settings
    from cavalcade.jobs import plan
    from cavalcade.scenario import parse_scenario

    world: dict[str, Any] = {"empty": {"size": [6.0, 4.0]}}
    if uneven:
        world = {"generate": {"kind": "step", "size": [6.0, 4.0], "height": 0.1}}
    turned = 3.14159
    said = {
        "version": 1,
        "name": "warming",
        "world": world,
        "robots": [
            {"model": "spirit", "start": [1.0, 2.0, 0.0], "goal": [5.0, 2.0, 0.0]},
            {"model": "spirit", "start": [5.0, 2.0, turned], "goal": [1.0, 2.0, turned]},
        ],
        "task": {"goals": "individual"},
        "planner": {**planner_settings(variant, True), "budget": {"iterations": 20_000}},
    }
    scenario = parse_scenario(said)
    judged_plan(plan(scenario))
