"""Ways out of the path of what moves: what is said of a way is so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.eikonal import surface_distance
from cavalcade.formation._escape import STEP
from cavalcade.formation.escaping import STEPS, Surroundings, Way, WayFinder
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap

CELL, TOP, GO1 = 0.05, 0.5, (0.65, 0.28)
EMPTY = OccupancyMap.empty((10.0, 8.0), CELL)
REST = np.zeros(3)
EAST, NORTH = np.array([1.0, 0.0]), np.array([0.0, 1.0])


def around(movers, speeds, others=(), standing=()):
    """The map shows what moves, too, where it is at first."""
    movers = np.array(movers, dtype=float).reshape(-1, 5)
    boxes = [Box((m[0], m[1]), (2 * m[3], 2 * m[4]), m[2]) for m in movers]
    map = EMPTY.with_shapes([*standing, *boxes])
    others = np.array(others, dtype=float).reshape(-1, 3)
    plans = np.repeat(others[:, None], STEPS, axis=1)
    distance = surface_distance(map.occupied, CELL)
    return Surroundings(
        movers, np.array(speeds, dtype=float).reshape(-1, 2), plans, distance, CELL, 0.30
    )


def gap_to_mover(tools, pose, scene, time):
    return min(
        tools.sampled_gap(pose, np.array([*(m[:2] + time * v), m[2]]), GO1, tuple(2 * m[3:]))
        for m, v in zip(scene.movers, scene.speeds, strict=True)
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_way_is_clear_until_it_is_hit(tools, seed):
    rng = np.random.default_rng(seed)
    pose = np.array([5.0, 4.0, rng.uniform(-3, 3)])
    away = rng.uniform(-3.1, 3.1)
    place = pose[:2] + rng.uniform(0.9, 2.0) * np.array([np.cos(away), np.sin(away)])
    speed = -rng.uniform(0.1, 0.5) * np.array([np.cos(away), np.sin(away)])
    others = [(5.0 + 0.9 * np.cos(a), 4.0 + 0.9 * np.sin(a), a) for a in rng.uniform(-3, 3, 2)]
    wall = Box(tuple(rng.uniform((3.5, 2.5), (6.5, 3.2))), (0.8, 0.3))
    scene = around([(*place, rng.uniform(-3, 3), 0.3, 0.2)], [speed], others, [wall])
    finder = WayFinder(robot_model("go1"), TOP)
    way, hit = finder.of_all(NORTH, EAST, None, pose, REST, scene)
    if hit < 0.0:
        return  # not even standing is free of others
    poses = finder.poses(way, pose, REST)
    first = gap_to_mover(tools, pose, scene, 0.0)
    for k, at in enumerate(poses):
        time = k * STEP
        if time >= hit:
            assert gap_to_mover(tools, at, scene, time) < 0.02 + 1e-6
            break
        assert gap_to_mover(tools, at, scene, time) >= min(0.02, first) - 1e-5
        for other in others:
            assert tools.sampled_gap(at, np.array(other), GO1, GO1) > 0.0 or k == 0
        assert tools.sampled_gap(at, np.array([*wall.center, 0.0]), GO1, wall.size) > 0.0 or k == 0


def test_standing_is_a_way_where_that_is_best():
    """Nothing comes, and all around are walls."""
    walls = [Box((5.0, 4.0 + side * 0.6), (2.0, 0.2)) for side in (1.0, -1.0)]
    scene = around([(8.0, 1.0, 0.0, 0.2, 0.2)], [(0.1, 0.0)], standing=walls)
    finder = WayFinder(robot_model("go1"), TOP)
    way, hit = finder.of_all(NORTH, EAST, None, np.array([5.0, 4.0, 0.0]), REST, scene)
    assert way.steps == 0
    assert hit == np.inf
    np.testing.assert_array_equal(finder.command(way, 0.0), 0.0)


@pytest.mark.parametrize("steps", [10, 30])
def test_a_way_is_kept_while_it_is_good(steps):
    scene = around([(2.5, 4.0, 0.0, 0.2, 0.3)], [(0.4, 0.0)])
    finder, pose = WayFinder(robot_model("go1"), TOP), np.array([5.0, 4.0, 1.0])
    ways = [Way(NORTH, True), Way(-NORTH, True)]
    chosen = finder.at_hand(ways, None, pose, REST, scene)
    assert chosen is not None
    np.testing.assert_array_equal(chosen.direction, NORTH)
    before = Way(-NORTH, True, steps)
    kept = finder.at_hand(ways, before, pose, REST, scene)
    assert kept is not None
    np.testing.assert_array_equal(kept.direction, -NORTH)


def test_what_moves_bars_no_way_by_its_picture_in_the_map():
    """Out behind it, over ground that it leaves: only its body at each time counts."""
    scene = around([(5.6, 4.0, 0.0, 0.15, 0.15)], [(0.0, 0.5)])
    finder, pose = WayFinder(robot_model("go1"), TOP), np.array([4.6, 4.0, 0.0])
    found = finder.at_hand([Way(EAST, False)], None, pose, REST, scene)
    assert found is not None


def test_errors_of_the_poses_widen_the_gaps(tools):
    scene = around([(3.0, 4.0, 0.0, 0.2, 0.4)], [(0.4, 0.0)])
    pose = np.array([4.2, 4.2, 0.0])
    least = []
    for error in (0.0, 0.1):
        finder = WayFinder(robot_model("go1"), TOP, error)
        way, hit = finder.of_all(NORTH, EAST, None, pose, REST, scene)
        assert hit == np.inf
        poses = finder.poses(way, pose, REST)
        least.append(min(gap_to_mover(tools, at, scene, k * STEP) for k, at in enumerate(poses)))
    assert least[1] >= least[0]
    assert least[1] >= 0.12 - 1e-6
