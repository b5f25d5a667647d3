"""In these worlds with events a robot fled into a dead end, or against one that stood there."""

from __future__ import annotations

import pytest

from cavalcade.campaign.carrying import carry_out
from cavalcade.campaign.plan import make_plan


@pytest.mark.parametrize("seed", [10066, 10073])
def test_nothing_is_touched(seed: int) -> None:
    plan = make_plan("events", seeds=1, seed=seed)
    line = carry_out(plan.trial(f"events.{seed}.cavalcade"))
    assert (line["outcome"], line["success"], line["contacts"]) == ("arrived", True, 0)
