from __future__ import annotations

import numpy as np
import pytest

from cavalcade.errors import MapError
from cavalcade.world import distance_to_shapes, is_connected, load_barn

HEADER = "x_m,y_m,radius_m\n"


def test_circles_move_to_the_corner(tmp_path):
    path = tmp_path / "world.csv"
    path.write_text(HEADER + "-4.4,0.1,0.1\n-0.1,5.0,0.1\n")
    world = load_barn(path, beyond=2.0)
    assert world.size == pytest.approx((4.5, 7.1))
    assert world.offset == pytest.approx((-4.5, 0.0))
    assert world.circles[1].center == pytest.approx((4.4, 5.0))
    assert world.to_map(0.1).grid.shape == (71, 45)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1"),
        ("x,y,r\n1,2,3\n", "line 1"),
        (HEADER, "no circle"),
        (HEADER + "1,2\n", "line 2"),
        (HEADER + "1,2,3\n1,2,nan\n", "line 3"),
        (HEADER + "1,2,3\n1,2,three\n", "line 3"),
        (HEADER + "1,2,3\n1,2,-3\n", "line 3"),
        (HEADER + "1,2,\xb5\n", "text file"),
    ],
)
def test_bad_files(tmp_path, text, message):
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(MapError, match=message) as caught:
        load_barn(path)
    assert caught.value.file == str(path)


@pytest.mark.parametrize("number", [1, 104, 299])
def test_real_worlds(shared_data, number):
    world = load_barn(shared_data(f"barn/circles/world_{number}.csv"), beyond=2.0)
    assert world.size == pytest.approx((4.5, 11.6))
    assert world.offset == pytest.approx((-4.5, 0.0))
    occupancy = world.to_map()
    free = occupancy.centers(np.argwhere(~occupancy.occupied))
    assert distance_to_shapes(world.circles, free).min() > 0.0


def test_the_reference_path_is_free(shared_data):
    world = load_barn(shared_data("barn/circles/world_1.csv"))
    steps = np.load(shared_data("barn/paths/path_1.npy"))
    path = steps * 0.15 + (-4.575, 5.075) - world.offset
    path = path[path[:, 1] < world.size[1] - 0.2]
    assert len(path) > 20
    assert distance_to_shapes(world.circles, path).min() > 0.05
    assert is_connected(world.circles, world.size, path[0], path[-1], radius=0.1)
