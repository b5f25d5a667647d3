from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from cavalcade.drawing.distances import obstacle_distances, pair_distances, rest_lengths
from cavalcade.drawing.scene import Scene
from cavalcade.recording.frames import ObstacleTrack
from cavalcade.scenario import World
from cavalcade.world import Circle, OccupancyMap


def scene_at(run, points, world, tracks=()):
    """One robot that stands at these points, a second each."""
    poses = np.zeros((len(points), 1, 3))
    poses[:, 0, :2] = points
    recording = dataclasses.replace(
        run.recording,
        time=np.arange(len(points), dtype=float),
        poses=poses,
        status=run.recording.status[: len(points)],
        obstacles=tuple(tracks),
    )
    return Scene(run.scenario, world, recording)


def test_distances_to_shape_cell_and_border(make_run):
    run = make_run(cycles=8, robots=1)
    grid = np.zeros((100, 100), dtype=np.int8)
    grid[50, 20] = 100  # the square x 1.00..1.05, y 2.50..2.55
    ground = OccupancyMap(grid, 0.05)
    disc = Circle((4.0, 4.0), 0.5)
    world = World(ground.with_shapes([disc]), ground, (disc,), ())
    points = [(4.0, 3.0), (4.1, 4.1), (1.02, 2.0), (1.02, 2.52), (1.35, 2.95), (0.2, 4.0), (5.3, 1)]
    found = obstacle_distances(scene_at(run, points, world))
    assert found[:, 0] == pytest.approx([0.5, 0.0, 0.5, 0.0, 0.5, 0.2, 0.0], abs=1e-9)


def test_an_obstacle_counts_while_it_is_there_and_where_it_is(make_run):
    run = make_run(cycles=8, robots=1)
    ground = OccupancyMap.empty((10.0, 10.0), 0.1)
    world = World(ground, ground, (), ())
    track = ObstacleTrack(
        shape={"circle": {"center": [5.0, 7.0], "radius": 0.5}},
        start=1.0,
        end=4.0,
        time=np.array([2.0, 3.0]),
        offset=np.array([[0.0, 0.0], [0.0, -1.0]]),
    )
    scene = scene_at(run, [(5.0, 5.0)] * 6, world, [track])
    found = obstacle_distances(scene)[:, 0]
    assert found == pytest.approx([5.0, 1.5, 1.5, 0.5, 5.0, 5.0])


def test_a_shape_that_an_event_removes_is_gone_afterwards(make_run):
    run = make_run(cycles=8, robots=1)
    ground = OccupancyMap.empty((10.0, 10.0), 0.1)
    disc = Circle((5.0, 6.0), 0.5)
    world = World(ground.with_shapes([disc]), ground, (disc,), ())
    track = ObstacleTrack(
        shape={"circle": {"center": [5.0, 6.0], "radius": 0.5}},
        start=0.0,
        end=2.0,
        time=np.array([0.0]),
        offset=np.zeros((1, 2)),
    )
    scene = scene_at(run, [(5.0, 5.0)] * 4, world, [track])
    assert scene.fixed == ()
    assert obstacle_distances(scene)[:, 0] == pytest.approx([0.5, 0.5, 5.0, 5.0])


def test_pair_distances_name_their_pairs():
    poses = np.zeros((1, 3, 3))
    poses[0, :, 0] = [0.0, 3.0, 7.0]
    pairs, gaps = pair_distances(poses)
    assert {tuple(pair): gap for pair, gap in zip(pairs.tolist(), gaps[0], strict=True)} == {
        (0, 1): 3.0,
        (0, 2): 7.0,
        (1, 2): 4.0,
    }


def test_rest_lengths_of_a_square_and_of_the_shape_after_it(make_run):
    run = make_run(cycles=40)
    scene = Scene(run.scenario, run.world, run.recording)
    assert {round(length, 2) for _, _, length in rest_lengths(scene)} == {1.0, 1.42}
    status = tuple(
        dataclasses.replace(one, slots=2.0 * one.slots) if i >= 20 else one
        for i, one in enumerate(run.recording.status)
    )
    scene = Scene(run.scenario, run.world, dataclasses.replace(run.recording, status=status))
    lengths = {}
    for start, _, length in rest_lengths(scene):
        lengths.setdefault(start, set()).add(round(length, 2))
    assert list(lengths.values()) == [{1.0, 1.42}, {2.01, 2.84}]
    assert list(lengths)[1] == scene.recording.time[20]
