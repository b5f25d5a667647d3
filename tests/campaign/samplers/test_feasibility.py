from __future__ import annotations

from collections import deque

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from cavalcade.campaign.samplers.feasibility import RADIUS, DiscRegions, _within
from cavalcade.world import Box, Circle, OccupancyMap, is_connected
from cavalcade.world.shapes import distance_to_shapes

SIZE = (4.0, 3.0)
START, GOAL = (0.5, 1.5), (3.5, 1.5)


def wall(gap: float) -> list[Box]:
    """A wall across the middle with a gap of that width around y = 1.5."""
    length = (SIZE[1] - gap) / 2.0
    return [
        Box((2.0, length / 2.0), (0.2, length)),
        Box((2.0, SIZE[1] - length / 2.0), (0.2, length)),
    ]


def reached(shapes, radius, step=0.05):
    """Slow and obvious: flood fill, every way between two nodes looked at in steps of 5 mm."""

    def clear(point) -> bool:
        x, y = point
        border = min(x, y, SIZE[0] - x, SIZE[1] - y)
        return min(border, distance_to_shapes(shapes, [point])[0]) >= radius - 1e-9

    def way_clear(a, b) -> bool:
        count = int(np.ceil(np.hypot(b[0] - a[0], b[1] - a[1]) / 0.005)) + 1
        points = np.linspace(a, b, count)
        border = np.minimum(points, np.array(SIZE) - points).min(axis=1)
        return bool((np.minimum(border, distance_to_shapes(shapes, points)) >= radius).all())

    first = (round(START[0] / step), round(START[1] / step))
    last = (round(GOAL[0] / step), round(GOAL[1] / step))
    if not clear(START) or not clear(GOAL):
        return False
    seen, queue = {first}, deque([first])
    while queue:
        here = queue.popleft()
        if here == last:
            return True
        for dx, dy in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            there = (here[0] + dx, here[1] + dy)
            ends = np.array(here) * step, np.array(there) * step
            if there not in seen and clear(ends[1]) and way_clear(*ends):
                seen.add(there)
                queue.append(there)
    return False


def connected(shapes, radius=RADIUS, size=SIZE, start=START, goal=GOAL) -> bool:
    return DiscRegions(OccupancyMap.empty(size), shapes, radius).connect([start], [goal])


@pytest.mark.parametrize(("gap", "open_"), [(0.59, False), (0.60, False), (0.63, True)])
def test_a_gap_is_as_wide_as_the_disc(gap, open_):
    assert connected(wall(gap)) is open_


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_a_flood_fill(seed):
    rng = np.random.default_rng(seed)
    shapes = [
        Circle((rng.uniform(1.0, 3.0), rng.uniform(0.0, 3.0)), rng.uniform(0.1, 0.4))
        for _ in range(5)
    ]
    shapes.append(Box((rng.uniform(1.2, 2.8), rng.uniform(0, 3)), (0.9, 0.2), rng.uniform(0, 3)))
    found = connected(shapes)
    # Either lattice may miss a way that is hardly wider than a step of it.
    if found:
        assert reached(shapes, RADIUS - 0.04)
    else:
        assert not reached(shapes, RADIUS + 0.02)


@settings(max_examples=40, deadline=None)
@given(
    circles=st.lists(
        st.tuples(st.floats(1.0, 3.0), st.floats(0.0, 3.0), st.floats(0.1, 0.5)), max_size=6
    )
)
def test_laws(circles):
    shapes = [Circle((x, y), r) for x, y, r in circles]
    found = connected(shapes)
    mirrored = [Circle((x, SIZE[1] - y), r) for x, y, r in circles]
    if found:
        # A smaller disc and a disc among fewer obstacles get there too, and so does the one in
        # the mirror but where a way is hardly wide enough.
        assert connected(shapes, RADIUS - 0.05)
        assert connected(shapes[:-1])
        assert connected(mirrored, RADIUS - 0.02)
        assert connected(shapes, start=GOAL, goal=START)
    else:
        assert not connected(mirrored, RADIUS + 0.02)
        assert not is_connected(shapes, SIZE, START, GOAL, RADIUS + 0.02, 0.0125)


def test_a_team_needs_all_of_its_slots():
    ground = DiscRegions(OccupancyMap.empty(SIZE), wall(0.4))
    left, right = [(0.5, 1.0), (0.5, 2.0)], [(3.5, 1.0), (3.5, 2.0)]
    assert ground.connect(left, left)
    assert not ground.connect(left, right)
    assert not ground.connect([*left, right[0]], left)
    assert not ground.connect(left, [left[0], (0.1, 1.0)])  # its disc reaches beyond the border
    assert not ground.connect(left, [(-1.0, 1.0)])


@pytest.mark.parametrize("reach", [0.4, 0.9, 1.0, 1.5, 2.3, 6.04, 10.07])
def test_squares_within_reach_against_a_distance_transform(reach):
    rng = np.random.default_rng(1)
    occupied = rng.random((40, 55)) < 0.02
    bordered = np.pad(occupied, 1, constant_values=True)
    # Twice as fine, with a node on every corner, edge and centre: the distance of a centre to
    # the nearest node of a square is that to the square.
    fine = np.zeros((2 * bordered.shape[0] + 1, 2 * bordered.shape[1] + 1), dtype=bool)
    for row, col in np.argwhere(bordered):
        fine[2 * row : 2 * row + 3, 2 * col : 2 * col + 3] = True
    distance = distance_transform_edt(~fine, sampling=0.5)[1::2, 1::2][1:-1, 1:-1]
    assert (_within(occupied, reach) == (distance < reach - 1e-9)).all()


def test_cells_of_a_map_are_squares():
    grid = np.zeros((30, 40), dtype=np.int8)
    cells = np.random.default_rng(5).integers([0, 0], [30, 40], size=(12, 2))
    grid[tuple(cells.T)] = 100
    area = OccupancyMap(grid, 0.1, (2.0, -1.0, 0.7))
    ground = DiscRegions(area, radius=0.25)
    squares = [Box(tuple(area.centers([cell])[0]), (0.1, 0.1), 0.7) for cell in cells]
    points = area.to_map(np.random.default_rng(6).uniform([0, 0], area.size, size=(50, 2)))
    local = area.to_local(points)
    border = np.minimum(local, np.array(area.size) - local).min(axis=1)
    expected = np.minimum(np.minimum(distance_to_shapes(squares, points), border), 0.5)
    found = np.minimum(ground.clearance(points, reach=0.5), 0.5)
    assert found == pytest.approx(expected, abs=1e-9)
    nodes = np.argwhere(ground.labels > 0)
    assert (ground.clearance(ground.nodes(nodes)) >= ground.need - 1e-9).all()
    others = np.argwhere(ground.labels == 0)
    assert (ground.clearance(ground.nodes(others)) < ground.need + 1e-9).all()


def test_shapes_stand_on_a_map_too():
    grid = np.zeros((60, 80), dtype=np.int8)
    grid[0, 0] = 100
    area = OccupancyMap(grid, 0.05)
    assert DiscRegions(area).connect([START], [GOAL])
    assert not DiscRegions(area, wall(0.4)).connect([START], [GOAL])
    assert DiscRegions(area, wall(0.75)).connect([START], [GOAL])


def test_unknown_counts_as_the_map_says():
    grid = np.zeros((60, 80), dtype=np.int8)
    grid[:, 40] = -1
    assert not DiscRegions(OccupancyMap(grid, 0.05)).connect([START], [GOAL])
    assert DiscRegions(OccupancyMap(grid, 0.05, unknown="free")).connect([START], [GOAL])
