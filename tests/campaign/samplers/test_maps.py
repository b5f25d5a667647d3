from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from cavalcade.campaign.samplers import DataFolder
from cavalcade.campaign.samplers.maps import MapsSampler
from cavalcade.errors import InputError
from cavalcade.world import OccupancyMap, save_map

SQUARE, PAIR = {"shape": "square", "side": 1.0}, {"shape": "column", "robots": 2}


def maps(**said):
    return MapsSampler.model_validate(
        {"sampler": "maps", "maps": [{"file": "halls.yaml"}], "teams": [SQUARE], **said}
    )


def test_ways_are_as_long_as_asked(data):
    sampler = maps(way=[5, 9])
    for seed in range(8):
        instance = sampler.sample(seed, data)
        assert instance.feasible
        assert 5.0 <= instance.level <= 9.0
        start = np.mean([robot["start"][:2] for robot in instance.scenario["robots"]], axis=0)
        assert (
            np.hypot(*(instance.scenario["task"]["goals"][0][:2] - start)) <= instance.level + 0.3
        )


def test_the_file_is_named_in_full(data):
    file = maps().sample(0, data).scenario["world"]["map"]
    assert Path(file).is_absolute()
    assert file == str(data.path / "halls.yaml")


def test_maps_by_weight_with_their_own_teams(data):
    save_map(OccupancyMap.empty((5.0, 5.0)), data.path / "small.yaml")
    small = {"file": "small.yaml", "weight": 3, "teams": [PAIR], "way": [1, 3]}
    sampler = maps(maps=[{"file": "halls.yaml"}, small])
    found = {"halls": 0, "small": 0}
    for seed in range(24):
        instance = sampler.sample(seed, data)
        name = Path(instance.scenario["world"]["map"]).stem
        assert len(instance.scenario["robots"]) == (2 if name == "small" else 4)
        found[name] += 1
    assert found["small"] > found["halls"] > 0


def test_missing(data, tmp_path):
    sampler = maps(maps=[{"file": "halls.yaml"}, {"file": "gone/map.yaml"}])
    assert sampler.missing(data).startswith("gone/map.yaml: not in")
    assert maps().missing(data) is None
    assert "no folder of data" in maps().missing(DataFolder(None))
    with pytest.raises(InputError, match=r"halls\.yaml"):
        maps().sample(0, DataFolder(tmp_path))


def test_a_map_without_such_a_way(data):
    with pytest.raises(InputError, match="no way for a square is found") as caught:
        maps(way=[30, 40]).sample(0, data)
    assert caught.value.key == "way"
    full = OccupancyMap(np.full((40, 40), 100, dtype=np.int8), 0.05)
    save_map(full, data.path / "full.yaml")
    with pytest.raises(InputError, match="no way"):
        maps(maps=[{"file": "full.yaml"}]).sample(0, data)


def test_every_map_has_a_team():
    with pytest.raises(ValidationError, match="no team"):
        maps(teams=[])
