from __future__ import annotations

import numpy as np
import pytest

from cavalcade.campaign.draws import DataFolder
from cavalcade.campaign.draws.barn import BarnDraw
from cavalcade.errors import InputError

TEAMS = [{"shape": "line", "robots": 1}, {"shape": "triangle", "side": 1.0}]


@pytest.fixture
def draw():
    return BarnDraw.model_validate({"draw": "barn", "teams": TEAMS})


def test_every_world_with_every_team(draw, data):
    assert draw.limit(data) == 6
    names = [draw.draw_world(seed, data).scenario["name"] for seed in range(6)]
    assert names[:3] == ["barn-2-1", "barn-10-3", "barn-111-1"]
    assert len(set(names)) == 6


def test_from_below_to_beyond_the_open_side(draw, data):
    drawn = draw.draw_world(0, data)
    assert drawn.scenario["robots"][0]["start"] == pytest.approx([2.25, 3.0, np.pi / 2], abs=1e-3)
    assert drawn.scenario["task"]["goals"][0] == pytest.approx([2.25, 13.0, np.pi / 2], abs=1e-3)
    assert drawn.scenario["world"]["empty"]["size"] == pytest.approx([4.5, 14.6], abs=0.1)
    assert drawn.level == 1.0


def test_feasible_unless_closed(draw, data):
    assert [draw.draw_world(seed, data).feasible for seed in range(6)] == [True, True, False] * 2


def test_missing(draw, tmp_path):
    for data in (DataFolder(None), DataFolder(tmp_path)):
        assert "world_*.csv" in draw.missing(data)
        assert draw.limit(data) == 0
        with pytest.raises(InputError, match="CAVALCADE_DATA"):
            draw.draw_world(0, data)


def test_a_team_that_does_not_fit(data):
    wide = {"draw": "barn", "teams": [{"shape": "line", "spacing": 2.0, "robots": 3}]}
    with pytest.raises(InputError, match="line does not fit") as caught:
        BarnDraw.model_validate(wide).draw_world(0, data)
    assert caught.value.key == "start"
