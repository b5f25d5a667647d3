"""Clearances of the safety filter against slow, obvious geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.eikonal import surface_distance
from cavalcade.formation._certificate import map_slack
from cavalcade.formation._clearance import (
    DistanceMap,
    Footprint,
    distance_at,
    point_rectangle,
    rectangle,
    rectangle_gap,
)

poses = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-math.pi, math.pi))
sizes = st.tuples(st.floats(0.1, 1.0), st.floats(0.1, 1.0))


def gap(a, size_a, b, size_b):
    """The kernel, with whole lengths and widths."""
    return rectangle_gap(placed(a, size_a), placed(b, size_b))


def placed(pose, size):
    return rectangle(np.array(pose), np.array(size) / 2)


def support(pose, size, direction):
    """How far a rectangle reaches along directions `(N, 2)`."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    along = np.abs(direction @ (c, s)) * size[0] / 2 + np.abs(direction @ (-s, c)) * size[1] / 2
    return direction @ np.array(pose[:2]) + along


class TestRectangleGap:
    @settings(max_examples=150, deadline=None)
    @given(poses, sizes, poses, sizes)
    def test_sampling_finds_the_same(self, tools, a, size_a, b, size_b):
        found = gap(a, size_a, b, size_b)[0]
        sampled = tools.sampled_gap(np.array(a), np.array(b), size_a, size_b)
        if found > 1e-9:
            assert sampled == pytest.approx(found, abs=1e-9)
        else:
            # Samples may miss a sliver of an overlap.
            assert sampled <= 0.05

    @settings(max_examples=80, deadline=None)
    @given(poses, sizes, poses, sizes)
    def test_overlap_is_the_least_shift_that_parts_them(self, a, size_a, b, size_b):
        found, nx, ny, *_ = gap(a, size_a, b, size_b)
        if found > 0.0:
            return
        turn = np.linspace(0.0, 2.0 * np.pi, 721)
        ways = np.column_stack([np.cos(turn), np.sin(turn)])
        needed = support(b, size_b, ways) + support(a, size_a, -ways)
        assert -found <= needed.min() + 1e-9
        moved = (a[0] - found * nx, a[1] - found * ny, a[2])
        assert gap(moved, size_a, b, size_b)[0] == pytest.approx(0.0, abs=1e-9)

    @settings(max_examples=80, deadline=None)
    @given(poses, sizes, poses, sizes)
    def test_exchanging_them_turns_the_normal_round(self, a, size_a, b, size_b):
        one, other = gap(a, size_a, b, size_b), gap(b, size_b, a, size_a)
        assert one[0] == pytest.approx(other[0], abs=1e-12)
        if one[0] > 1e-6:
            assert one[1:3] == pytest.approx((-other[1], -other[2]), abs=1e-6)

    @settings(max_examples=80, deadline=None)
    @given(poses, sizes, poses, sizes, poses)
    def test_moving_the_frame_changes_nothing(self, a, size_a, b, size_b, frame):
        def seen(pose):
            c, s = math.cos(frame[2]), math.sin(frame[2])
            x, y = c * pose[0] - s * pose[1] + frame[0], s * pose[0] + c * pose[1] + frame[1]
            return (x, y, pose[2] + frame[2])

        here, there = gap(a, size_a, b, size_b), gap(seen(a), size_a, seen(b), size_b)
        assert here[0] == pytest.approx(there[0], abs=1e-9)

    @settings(max_examples=80, deadline=None)
    @given(poses, sizes, poses, sizes)
    def test_the_mirror_image_has_the_same_gap(self, a, size_a, b, size_b):
        flip = [(x, -y, -yaw) for x, y, yaw in (a, b)]
        here, there = gap(a, size_a, b, size_b), gap(flip[0], size_a, flip[1], size_b)
        assert here[0] == pytest.approx(there[0], abs=1e-9)

    @settings(max_examples=80, deadline=None)
    @given(poses, sizes, poses, sizes)
    def test_the_nearest_points_lie_on_the_bodies_and_span_the_gap(
        self, tools, a, size_a, b, size_b
    ):
        found, nx, ny, px, py, qx, qy = gap(a, size_a, b, size_b)
        assert math.hypot(nx, ny) == pytest.approx(1.0)
        if found < 1e-6:
            return
        p, q = np.array([[px, py]]), np.array([[qx, qy]])
        assert tools.distance_to_rectangle(p, np.array(a), *size_a)[0] < 1e-9
        assert tools.distance_to_rectangle(q, np.array(b), *size_b)[0] < 1e-9
        np.testing.assert_allclose(p[0] - q[0], found * np.array([nx, ny]), atol=1e-9)

    def test_the_trap_of_the_papers_limit(self):
        """Nose to tail at 0.60 m between centres two Go1 overlap by 5 cm."""
        go1 = (0.65, 0.28)
        assert gap((0.0, 0.0, 0.0), go1, (0.60, 0.0, 0.0), go1)[0] == pytest.approx(-0.05)
        assert gap((0.0, 0.0, 0.0), go1, (0.0, 0.60, 0.0), go1)[0] == pytest.approx(0.32)


@settings(max_examples=80, deadline=None)
@given(poses, sizes, st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)))
def test_point_to_rectangle(tools, pose, size, point):
    found, qx, qy = point_rectangle(*point, placed(pose, size))
    want = tools.distance_to_rectangle(np.array([point]), np.array(pose), *size)[0]
    assert found == pytest.approx(want, abs=1e-9)
    assert math.dist(point, (qx, qy)) == pytest.approx(want, abs=1e-9)


CELLS = (0.02, 0.05, 0.1, 0.25, 0.5)
"""Sizes of cells, m: fine maps, coarse ones of streets and games."""


def exact(occupied, cell, x, y):
    """Distance to the nearest occupied square or to the border, one by one."""
    rows, cols = occupied.shape
    best = min(x, y, cols * cell - x, rows * cell - y)
    for row, col in zip(*np.nonzero(occupied), strict=True):
        dx = max(col * cell - x, x - (col + 1) * cell, 0.0)
        dy = max(row * cell - y, y - (row + 1) * cell, 0.0)
        best = min(best, math.hypot(dx, dy))
    return best


class TestDistanceAt:
    CELL = 0.05

    @settings(max_examples=100, deadline=None)
    @given(st.integers(0, 2**32 - 1), st.sampled_from(CELLS), st.sampled_from([0.0, 0.01, 0.03]))
    def test_clearance_at_corners_of_coarse_cells_was_overestimated(self, seed, cell, share):
        rng = np.random.default_rng(seed)
        occupied = rng.random((24, 30)) < share
        distances = DistanceMap(surface_distance(occupied, cell), cell)
        for x, y in rng.uniform(0.0, (30 * cell, 24 * cell), (40, 2)):
            truth = exact(occupied, cell, x, y)
            found = distance_at(distances, x, y)[0]
            assert found <= truth + 1e-12
            # Interpolation cuts off the ridges between obstacles by up to half a cell or so,
            # where that is far off; near an obstacle nothing is given away.
            assert found >= truth - 0.75 * cell
            if truth < 1.5 * cell:
                assert found == pytest.approx(truth, abs=1e-12)

    @pytest.mark.parametrize("cell", CELLS)
    def test_at_cell_centres_it_is_exact(self, cell):
        occupied = np.zeros((20, 20), dtype=bool)
        occupied[7:9, 12] = True
        distances = DistanceMap(surface_distance(occupied, cell), cell)
        for row, col in np.ndindex(20, 20):
            x, y = (col + 0.5) * cell, (row + 0.5) * cell
            assert distance_at(distances, x, y)[0] == pytest.approx(exact(occupied, cell, x, y))

    @pytest.mark.parametrize("cell", CELLS)
    @pytest.mark.parametrize("cells", [2.99, 3.0, 3.01, 4.0, 7.5])
    def test_beside_a_post_it_never_promises_too_much(self, cell, cells):
        """All around one cell, near and far side of where interpolation begins."""
        occupied = np.zeros((40, 40), dtype=bool)
        occupied[20, 20] = True
        distances = DistanceMap(surface_distance(occupied, cell), cell)
        for turn in np.linspace(0.0, 2.0 * np.pi, 73):
            for corner in ((20.0, 20.0), (21.0, 21.0), (20.0, 21.0)):
                x = (corner[0] + cells * math.cos(turn)) * cell
                y = (corner[1] + cells * math.sin(turn)) * cell
                truth = exact(occupied, cell, x, y)
                found = distance_at(distances, x, y)[0]
                assert truth - 0.06 * cell <= found <= truth + 1e-12

    @pytest.mark.parametrize("cell", CELLS)
    def test_in_the_last_cell_before_an_obstacle_it_leads_straight_away(self, cell):
        occupied = np.zeros((12, 12), dtype=bool)
        occupied[5, 5] = True
        distances = DistanceMap(surface_distance(occupied, cell), cell)
        value, gx, gy = distance_at(distances, 6.3 * cell, 6.4 * cell)
        assert value == pytest.approx(0.5 * cell)
        assert (gx, gy) == pytest.approx((0.6, 0.8))

    def test_inside_an_obstacle_there_is_none(self):
        occupied = np.zeros((12, 12), dtype=bool)
        occupied[4:8, 4:8] = True
        distances = DistanceMap(surface_distance(occupied, 0.25), 0.25)
        assert distance_at(distances, 1.3, 1.6)[0] == 0.0


class TestBodiesOnCoarseCells:
    @settings(max_examples=60, deadline=None)
    @given(st.integers(0, 2**32 - 1), st.sampled_from(CELLS))
    def test_a_body_has_at_least_the_gap_that_the_filter_sees(self, tools, seed, cell):
        rng = np.random.default_rng(seed)
        middle = int(2.0 / cell)
        occupied = np.zeros((2 * middle + 1, 2 * middle + 1), dtype=bool)
        occupied[middle, middle] = True
        distances = DistanceMap(surface_distance(occupied, cell), cell)
        footprint = Footprint.of(0.65, 0.28, 5, 2)
        centre = (middle + 0.5) * cell
        square = placed((centre, centre, 0.0), (cell, cell))
        for _ in range(20):
            turn, yaw = rng.uniform(-np.pi, np.pi, 2)
            away = rng.uniform(0.1, 0.6) + 0.7 * cell
            pose = np.array([centre + away * np.cos(turn), centre + away * np.sin(turn), yaw])
            seen = map_slack(pose[None], footprint, 0.0, 0.0, distances)
            gap = rectangle_gap(rectangle(pose, footprint.half), square)[0]
            if seen >= 0.0:
                assert gap >= seen - 1e-12
            else:
                assert gap < 0.05  # its discs stick out beyond it by less than that


class TestGradients:
    CELL = 0.05

    def test_the_gradient_points_away_from_a_wall_at_unit_length(self):
        occupied = np.zeros((60, 60), dtype=bool)
        occupied[:, :10] = True
        distances = DistanceMap(surface_distance(occupied, self.CELL), self.CELL)
        value, gx, gy = distance_at(distances, 1.01, 1.53)
        assert 0.509 < value <= 0.51  # a post might stand before the wall where no centre sees it
        assert (gx, gy) == pytest.approx((1.0, 0.0))

    @pytest.mark.parametrize(
        ("point", "gradient"),
        [
            ((-0.1, 0.7), (1, 0)),
            ((1.6, 0.7), (-1, 0)),
            ((0.7, -0.1), (0, 1)),
            ((0.7, 1.6), (0, -1)),
        ],
    )
    def test_beyond_the_border_it_is_negative_and_leads_back(self, point, gradient):
        empty = np.zeros((30, 30), dtype=bool)
        distances = DistanceMap(surface_distance(empty, self.CELL), self.CELL)
        value, gx, gy = distance_at(distances, *point)
        assert value == pytest.approx(-0.1)
        assert (gx, gy) == gradient
