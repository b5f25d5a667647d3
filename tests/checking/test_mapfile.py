"""The checker's own map decoder, by hand and against the world's."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from cavalcade.checking.mapfile import merge_cells, read_movingai, read_ros_map
from cavalcade.errors import RecordingError
from cavalcade.world.ros_map import load_map

WORDS = {
    "image": "map.png",
    "resolution": 0.5,
    "origin": [1.0, 2.0, 0.3],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


@pytest.fixture
def write_map(tmp_path):
    def write(picture, **changes):
        words = WORDS | changes
        Image.fromarray(np.asarray(picture, dtype=np.uint8)).save(tmp_path / words["image"])
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(words))
        return tmp_path / "map.yaml"

    return write


def cells_of(ground, resolution=0.5):
    rows, cols = (round(side / resolution) for side in ground.size[::-1])
    grid = np.zeros((rows, cols), dtype=int)
    for x0, y0, x1, y1 in np.rint(ground.blocks / resolution).astype(int):
        grid[y0:y1, x0:x1] += 1
    return grid


def test_the_first_line_of_the_picture_is_the_top(write_map):
    ground = read_ros_map(write_map([[0, 254, 254], [254, 254, 254]]), False)
    assert ground.size == (1.5, 1.0)
    assert ground.origin == (1.0, 2.0, 0.3)
    assert ground.blocks.tolist() == [[0.0, 0.5, 0.5, 1.0]]


@pytest.mark.parametrize("free", [False, True])
def test_unknown_counts_as_the_scenario_says(write_map, free):
    ground = read_ros_map(write_map([[205, 254]]), free)
    assert len(ground.blocks) == (0 if free else 1)


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("negate", [0, 1])
@pytest.mark.parametrize("unknown", ["occupied", "free"])
@pytest.mark.parametrize("opaque", [True, False])
@pytest.mark.parametrize("thresholds", [(0.196, 0.65), (0.5, 0.5), (0.0, 0.0), (1.0, 1.0)])
@pytest.mark.filterwarnings("ignore:.*free_thresh")
def test_it_reads_every_grey_as_the_world_does(
    write_map, mode, negate, unknown, opaque, thresholds
):
    grey = np.arange(256, dtype=np.uint8).reshape(16, 16)
    picture = grey
    if not opaque:
        alpha = np.where(np.arange(256).reshape(16, 16) % 3 == 0, 120, 255).astype(np.uint8)
        picture = np.stack([grey, grey, grey, alpha], axis=2)
    low, high = thresholds
    changes = {"mode": mode, "negate": negate, "free_thresh": low, "occupied_thresh": high}
    file = write_map(picture, **changes)
    ground = read_ros_map(file, unknown == "free")
    np.testing.assert_array_equal(cells_of(ground), load_map(file, unknown=unknown).occupied)


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(bool, hnp.array_shapes(min_dims=2, max_dims=2, max_side=12)))
def test_rectangles_cover_every_occupied_cell_exactly_once(occupied):
    grid = np.zeros(occupied.shape, dtype=int)
    for row0, col0, row1, col1 in merge_cells(occupied):
        grid[row0:row1, col0:col1] += 1
    np.testing.assert_array_equal(grid, occupied)


def test_a_wall_is_one_rectangle():
    occupied = np.zeros((20, 30), dtype=bool)
    occupied[4:9, 3:28] = True
    assert merge_cells(occupied).tolist() == [[4, 3, 9, 28]]


def test_movingai(tmp_path):
    file = tmp_path / "a.map"
    file.write_text("type octile\nheight 2\nwidth 3\nmap\n@..\n.T.\n")
    ground = read_movingai(file, 0.5)
    assert cells_of(ground).tolist() == [[0, 1, 0], [1, 0, 0]]


@pytest.mark.parametrize("damage", ["truncate", "missing", "key", "yaml", "list"])
def test_a_damaged_map_is_named(write_map, damage):
    file = write_map(np.full((40, 40), 254))
    if damage == "truncate":
        picture = file.with_name("map.png")
        picture.write_bytes(picture.read_bytes()[:60])
    elif damage == "missing":
        file.with_name("map.png").unlink()
    elif damage == "key":
        file.write_text("image: map.png\n")
    else:
        file.write_text("a: [" if damage == "yaml" else "- 1\n")
    with pytest.raises(RecordingError, match=r"map\.yaml"):
        read_ros_map(file, False)


@settings(max_examples=20, deadline=None)
@given(st.binary(max_size=200))
def test_noise_is_never_a_traceback(tmp_path_factory, content):
    file = tmp_path_factory.mktemp("noise") / "noise.map"
    file.write_bytes(b"height 2\nwidth 2\nmap\n" + content)
    with contextlib.suppress(RecordingError):
        read_movingai(file, 1.0)
