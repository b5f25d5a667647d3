"""Teams on maps of coarse cells, as those of games and streets."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.formation import Formation, FormationPlanner
from cavalcade.jobs import run
from cavalcade.world import Box, OccupancyMap

GO1 = (0.65, 0.28)


@pytest.mark.parametrize("cell", [0.02, 0.05, 0.1, 0.25, 0.5])
@pytest.mark.parametrize("shape", [Formation.column(3, 0.9), Formation.square(1.0)])
def test_bodies_touched_the_corners_of_coarse_cells(tools, cell, shape):
    """Round two corners and between them, through a way two cells of half a metre wide."""
    blocks = [Box((5.0, 1.5), (2.0, 3.0)), Box((5.0, 5.5), (2.0, 3.0)), Box((7.5, 4.5), (1.0, 1.0))]
    map = OccupancyMap.empty((11.0, 7.0), cell).with_shapes(blocks)
    planner = FormationPlanner(map, shape)
    planner.set_goal((9.5, 1.5, -1.5))
    drive = tools.drive(planner, tools.placed(shape, (1.5, 1.5, 0.5)), 120.0)
    every = 2 if cell > 0.05 else 20  # the many squares of fine cells take their time
    gaps = [
        tools.occupied_gap(pose, GO1, map.occupied, cell)
        for poses in drive.poses[::every]
        for pose in poses
    ]
    assert min(gaps) > 0.005
    assert drive.status[-1].arrived


@pytest.mark.slow
def test_eight_robots_on_a_street_map_touched_a_corner(shared_data):
    result = run(shared_data("cases/coarse-cells-grid8.yaml"), figures=False, replay=False)
    assert result.success
    assert result.summary.min_footprint_gap_m > 0.005


@pytest.mark.parametrize(
    ("x", "moved"), [(4.4, False), (0.33, False), (0.26, False), (0.24, True), (0.23, True)]
)
def test_slots_were_put_where_the_filter_lets_no_centre_go(x, moved):
    """At the near end of a free cell, whose centre alone is far enough from the border."""
    map = OccupancyMap.empty((8.8, 8.8), 0.22)
    planner = FormationPlanner(map, Formation.custom([(0.0, 0.0)]))
    planner.set_goal((x, 4.4, np.pi / 2))
    planner.step(np.array([[4.4, 4.4, 0.0]]), 0.0)
    assert (planner.status.goal_moved > 0.0) == moved
