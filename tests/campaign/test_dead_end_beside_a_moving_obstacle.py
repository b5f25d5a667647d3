"""In these worlds with events a robot fled into a dead end, or against one that stood there."""

from __future__ import annotations

import pytest

from cavalcade.campaign.definition import define_campaign
from cavalcade.campaign.trial_runner import run_trial


@pytest.mark.parametrize("seed", [10066, 10073])
def test_nothing_is_touched(seed: int) -> None:
    definition = define_campaign("events", seeds=1, seed=seed)
    line = run_trial(definition.trial(f"events.{seed}.cavalcade"))
    assert (line["outcome"], line["success"], line["contacts"]) == ("arrived", True, 0)
