"""Paths down a field: they end at the goal, stay in free cells and never turn back."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.eikonal import TravelGrid, surface_distance, velocity_map

CELL = 0.05


def centre(cell):
    return (np.array([cell[1], cell[0]]) + 0.5) * CELL


def length_of(points):
    return np.hypot(*np.diff(points, axis=0).T).sum()


def maze(cells, seed):
    """Speeds of a spanning-tree maze of `cells` x `cells` rooms, passages one cell wide."""
    rng = np.random.default_rng(seed)
    speed = np.zeros((2 * cells + 1, 2 * cells + 1))
    stack = [(0, 0)]
    speed[1, 1] = 1.0
    while stack:
        r, c = stack[-1]
        ways = [(r + i, c + j) for i, j in ((0, 1), (1, 0), (0, -1), (-1, 0))]
        ways = [(i, j) for i, j in ways if 0 <= i < cells and 0 <= j < cells]
        ways = [(i, j) for i, j in ways if speed[2 * i + 1, 2 * j + 1] == 0.0]
        if not ways:
            stack.pop()
            continue
        i, j = ways[rng.integers(len(ways))]
        speed[r + i + 1, c + j + 1] = speed[2 * i + 1, 2 * j + 1] = 1.0
        stack.append((i, j))
    return speed


def check_all(grid, speed, goal, starts, check_path):
    """Every path obeys `check_path`; its stamps fall to 0 and start at the field's time."""
    field = grid.field(goal)
    for start in starts:
        points, stamps = field.path(start)
        check_path(points, speed, CELL, start, goal)
        assert stamps[0] == pytest.approx(field.eta(start), rel=1e-9)
        assert stamps[-1] == 0.0
        assert (np.diff(stamps) <= 0.0).all()
        steps = np.hypot(*np.diff(points, axis=0).T)
        assert steps.max(initial=0.0) < 13 * CELL
    return field


def free_points(speed, count, seed):
    """Random points in random free cells."""
    rng = np.random.default_rng(seed)
    cells = rng.choice(np.argwhere(speed > 0.0), count)
    return (cells[:, ::-1] + rng.uniform(0.01, 0.99, (count, 2))) * CELL


@pytest.mark.parametrize("seed", range(5))
def test_through_clutter(clutter, check_path, seed):
    speed = clutter(80, 110, seed, blocks=40)
    grid = TravelGrid(speed, CELL)
    times = grid.from_cells([tuple(np.argwhere(speed == speed.max())[0])])
    reached = np.where(np.isfinite(times), speed, 0.0)
    goal = centre(np.argwhere(speed == speed.max())[0]) + np.array([0.011, -0.017])
    check_all(grid, speed, goal, free_points(reached, 25, seed), check_path)


@pytest.mark.parametrize("seed", range(4))
def test_through_a_maze_of_one_cell_passages(check_path, seed):
    speed = maze(12, seed)
    grid = TravelGrid(speed, CELL)
    goal = centre((23, 23))
    field = check_all(grid, speed, goal, free_points(speed, 15, seed), check_path)
    points, stamps = field.path(centre((1, 1)))
    # In a maze there is one way: as long as its time at 1 m/s, less the corners' insides.
    assert 0.7 * stamps[0] <= length_of(points) <= stamps[0] + CELL


def test_in_unit_speed_paths_are_no_longer_than_their_time(clutter, check_path):
    """A path that swings to and fro would be longer than the front's way."""
    for seed in range(5):
        speed = (clutter(80, 80, seed, blocks=50) > 0.0).astype(float)
        grid = TravelGrid(speed, CELL)
        first = np.argwhere(speed > 0.0)[0]
        reached = np.isfinite(grid.from_cells([tuple(first)])).astype(float)
        goal = centre(first)
        field = grid.field(goal)
        for start in free_points(reached * speed, 20, seed):
            points, stamps = field.path(start)
            assert length_of(points) <= 1.02 * stamps[0] + 2.0 * CELL


def test_in_an_empty_room_paths_are_straight():
    grid = TravelGrid(np.ones((200, 280)), CELL)
    goal = np.array([12.03, 5.01])
    field = grid.field(goal)
    for start in np.array([[0.01, 0.02], [13.9, 9.9], [1.0, 5.0], [12.0, 0.1], [12.1, 5.3]]):
        points, _ = field.path(start)
        straight = np.hypot(*(goal - start))
        assert length_of(points) <= 1.02 * straight + CELL
        assert field.eta(start) == pytest.approx(straight, rel=0.05, abs=CELL)


def test_turns_are_gentle_in_the_open():
    """No step of a path goes against the one before it."""
    distance = np.hypot(*(np.indices((120, 160)) - 59.5 + 0.0)) * CELL
    speed = np.clip((distance - 0.3) / 1.5, 0.0, 1.0)
    grid = TravelGrid(speed, CELL)
    field = grid.field((7.5, 3.0))
    for y in np.linspace(0.5, 5.5, 21):
        points, _ = field.path((0.3, y))
        steps = np.diff(points, axis=0)[:-3]
        dots = (steps[:-1] * steps[1:]).sum(axis=1)
        assert (dots > 0.0).all()


def test_start_is_the_goal(check_path):
    grid = TravelGrid(np.ones((20, 20)), CELL)
    here = np.array([0.512, 0.498])
    points, stamps = grid.field(here).path(here)
    check_path(points, np.ones((20, 20)), CELL, here, here)
    assert length_of(points) == 0.0
    assert stamps[-1] == 0.0
    points, eta = grid.local_path(here, here)
    assert length_of(points) == 0.0
    assert eta == pytest.approx(0.0, abs=CELL)


def test_start_within_the_goal_s_cell(check_path):
    speed = np.ones((20, 20))
    grid = TravelGrid(speed, CELL)
    check_all(grid, speed, (0.51, 0.51), np.array([[0.549, 0.501], [0.5, 0.5]]), check_path)


def test_along_the_borders_and_from_corner_to_corner(check_path):
    speed = np.ones((30, 40))
    grid = TravelGrid(speed, CELL)
    corners = np.array([[1e-9, 1e-9], [2.0 - 1e-9, 1e-9], [1e-9, 1.5 - 1e-9], [1.999, 1.499]])
    for goal in corners:
        check_all(grid, speed, goal, corners, check_path)


@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (30, 1), (2, 2)])
def test_on_tiny_maps(check_path, shape):
    speed = np.ones(shape)
    goal = centre((0, 0))
    check_all(TravelGrid(speed, CELL), speed, goal, free_points(speed, 10, 0), check_path)


def test_a_gap_between_two_corners_is_no_way():
    speed = np.ones((10, 10))
    speed[:5, 5:] = speed[5:, :5] = 0.0
    grid = TravelGrid(speed, CELL)
    field = grid.field(centre((7, 7)))
    assert field.eta(centre((4, 4))) == np.inf
    assert grid.local_path(centre((4, 4)), centre((7, 7)))[1] == np.inf


def test_unreachable_starts_and_starts_in_obstacles_have_no_path():
    speed = np.ones((20, 20))
    speed[:, 10] = 0.0
    grid = TravelGrid(speed, CELL)
    field = grid.field(centre((5, 3)))
    for start in (centre((5, 15)), centre((5, 10)), (-0.3, 0.2), (0.2, 7.0)):
        points, stamps = field.path(start)
        assert points.shape == (0, 2)
        assert stamps.shape == (0,)
        assert field.eta(start) == np.inf
        points, eta = grid.local_path(start, centre((5, 3)))
        assert points.shape == (0, 2)
        assert eta == np.inf


def test_a_goal_in_an_obstacle_or_off_the_map_starts_nothing():
    speed = np.ones((20, 20))
    speed[5, 5] = 0.0
    grid = TravelGrid(speed, CELL)
    for goal in (centre((5, 5)), (-0.1, 0.5), (0.5, 1e300), (5.0, 0.5)):
        field = grid.field(goal)
        assert np.isinf(field.times).all()
        assert field.path(centre((1, 1)))[0].shape == (0, 2)
        assert field.nearest_reached((0.5, 0.5)) is None
        assert grid.local_path(centre((1, 1)), goal)[1] == np.inf


def test_a_robot_in_the_inflated_zone_finds_the_nearest_way_out():
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[28:32, 28:32] = True
    speed = velocity_map(surface_distance(occupied, CELL, border=False), 0.3, 0.5)
    grid = TravelGrid(speed, CELL)
    field = grid.field((0.3, 0.3))
    robot = np.array([1.2, 1.51])
    assert not grid.is_free(robot)
    free = np.argwhere(speed > 0.0)
    expected = np.min(np.hypot(*((free[:, ::-1] + 0.5) * CELL - robot).T))
    for way_out in (field.nearest_reached(robot), grid.nearest_free(robot)):
        assert grid.is_free(way_out)
        assert np.hypot(*(way_out - robot)) == pytest.approx(expected)
    assert field.nearest_reached(robot, reach=expected - 0.06) is None
    assert field.path(field.nearest_reached(robot))[0].shape[0] > 2
    assert np.hypot(*(grid.nearest_free((-1.0, -1.0)) - CELL / 2)) < 1e-9


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_tiny_and_huge_speeds(clutter, check_path, scale):
    speed = clutter(60, 60, 3, blocks=25) * scale
    grid = TravelGrid(speed, CELL)
    first = tuple(np.argwhere(speed == speed.max())[0])
    reached = np.where(np.isfinite(grid.from_cells([first])), speed, 0.0)
    check_all(grid, speed, centre(first), free_points(reached, 10, 1), check_path)


@pytest.mark.parametrize("seed", range(4))
def test_speeds_that_jump_by_decades(check_path, seed):
    rng = np.random.default_rng(seed)
    speed = 10.0 ** rng.uniform(-3.0, 2.0, (50, 50))
    speed[rng.random(speed.shape) < 0.15] = 0.0
    speed[25, 25] = 1.0
    grid = TravelGrid(speed, CELL)
    reached = np.where(np.isfinite(grid.from_cells([(25, 25)])), speed, 0.0)
    check_all(grid, speed, centre((25, 25)), free_points(reached, 20, seed), check_path)


@pytest.mark.parametrize("seed", range(4))
def test_with_several_goals_each_path_ends_at_one_of_them(clutter, check_path, seed):
    speed = clutter(60, 60, seed, blocks=30)
    grid = TravelGrid(speed, CELL)
    goals = free_points(speed, 4, seed + 50)
    field = grid.field(goals)
    starts = free_points(np.where(np.isfinite(field.times), speed, 0.0), 15, seed)
    for start in starts:
        points, stamps = field.path(start)
        away = np.hypot(*(goals - points[-1]).T)
        assert away.min() < 1e-9
        check_path(points, speed, CELL, start, goals[away.argmin()])
        assert stamps[-1] == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_local_path_equals_the_path_on_the_whole_field(clutter, check_path, seed):
    speed = clutter(90, 90, seed, blocks=35)
    grid = TravelGrid(speed, CELL)
    goals = free_points(speed, 12, seed)
    starts = free_points(speed, 12, seed + 99)
    for start, goal in zip(starts, goals, strict=True):
        field = grid.field(goal)
        points, eta = grid.local_path(start, goal)
        assert np.isfinite(eta) == np.isfinite(field.eta(start))
        if not np.isfinite(eta):
            continue
        check_path(points, speed, CELL, start, goal)
        # The local march has fewer straight-line seeds: a little more first-order error.
        assert eta == pytest.approx(field.eta(start), rel=0.08, abs=4.0 * CELL)
        whole, _ = field.path(start)
        assert length_of(points) == pytest.approx(length_of(whole), rel=0.1, abs=3.0 * CELL)
    again, _ = grid.local_path(start, goal)  # what was marched before leaves no trace
    fresh, _ = TravelGrid(speed, CELL).local_path(start, goal)
    np.testing.assert_array_equal(again, fresh)


def test_a_local_path_longer_than_the_first_buffer(check_path):
    """A serpentine of one-cell aisles."""
    speed = np.ones((41, 41))
    for k in range(1, 41, 2):
        speed[k, :] = 0.0
        speed[k, -1 if k % 4 == 1 else 0] = 1.0
    grid = TravelGrid(speed, CELL)
    start, goal = centre((0, 0)), centre((40, 0))
    points, eta = grid.local_path(start, goal)
    assert len(points) > 8 * 82
    check_path(points, speed, CELL, start, goal)
    whole, stamps = grid.field(goal).path(start)
    check_path(whole, speed, CELL, start, goal)
    assert eta == pytest.approx(stamps[0], rel=1e-3)
