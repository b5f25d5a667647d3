"""Robots left the way of what moves straight to the side, whatever that led into.

The map shows each obstacle where it is now, and the planner is told how it moves.
"""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.formation import DynamicObstacle, Formation, FormationPlanner
from cavalcade.world import Box, OccupancyMap

GO1 = (0.65, 0.28)
EMPTY = OccupancyMap.empty((10.0, 8.0), 0.05)


def least_gaps(tools, poses, standing, moving, seconds=14.0):
    """Least gaps of robots whose goal is where they stand: to what moves, stands and each other.

    `moving` are (centre, size, velocity) of boxes.
    """
    poses = np.array(poses, dtype=float)
    still = EMPTY.with_shapes(standing)
    formation = Formation.custom(poses[:, :2] - poses[0, :2])
    planner = FormationPlanner(still, formation)
    planner.set_goal((*poses[0, :2], 0.0))
    log = []

    def hook(cycle, planner):
        boxes = [
            Box(tuple(np.array(centre) + 0.05 * cycle * np.array(velocity)), size)
            for centre, size, velocity in moving
        ]
        if cycle % 3 == 0:
            planner.update_map(still.with_shapes(boxes))
        planner.set_dynamic_obstacles(
            [DynamicObstacle(box, item[2]) for box, item in zip(boxes, moving, strict=True)]
        )
        log.append(boxes)

    drive = tools.drive(planner, poses, seconds, hook, until_arrived=False)
    to_moving = min(
        tools.sampled_gap(pose, np.array([*box.center, 0.0]), GO1, box.size)
        for boxes, now in zip(log, drive.poses, strict=True)
        for box in boxes
        for pose in now
    )
    to_standing = min(
        tools.sampled_gap(pose, np.array([*box.center, 0.0]), GO1, box.size)
        for box in standing
        for now in drive.poses[::4]
        for pose in now
    )
    to_robots = min(
        (
            tools.sampled_gap(now[i], now[k], GO1, GO1)
            for now in drive.poses[::4]
            for i in range(len(now))
            for k in range(i)
        ),
        default=1.0,
    )
    return to_moving, to_standing, to_robots


@pytest.mark.parametrize("speed", [0.2, 0.35])
def test_before_one_as_wide_as_the_passage_it_goes_out_by_the_end(tools, speed):
    walls = [Box((3.5, 4.0 + side * 0.9), (3.4, 0.4)) for side in (1.0, -1.0)]
    mover = ((2.2, 4.0), (0.4, 1.1), (speed, 0.0))
    gaps = least_gaps(tools, [(4.3, 4.1, 0.0)], walls, [mover])
    assert min(gaps) > 0.0


def test_not_into_a_niche_that_is_too_narrow(tools):
    """On the nearer side three posts leave the body no room; on the other it is open."""
    posts = [Box((x, 5.1), (0.3, 0.3)) for x in (4.1, 5.0, 5.9)]
    mover = ((2.5, 4.0), (0.4, 1.2), (0.35, 0.0))
    gaps = least_gaps(tools, [(5.0, 4.1, 0.0)], posts, [mover])
    assert min(gaps) > 0.0


def test_not_out_of_one_way_into_another(tools):
    """Two come at once, from behind and from the side that is left sooner."""
    movers = [((2.5, 4.0), (0.4, 1.0), (0.35, 0.0)), ((5.0, 6.8), (1.0, 0.4), (0.0, -0.25))]
    gaps = least_gaps(tools, [(5.0, 4.1, 0.0)], [Box((5.0, 0.5), (1.0, 0.2))], movers)
    assert min(gaps) > 0.0


def test_others_make_room_for_one_that_has_no_other_way(tools):
    """A wall on one side, a robot that nothing threatens on the other, and little time."""
    wall = Box((5.0, 3.5), (6.0, 0.3))
    mover = ((2.9, 4.0), (0.4, 0.6), (0.45, 0.0))
    gaps = least_gaps(tools, [(4.4, 4.0, 0.0), (4.4, 4.9, 0.0)], [wall], [mover])
    assert min(gaps) > 0.0
