"""How far robots that are set down at random keep from the border."""

from __future__ import annotations

import math

import pytest

from cavalcade.campaign.samplers import DataFolder
from cavalcade.campaign.samplers.scattered import TerrainSampler
from cavalcade.campaign.samplers.two_robots import PairsSampler
from cavalcade.robots import MODELS

GO1 = MODELS["go1"]
NOTHING = DataFolder(None)


@pytest.mark.parametrize("border", [0.01, 0.3])
@pytest.mark.parametrize("kind", ["pairs", "terrain"])
def test_bodies_keep_from_the_border_at_any_yaw(kind: str, border: float) -> None:
    sampler = (
        PairsSampler(sampler="pairs", size=(3.0, 3.0), models=("go1",), border=border)
        if kind == "pairs"
        else TerrainSampler(
            sampler="terrain",
            kind="flat",
            size=(9.0, 3.0),
            robots=2,
            models=("go1",),
            border=border,
        )
    )
    size = (3.0, 3.0) if kind == "pairs" else (9.0, 3.0)
    least = math.inf
    for seed in range(30):
        for robot in sampler.sample(seed, NOTHING).scenario["robots"]:
            for x, y, _ in (robot["start"], robot["goal"]):
                least = min(least, x, y, size[0] - x, size[1] - y)
    reach = math.hypot(GO1.length, GO1.width) / 2.0
    assert reach + border - 1e-4 <= least <= reach + border + 0.1
