from __future__ import annotations

import numpy as np
import pytest

from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.maps import Distances
from cavalcade.world import Box, OccupancyMap

SIZE = (6.0, 4.0)


def cell_of(ground: DiscRegions, x: float, y: float) -> tuple[int, int]:
    return int(y / ground.step), int(x / ground.step)


def test_free_ground():
    ground = DiscRegions(OccupancyMap.empty(SIZE))
    ways = Distances(ground, cell_of(ground, 1.0, 1.0), 40.0)
    places = [(4.0, 1.0), (1.0, 3.0), (4.0, 3.0), (1.0, 1.0)]
    found = ways.to([cell_of(ground, *place) for place in places])
    straight = np.array([np.hypot(x - 1.0, y - 1.0) for x, y in places])
    assert (found >= straight - 0.3).all()
    assert (found <= 1.09 * straight + 0.3).all()


def test_around_a_wall_and_no_further_than_asked():
    ground = DiscRegions(OccupancyMap.empty(SIZE), [Box((3.0, 1.5), (0.1, 3.0))])
    ends = cell_of(ground, 2.0, 1.0), cell_of(ground, 4.0, 1.0)
    around = Distances(ground, ends[0], 40.0).to([ends[1]])[0]
    assert around > 4.5
    assert np.isinf(Distances(ground, ends[0], around - 0.1).to([ends[1]])[0])


@pytest.mark.parametrize("thickness", [0.02, 0.1])
def test_walls_part(thickness):
    ground = DiscRegions(OccupancyMap.empty(SIZE), [Box((3.0, 2.0), (thickness, 4.0))])
    ways = Distances(ground, cell_of(ground, 1.0, 1.0), 40.0)
    assert np.isinf(ways.to([cell_of(ground, 4.0, 1.0)])[0])
    assert not np.isfinite(ways.length[:, ways.length.shape[1] // 2 + 1 :]).any()
