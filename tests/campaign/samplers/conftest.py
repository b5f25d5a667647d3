from __future__ import annotations

import numpy as np
import pytest

from cavalcade.campaign.samplers import DataFolder
from cavalcade.world import OccupancyMap, save_map

HEADER = "x_m,y_m,radius_m\n"


def yard(*cylinders: tuple[float, float]) -> str:
    """A field like those of the BARN data set, with these cylinders in its upper half."""
    side = [(x, y) for x in (-4.425, -0.075) for y in np.arange(0.075, 9.6, 0.15)]
    wall = [(x, 0.075) for x in np.arange(-4.275, -0.2, 0.15)]
    return HEADER + "".join(f"{x:.6f},{y:.6f},0.075000\n" for x, y in side + wall + [*cylinders])


@pytest.fixture
def data(tmp_path) -> DataFolder:
    """A folder of data with three yards, the last one closed, and a map of two halls."""
    folder = tmp_path / "data"
    circles = folder / "barn" / "circles"
    circles.mkdir(parents=True)
    (circles / "world_2.csv").write_text(yard((-2.0, 7.0)))
    (circles / "world_10.csv").write_text(yard((-3.0, 6.0), (-1.2, 8.0)))
    closed = [(x, 7.0) for x in np.arange(-4.275, -0.2, 0.15)]
    (circles / "world_111.csv").write_text(yard(*closed))
    (circles / "notes.txt").write_text("not a world")
    grid = np.zeros((160, 240), dtype=np.int8)
    grid[:4] = grid[-4:] = 100
    grid[:, :4] = grid[:, -4:] = 100
    grid[:, 118:122] = 100
    grid[60:90, 118:122] = 0
    grid[100:110, 20:40] = -1
    save_map(OccupancyMap(grid, 0.05, (-3.0, 2.0, 0.3)), folder / "halls.yaml")
    return DataFolder(folder)
