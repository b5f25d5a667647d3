from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cavalcade.geometry import rectangle_corners
from cavalcade.metrics.clearance import begins, clearance
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.robots import robot_model
from cavalcade.scenario import World, build_world
from cavalcade.world import Box, Circle, OccupancyMap, Polygon, Shape

GO1 = robot_model("go1")
SIZE = (8.0, 6.0)


def world_of(*shapes: Shape, base: OccupancyMap | None = None) -> World:
    base = base or OccupancyMap.empty(SIZE)
    return World(base.with_shapes(shapes), base, shapes, ())


def recording_of(poses: Any, *tracks: ObstacleTrack, dt: float = 0.05) -> Recording:
    """One robot `(T, 3)` or several `(T, N, 3)`."""
    track = np.array(poses, dtype=float)
    track = track[:, None] if track.ndim == 2 else track
    time = dt * np.arange(len(track))
    return Recording(time, track, track, np.zeros_like(track), (), tracks, ())


def judged(world: World, recording: Recording) -> Any:
    return clearance(world, recording, [GO1] * recording.poses.shape[1])


def rim(pose: Any, count: int = 400) -> np.ndarray:
    """Points along a body's outline: a slow, obvious stand-in for its surface."""
    corners = rectangle_corners(pose, GO1.length, GO1.width)
    part = np.linspace(0.0, 1.0, count, endpoint=False)[:, None]
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate([a + part * (b - a) for a, b in zip(corners, ends, strict=True)])


def contains(pose: Any, points: np.ndarray) -> bool:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    off = points - pose[:2]
    along, across = c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0]
    return bool(((abs(along) < GO1.length / 2) & (abs(across) < GO1.width / 2)).any())


BEND = Polygon(((3.0, 3.0), (5.0, 3.0), (5.0, 3.4), (3.4, 3.4), (3.4, 4.5), (3.0, 4.5)))
SHAPES = [Circle((4.0, 3.0), 0.4), Box((4.0, 3.0), (1.0, 0.3), 0.4), BEND]


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(SHAPES),
    st.floats(1.5, 6.5),
    st.floats(1.5, 4.5),
    st.floats(-np.pi, np.pi),
)
def test_gap_to_a_shape_as_measured_along_the_outline(
    shape: Shape, x: float, y: float, yaw: float
) -> None:
    pose = (x, y, yaw)
    near = judged(world_of(shape), recording_of([pose]))
    border = min(x, y, SIZE[0] - x, SIZE[1] - y)
    at_centre = min(float(shape.distance([(x, y)])[0]), border)
    assert near.obstacle_distance == pytest.approx(at_centre, abs=1e-9)
    points = rim(pose)
    expected = min(
        float(shape.distance(points).min()),
        float(np.minimum(points, np.array(SIZE) - points).min()),
    )
    within = shape.points[0] if isinstance(shape, Polygon) else shape.center
    if contains(pose, np.array([within])):
        assert near.robot_obstacle == 1
        return
    # The sampled outline can only overstate the gap, by half a step along it.
    assert near.footprint_gap <= expected + 1e-9
    assert near.footprint_gap >= expected - 2e-3
    if expected > 2e-3:
        assert near.robot_obstacle == 0


@settings(max_examples=60, deadline=None)
@given(
    st.floats(-1.0, 1.0),
    st.floats(-1.0, 1.0),
    st.floats(-np.pi, np.pi),
    st.floats(-np.pi, np.pi),
)
def test_gap_between_bodies_as_measured_along_the_outline(
    dx: float, dy: float, one: float, other: float
) -> None:
    first, second = (4.0, 3.0, one), (4.0 + dx, 3.0 + dy, other)
    recording = recording_of([[first, second]])
    near = judged(world_of(), recording)
    assert near.robot_distance == pytest.approx(np.hypot(dx, dy))
    body = Box(second[:2], (GO1.length, GO1.width), other)
    expected = float(body.distance(rim(first)).min())
    if contains(first, np.array([second[:2]])):
        assert near.robot_robot == 1
    elif expected > 2e-3:
        assert near.robot_robot == 0
        assert near.footprint_gap == pytest.approx(expected, abs=2e-3)
    swapped = judged(world_of(), recording_of([[second, first]]))
    assert swapped.robot_robot == near.robot_robot
    assert swapped.footprint_gap == pytest.approx(near.footprint_gap, abs=1e-12)


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.floats(1.5, 6.5),
    st.floats(1.5, 4.5),
    st.floats(-np.pi, np.pi),
    st.floats(-0.5, 0.5),
)
def test_cells_of_a_map_file_are_squares(
    seed: int, x: float, y: float, yaw: float, tilt: float
) -> None:
    random = np.random.default_rng(seed)
    grid = random.random((30, 40)) < 0.01
    base = OccupancyMap(grid, 0.2, (0.3, -0.2, tilt))
    poses = [(x, y, yaw), (x + 0.3, y, yaw + 1.0)]
    assume(base.contains(np.array(poses)[:, :2]).all())
    near = judged(world_of(base=base), recording_of(poses))
    cells = [Box(tuple(c), (0.2, 0.2), tilt) for c in base.centers(np.argwhere(grid))]
    width, height = base.size
    walls = [
        Box(tuple(base.to_map([centre])[0]), size, tilt)
        for centre, size in (
            ((-0.5, height / 2), (1.0, height + 2)),
            ((width + 0.5, height / 2), (1.0, height + 2)),
            ((width / 2, -0.5), (width, 1.0)),
            ((width / 2, height + 0.5), (width, 1.0)),
        )
    ]
    boundless = OccupancyMap.empty((30.0, 30.0), 1.0)
    boundless = OccupancyMap(boundless.grid, 1.0, (-10.0, -10.0, 0.0))
    world = World(boundless, boundless, (*cells, *walls), ())
    same = judged(world, recording_of(poses))
    assert near.obstacle_distance == pytest.approx(same.obstacle_distance, abs=1e-9)
    assert near.footprint_gap == pytest.approx(same.footprint_gap, abs=1e-9)
    assert (near.robot_obstacle > 0) == (same.robot_obstacle > 0)


def test_contact_between_two_samples_is_found() -> None:
    """Straight through a thin wall from one sample to the next."""
    wall = world_of(Box((4.0, 3.0), (0.05, 1.0)))
    near = judged(wall, recording_of([(3.0, 3.0, np.pi / 2), (5.0, 3.0, np.pi / 2)]))
    assert near.robot_obstacle == 1
    assert near.footprint_gap == 0.0


def test_each_contact_counts_once_when_it_begins() -> None:
    wall = world_of(Box((4.0, 3.0), (0.5, 0.5)))
    x = [3.0, 3.6, 3.7, 3.6, 3.0, 3.0, 3.6, 3.0]
    near = judged(wall, recording_of([(v, 3.0, 0.0) for v in x]))
    assert near.robot_obstacle == 2


def test_robots_that_pass_through_each_other() -> None:
    x = np.linspace(3.0, 5.0, 41)
    poses = np.stack([np.column_stack([v, 3.0 + 0 * v, 0 * v]) for v in (x, 8.0 - x)], axis=1)
    near = judged(world_of(), recording_of(poses))
    assert near.robot_robot == 1
    assert near.robot_obstacle == 0
    assert near.robot_distance == pytest.approx(0.0, abs=1e-9)


def test_leaving_the_map_is_a_collision() -> None:
    near = judged(world_of(), recording_of([(1.0, 3.0, 0.0), (0.3, 3.0, 0.0)]))
    assert near.robot_obstacle == 1
    assert near.obstacle_distance == pytest.approx(0.3)


def test_a_moving_obstacle_counts_where_it_is_while_it_is_there() -> None:
    circle = {"circle": {"center": [1.0, 1.0], "radius": 0.3}}
    standing = [(4.0, 3.0, 0.0)] * 21

    def near(start: float, end: float, *knots: tuple[float, float, float]) -> Any:
        time = np.array([k[0] for k in knots])
        offset = np.array([k[1:] for k in knots])
        track = ObstacleTrack(circle, start, end, time, offset)
        return judged(world_of(), recording_of(standing, track))

    passing = near(0.0, np.inf, (0.0, 0.0, 2.0), (1.0, 6.0, 2.0))
    assert passing.robot_obstacle == 1
    assert passing.obstacle_distance == 0.0
    in_time = near(0.0, 0.3, (0.0, 0.0, 2.0), (1.0, 6.0, 2.0))
    assert in_time.robot_obstacle == 0
    # Gone at 0.3 s, when it is at x = 2.8.
    assert in_time.obstacle_distance == pytest.approx(4.0 - 2.8 - 0.3, abs=0.1)
    beside = near(0.0, np.inf, (0.0, 3.0, 3.0), (1.0, 3.0, 3.0))
    assert beside.obstacle_distance == pytest.approx(0.7)
    assert beside.footprint_gap == pytest.approx(0.7 - 0.14)


def test_a_shape_with_a_track_counts_by_its_track_alone() -> None:
    circle = Circle((4.0, 3.0), 0.3)
    words = {"circle": {"center": [4.0, 3.0], "radius": 0.3}}
    gone = ObstacleTrack(words, 0.0, 0.5, np.array([0.0]), np.zeros((1, 2)))
    poses = [(1.0, 1.0, 0.0)] * 20 + [(4.0, 3.0, 0.0)]
    near = judged(world_of(circle), recording_of(poses, gone))
    assert near.robot_obstacle == 0


def test_begins() -> None:
    assert begins(np.array([], dtype=bool)) == 0
    assert begins(np.array([True, True, False, True, False])) == 2


def test_free_ground_of_a_scenario(make_scenario: Callable[..., Any]) -> None:
    scenario = make_scenario()
    near = judged(build_world(scenario), recording_of([scenario.starts]))
    assert near.obstacle_distance == pytest.approx(1.5)
    assert near.robot_distance == pytest.approx(1.0)
    assert near.footprint_gap == pytest.approx(1.0 - GO1.length)


def test_nothing_is_swept_across_a_leap() -> None:
    """The ends are judged all the same."""
    world = world_of(Box((4.0, 3.0), (0.4, 5.0)))
    poses = [(2.0, 3.0, 0.0), (2.0, 3.0, 0.0), (6.0, 3.0, 0.0)]
    assert judged(world, recording_of(poses)).robot_obstacle == 1
    recording, leapt = recording_of(poses), np.array([[False], [True]])
    found = clearance(world, recording, [GO1], leapt)
    assert found.robot_obstacle == 0
    assert found.obstacle_distance == pytest.approx(1.8)
    for end in (1, 2):
        inside = poses.copy()
        inside[end] = (4.0, 3.0, 0.0)
        assert clearance(world, recording_of(inside), [GO1], leapt).robot_obstacle == 1
