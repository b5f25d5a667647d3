"""In these worlds with events a robot fled into a dead end, or against one that stood there.

On the ways of that time, for which the price of room has no bound. With the bound of today 10066
has an avoidable contact again, as `docs/results/formations.md` says: a box sets out right beside a
robot there.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from cavalcade.campaign.definition import define_campaign
from cavalcade.campaign.trial_runner import run_trial


@pytest.mark.parametrize("seed", [10066, 10073])
def test_nothing_is_touched(seed: int) -> None:
    definition = define_campaign("events", seeds=1, seed=seed)
    trial = definition.trial(f"events.{seed}.cavalcade")
    line = run_trial(replace(trial, overrides=("planner.max_detour=.inf",)))
    assert (line["outcome"], line["success"], line["contacts"]) == ("arrived", True, 0)
