"""The kernels that trials take, compiled or loaded before the first of them is timed."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterable, Sequence

from cavalcade.campaign.samplers import unplanned
from cavalcade.campaign.trial import Trial
from cavalcade.jobs.reporter import Reporter
from cavalcade.jobs.warming import Needs, needs_of, warm
from cavalcade.scenario import Scenario


def needs_of_all(trials: Iterable[Trial]) -> tuple[Needs, ...]:
    """What the trials need, by the first world of each group, variant and disturbance."""
    found: dict[tuple[str, str, str], Needs] = {}
    for trial in trials:
        key = (trial.group, trial.variant, trial.disturbance)
        if key in found:
            continue
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                instance = unplanned(trial.sampler).sample(trial.seed, trial.data)
                found[key] = needs_of_trial(trial, trial.scenario(instance))
        except Exception:  # whatever it is, the trial will say so
            continue
    return tuple(dict.fromkeys(found.values()))


def needs_of_trial(trial: Trial, scenario: Scenario) -> Needs:
    """What one trial needs; plans are made and judged, not carried out."""
    planned = trial.sampler.individual_goals
    return needs_of(scenario, None if planned else scenario.execution.backend)


def warm_all(wanted: Sequence[Needs], reporter: Reporter | None = None) -> None:
    """Compile or load what all of these need; whatever is wrong shows in the trials."""
    for needs in wanted:
        with contextlib.suppress(Exception):
            warm([needs], reporter or Reporter(quiet=True))
