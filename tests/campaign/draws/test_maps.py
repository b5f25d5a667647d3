from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from cavalcade.campaign.draws import DataFolder
from cavalcade.campaign.draws.maps import MapsDraw
from cavalcade.errors import InputError
from cavalcade.world import OccupancyMap, save_map

SQUARE, PAIR = {"shape": "square", "side": 1.0}, {"shape": "column", "robots": 2}


def maps(**said):
    return MapsDraw.model_validate(
        {"draw": "maps", "maps": [{"file": "halls.yaml"}], "teams": [SQUARE], **said}
    )


def test_ways_are_as_long_as_asked(data):
    draw = maps(way=[5, 9])
    for seed in range(8):
        drawn = draw.draw_world(seed, data)
        assert drawn.feasible
        assert 5.0 <= drawn.level <= 9.0
        start = np.mean([robot["start"][:2] for robot in drawn.scenario["robots"]], axis=0)
        assert np.hypot(*(drawn.scenario["task"]["goals"][0][:2] - start)) <= drawn.level + 0.3


def test_the_file_is_named_in_full(data):
    file = maps().draw_world(0, data).scenario["world"]["map"]
    assert Path(file).is_absolute()
    assert file == str(data.path / "halls.yaml")


def test_maps_by_weight_with_their_own_teams(data):
    save_map(OccupancyMap.empty((5.0, 5.0)), data.path / "small.yaml")
    small = {"file": "small.yaml", "weight": 3, "teams": [PAIR], "way": [1, 3]}
    draw = maps(maps=[{"file": "halls.yaml"}, small])
    found = {"halls": 0, "small": 0}
    for seed in range(24):
        drawn = draw.draw_world(seed, data)
        name = Path(drawn.scenario["world"]["map"]).stem
        assert len(drawn.scenario["robots"]) == (2 if name == "small" else 4)
        found[name] += 1
    assert found["small"] > found["halls"] > 0


def test_missing(data, tmp_path):
    draw = maps(maps=[{"file": "halls.yaml"}, {"file": "gone/map.yaml"}])
    assert draw.missing(data).startswith("gone/map.yaml: not in")
    assert maps().missing(data) is None
    assert "no folder of data" in maps().missing(DataFolder(None))
    with pytest.raises(InputError, match=r"halls\.yaml"):
        maps().draw_world(0, DataFolder(tmp_path))


def test_a_map_without_such_a_way(data):
    with pytest.raises(InputError, match="no way for a square is found") as caught:
        maps(way=[30, 40]).draw_world(0, data)
    assert caught.value.key == "way"
    full = OccupancyMap(np.full((40, 40), 100, dtype=np.int8), 0.05)
    save_map(full, data.path / "full.yaml")
    with pytest.raises(InputError, match="no way"):
        maps(maps=[{"file": "full.yaml"}]).draw_world(0, data)


def test_every_map_has_a_team():
    with pytest.raises(ValidationError, match="no team"):
        maps(teams=[])
