from __future__ import annotations

import base64
import json
import re

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.drawing.replay.data import replay_data
from cavalcade.drawing.replay.page import replay_page
from cavalcade.drawing.replay.trajectories import TOLERANCE, keyframes

BOXES = [
    {"box": {"center": [2.0, 5.0], "size": [1.0, 0.5], "yaw": 0.3}},
    {"circle": {"center": [6.5, 1.0], "radius": 0.4}},
    {"polygon": {"points": [[6, 4], [7, 4], [7, 5], [6.5, 4.3]]}},
]


@pytest.fixture
def data_of(make_scenario, straight_team):
    def make(leaping=(), **options):
        scenario = make_scenario(**options)
        world = cv.build_world(scenario)
        made = cv.plan(scenario, coordinator=straight_team(leaping=leaping))
        return made, replay_data(scenario, world, plan=made, summary=made.summary)

    return make


def test_the_page_holds_all_and_loads_nothing(data_of):
    _, data = data_of(world={"empty": {"size": [8, 6]}, "obstacles": BOXES})
    page = replay_page(data)
    assert len(page.encode()) < 400_000
    assert not re.search(r"(src|href)\s*=|@import|https?://|fetch\(|XMLHttpRequest", page)
    assert "default-src 'none'" in page
    text = re.search(r'<script id="scene" type="application/json">(.*?)</script>', page, re.S)
    assert json.loads(text.group(1)) == json.loads(json.dumps(data))
    assert "%" not in re.sub(r"<style>.*?</style>|<script.*?</script>", "", page, flags=re.S)


def test_a_name_cannot_break_out_of_the_page(data_of):
    _, data = data_of()
    page = replay_page({**data, "name": "</script><b>%DATA%"})
    assert page.count("</script>") == replay_page(data).count("</script>")
    assert "<b>%DATA%" not in page


def test_paths_come_back_within_the_tolerance(data_of):
    made, data = data_of(leaping=(0,))
    for said, path in zip(data["robots"], made.trajectories, strict=True):
        t, x, y, z, a = (np.cumsum(said["path"][key]) / 1000 for key in "txyza")
        kept = [np.interp(path.time, t, values) for values in (x, y, z)]
        off = np.linalg.norm(np.column_stack(kept) - path.position, axis=1)
        assert off.max() < TOLERANCE + 0.003
        assert np.abs(np.interp(path.time, t, a) - path.yaw).max() < 0.02
        assert len(t) < 0.5 * len(path.time)


def test_footholds_come_back(data_of):
    made, data = data_of()
    for said, feet in zip(data["robots"], made.footholds, strict=True):
        rows = feet[np.lexsort((feet[:, 0], feet[:, 2]))]
        packed = said["feet"]
        assert sum(packed["count"]) == len(feet)
        down = np.frombuffer(base64.b64decode(packed["down"]), "<u2") * data["tick"]
        place = np.frombuffer(base64.b64decode(packed["place"]), "<i2").reshape(-1, 3) / 200
        np.testing.assert_allclose(down, rows[:, 0], atol=data["tick"])
        np.testing.assert_allclose(place + packed["base"], rows[:, 3:], atol=0.003)


def test_phases_are_told(data_of):
    _, data = data_of(leaping=(1,))
    walking, leaping = (robot["path"] for robot in data["robots"])
    assert {kind for kind, *_ in walking["spans"]} == {1}
    assert 2 in {kind for kind, *_ in leaping["spans"]}
    assert set(leaping["p"]) == {0, 1, 2, 3}


def test_terrain_comes_back(make_scenario, straight_team):
    scenario = make_scenario(
        robots=[((1.0, 2.0, 0.0), (8.0, 2.0, 0.0))],
        world={"generate": {"kind": "step", "size": [9, 4], "seed": 0}},
    )
    world = cv.build_world(scenario)
    made = cv.plan(scenario, coordinator=straight_team(waits=(0.0,)))
    said = replay_data(scenario, world, plan=made, summary=made.summary)["terrain"]
    whole = np.frombuffer(base64.b64decode(said["heights"]), "<u2")
    height = said["low"] + said["span"] * whole.reshape(len(said["y"]), len(said["x"])) / 65_000
    np.testing.assert_allclose(height, world.terrain.height, atol=1e-4)
    blocked = np.unpackbits(np.frombuffer(base64.b64decode(said["blocked"]), np.uint8))
    expected = (world.terrain.traversability < 0.3).ravel()
    np.testing.assert_array_equal(blocked[: expected.size], expected)


def test_an_unsolved_problem_has_a_replay_too(make_scenario, no_plan, tmp_path):
    cv.plan(make_scenario(), tmp_path / "p", coordinator=no_plan)
    page = (tmp_path / "p" / "replay.html").read_text()
    assert "shut off" in page


def test_key_frames_keep_ends_and_changes_of_phase(data_of):
    made, _ = data_of(leaping=(0,))
    path = made.trajectories[0]
    kept = keyframes(path)
    assert kept[0] == 0
    assert kept[-1] == len(path.time) - 1
    changes = np.flatnonzero(np.diff(path.phase)) + 1
    assert set(changes) <= set(kept.tolist())
