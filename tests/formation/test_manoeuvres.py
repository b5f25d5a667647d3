"""Evasive manoeuvres: what is said of one is so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cavalcade.eikonal import surface_distance
from cavalcade.formation._clearance import Surroundings
from cavalcade.formation._evasive_motion import STEP
from cavalcade.formation.dynamic_avoidance import STEPS, Manoeuvre, ManoeuvreSearch, Scene
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap

CELL, TOP, GO1 = 0.05, 0.5, (0.65, 0.28)
PARTS = 32  # of a step, for which gaps are kept
EMPTY = OccupancyMap.empty((10.0, 8.0), CELL)
REST = np.zeros(3)
EAST, NORTH = np.array([1.0, 0.0]), np.array([0.0, 1.0])


def scene_of(pose, movers, speeds, others=(), standing=()):
    """The map shows what moves, too, where it is at first."""
    movers = np.array(movers, dtype=float).reshape(-1, 5)
    boxes = [Box((m[0], m[1]), (2 * m[3], 2 * m[4]), m[2]) for m in movers]
    map = EMPTY.with_shapes([*standing, *boxes])
    others = np.array(others, dtype=float).reshape(-1, 3)
    plans = np.repeat(others[:, None], STEPS, axis=1)
    speeds = np.array(speeds, dtype=float).reshape(-1, 2)
    distances = surface_distance(map.occupied, CELL)
    around = Surroundings(distances, CELL, movers[:, :3].copy(), movers[:, 3:].copy(), speeds)
    return Scene(np.array(pose, dtype=float), REST, around, plans, 0.30)


def gap_to_mover(tools, pose, scene, time):
    return min(
        tools.sampled_gap(pose, np.array([*(at[:2] + time * v), at[2]]), GO1, tuple(2 * half))
        for at, half, v in zip(*scene.surroundings[2:], strict=True)
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.5, 1.5]))
@example(586, 0.5)  # chosen, it was hit 0.1 s before the latest hit of all, which was told
@example(1467, 0.5)  # between two poses it came 12 mm too near
@example(1017, 1.5)  # between two poses it was touched
def test_a_manoeuvre_is_clear_until_it_is_hit(footprint_gap, seed, fastest):
    rng = np.random.default_rng(seed)
    pose = np.array([5.0, 4.0, rng.uniform(-3, 3)])
    away = rng.uniform(-3.1, 3.1)
    place = pose[:2] + rng.uniform(0.9, 2.0) * np.array([np.cos(away), np.sin(away)])
    speed = -rng.uniform(0.1, fastest) * np.array([np.cos(away), np.sin(away)])
    others = [(5.0 + 0.9 * np.cos(a), 4.0 + 0.9 * np.sin(a), a) for a in rng.uniform(-3, 3, 2)]
    wall = Box(tuple(rng.uniform((3.5, 2.5), (6.5, 3.2))), (0.8, 0.3))
    mover = np.array([*place, rng.uniform(-3, 3)])
    scene = scene_of(pose, [(*mover, 0.3, 0.2)], [speed], others, [wall])
    search = ManoeuvreSearch(robot_model("go1"), TOP)
    best, hit = search.best(NORTH, EAST, None, scene)
    if hit < 0.0:
        return  # not even standing is free of others
    poses = search.poses(best, pose, REST)

    def gaps(shape, at, there):
        return footprint_gap((0.325, 0.14, False), at, shape, np.broadcast_to(there, at.shape))

    # The mover is met at no time before, also between the poses, and then it is.
    times = np.append(np.arange(0.0, min(hit, (STEPS - 1) * STEP), STEP / PARTS), min(hit, 7.9))
    at = np.column_stack([np.interp(times, STEP * np.arange(STEPS), p) for p in poses.T])
    there = np.column_stack([mover[:2] + times[:, None] * speed, np.full(len(times), mover[2])])
    near = gaps((0.3, 0.2, False), at, there)
    assert near[:-1].min() >= min(0.02, near[0]) - 1e-5 - (TOP + fastest) * STEP / PARTS
    if hit < np.inf:
        assert near[-1] < 0.02 + 1e-6
    else:
        assert near[-1] >= min(0.02, near[0]) - 1e-5
    # What stands is not met at any pose after the first until then.
    looks = poses[1 : int(min(hit, STEPS * STEP) / STEP + 1e-9)]
    if len(looks):
        assert gaps((0.4, 0.15, False), looks, [*wall.center, 0.0]).min() > 0.0
        for other in others:
            assert gaps((0.325, 0.14, False), looks, other).min() > 0.0


def test_standing_is_a_manoeuvre_where_that_is_best():
    """Nothing comes, and all around are walls."""
    walls = [Box((5.0, 4.0 + side * 0.6), (2.0, 0.2)) for side in (1.0, -1.0)]
    scene = scene_of((5.0, 4.0, 0.0), [(8.0, 1.0, 0.0, 0.2, 0.2)], [(0.1, 0.0)], standing=walls)
    search = ManoeuvreSearch(robot_model("go1"), TOP)
    best, hit = search.best(NORTH, EAST, None, scene)
    assert best.steps == 0
    assert hit == np.inf
    np.testing.assert_array_equal(search.command(best, 0.0), 0.0)


@pytest.mark.parametrize("steps", [10, 30])
def test_a_manoeuvre_is_kept_while_it_is_good(steps):
    scene = scene_of((5.0, 4.0, 1.0), [(2.5, 4.0, 0.0, 0.2, 0.3)], [(0.4, 0.0)])
    search = ManoeuvreSearch(robot_model("go1"), TOP)
    simple = [Manoeuvre(NORTH, True), Manoeuvre(-NORTH, True)]
    chosen = search.simple(simple, None, scene)
    assert chosen is not None
    np.testing.assert_array_equal(chosen.direction, NORTH)
    before = Manoeuvre(-NORTH, True, steps)
    kept = search.simple(simple, before, scene)
    assert kept is not None
    np.testing.assert_array_equal(kept.direction, -NORTH)


def test_what_moves_bars_nothing_by_its_picture_in_the_map():
    """Out behind it, over ground that it leaves: only its body at each time counts."""
    scene = scene_of((4.6, 4.0, 0.0), [(5.6, 4.0, 0.0, 0.15, 0.15)], [(0.0, 0.5)])
    search = ManoeuvreSearch(robot_model("go1"), TOP)
    found = search.simple([Manoeuvre(EAST, False)], None, scene)
    assert found is not None


def test_errors_of_the_poses_widen_the_gaps(tools):
    pose = np.array([4.2, 4.2, 0.0])
    scene = scene_of(pose, [(3.0, 4.0, 0.0, 0.2, 0.4)], [(0.4, 0.0)])
    least = []
    for error in (0.0, 0.1):
        search = ManoeuvreSearch(robot_model("go1"), TOP, error)
        best, hit = search.best(NORTH, EAST, None, scene)
        assert hit == np.inf
        poses = search.poses(best, pose, REST)
        least.append(min(gap_to_mover(tools, at, scene, k * STEP) for k, at in enumerate(poses)))
    assert least[1] >= least[0]
    assert least[1] >= 0.12 - 1e-6
