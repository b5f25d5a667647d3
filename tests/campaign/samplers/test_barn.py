from __future__ import annotations

import numpy as np
import pytest

from cavalcade.campaign.samplers import DataFolder
from cavalcade.campaign.samplers.barn import BarnSampler
from cavalcade.errors import InputError

TEAMS = [{"shape": "line", "robots": 1}, {"shape": "triangle", "side": 1.0}]


@pytest.fixture
def sampler():
    return BarnSampler.model_validate({"sampler": "barn", "teams": TEAMS})


def test_every_world_with_every_team(sampler, data):
    assert sampler.limit(data) == 6
    names = [sampler.sample(seed, data).scenario["name"] for seed in range(6)]
    assert names[:3] == ["barn-2-1", "barn-10-3", "barn-111-1"]
    assert len(set(names)) == 6


def test_from_below_to_beyond_the_open_side(sampler, data):
    instance = sampler.sample(0, data)
    assert instance.scenario["robots"][0]["start"] == pytest.approx(
        [2.25, 3.0, np.pi / 2], abs=1e-3
    )
    assert instance.scenario["task"]["goals"][0] == pytest.approx([2.25, 13.0, np.pi / 2], abs=1e-3)
    assert instance.scenario["world"]["empty"]["size"] == pytest.approx([4.5, 14.6], abs=0.1)
    assert instance.level == 1.0


def test_feasible_unless_closed(sampler, data):
    assert [sampler.sample(seed, data).feasible for seed in range(6)] == [True, True, False] * 2


def test_missing(sampler, tmp_path):
    for data in (DataFolder(None), DataFolder(tmp_path)):
        assert "world_*.csv" in sampler.missing(data)
        assert sampler.limit(data) == 0
        with pytest.raises(InputError, match="CAVALCADE_DATA"):
            sampler.sample(0, data)


def test_a_team_that_does_not_fit(data):
    wide = {"sampler": "barn", "teams": [{"shape": "line", "spacing": 2.0, "robots": 3}]}
    with pytest.raises(InputError, match="line does not fit") as caught:
        BarnSampler.model_validate(wide).sample(0, data)
    assert caught.value.key == "start"
