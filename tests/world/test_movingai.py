from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cavalcade.errors import MapError
from cavalcade.world import load_movingai

SMALL = "type octile\nheight 2\nwidth 7\nmap\n.GS@OTW\n.......\n"


def test_letters_and_the_way_up(tmp_path):
    path = tmp_path / "small.map"
    for text in (SMALL, SMALL.replace("\n", "\r\n"), SMALL.rstrip("\n")):
        path.write_bytes(text.encode())
        occupancy = load_movingai(path, 0.5)
        assert occupancy.grid.tolist() == [[0] * 7, [0, 0, 0, 100, 100, 100, 100]]
        assert occupancy.size == (3.5, 1.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a MovingAI map"),
        (SMALL.replace("height 2", "height -2"), "expected a MovingAI map"),
        (SMALL.replace("height 2", "height 3"), "2 of 3 lines"),
        (SMALL.replace("height 2", "height 0"), "no ground"),
        (SMALL.replace("height 2", "height 99999999"), "64 million"),
        (SMALL.replace("GS", "G"), "map line 1: 6 cells instead of 7"),
        (SMALL.replace("GS", "Gx"), "map line 1: unknown letter 'x'"),
    ],
)
def test_bad_files(tmp_path, text, message):
    path = tmp_path / "bad.map"
    path.write_text(text)
    with pytest.raises(MapError, match=message) as caught:
        load_movingai(path, 0.5)
    assert caught.value.file == str(path)


def test_a_bad_resolution(tmp_path):
    (tmp_path / "small.map").write_text(SMALL)
    with pytest.raises(MapError, match="resolution"):
        load_movingai(tmp_path / "small.map", 0.0)


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, len(SMALL) - 1), st.binary(max_size=4))
def test_no_damage_leads_to_another_error(tmp_path, at, insert):
    path = tmp_path / "bad.map"
    path.write_bytes(SMALL.encode()[:at] + insert + SMALL.encode()[at + 1 :])
    message = ""
    try:
        load_movingai(path, 0.5)
    except MapError as error:
        message = str(error)
    assert "\n" not in message


@pytest.mark.parametrize(
    ("name", "shape", "blocked"),
    [
        ("random-64-64-10", (64, 64), 409),
        ("room-32-32-4", (32, 32), 342),
        ("warehouse-10-20-10-2-1", (63, 161), 4444),
    ],
)
def test_real_maps(shared_data, name, shape, blocked):
    occupancy = load_movingai(shared_data(f"movingai/{name}.map"), 1.0)
    assert occupancy.grid.shape == shape
    assert occupancy.occupied.sum() == blocked
    assert np.isin(occupancy.grid, (0, 100)).all()
