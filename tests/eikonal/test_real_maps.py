"""Fields and paths on maps of others."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import label

from cavalcade.eikonal import TravelGrid, surface_distance, velocity_map
from cavalcade.world import load_map, load_movingai

ROS_MAPS = ["depot", "warehouse", "tb3_sandbox", "smoothers_world"]
MOVINGAI = ["room-32-32-4.map", "random-64-64-10.map", "warehouse-10-20-10-2-1.map"]


def tour(speed, cell, check_path, count=12):
    """Paths from all over the largest free part to one of its cells, on both kinds of march."""
    parts, _ = label(speed > 0.0)
    largest = parts == np.bincount(parts[parts > 0]).argmax()
    rng = np.random.default_rng(0)
    cells = rng.choice(np.argwhere(largest), count + 1)
    places = (cells[:, ::-1] + rng.uniform(0.05, 0.95, cells.shape)) * cell
    grid = TravelGrid(speed, cell)
    goal, starts = places[0], places[1:]
    field = grid.field(goal)
    np.testing.assert_array_equal(np.isfinite(field.times), largest)
    for start in starts:
        points, stamps = field.path(start)
        check_path(points, speed, cell, start, goal)
        length = np.hypot(*np.diff(points, axis=0).T).sum()
        assert length <= 1.05 * stamps[0] * speed.max() + 3.0 * cell
        local, eta = grid.local_path(start, goal)
        check_path(local, speed, cell, start, goal)
        assert eta == pytest.approx(stamps[0], rel=0.05, abs=8.0 * cell)


@pytest.mark.filterwarnings("ignore::cavalcade.world.MapWarning")
@pytest.mark.parametrize("name", ROS_MAPS)
def test_ros_maps(shared_data, check_path, name):
    world = load_map(shared_data(f"ros_maps/nav2/{name}.yaml"))
    distance = surface_distance(world.occupied, world.resolution)
    for safe in (1.5, 0.5):
        tour(velocity_map(distance, 0.3, safe), world.resolution, check_path)


@pytest.mark.parametrize("name", MOVINGAI)
def test_movingai_maps_with_their_one_cell_passages(shared_data, check_path, name):
    world = load_movingai(shared_data(f"movingai/{name}"), resolution=1.0)
    tour((~world.occupied).astype(float), 1.0, check_path, count=40)
