from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.drawing.outlines import cell_rings, shape_ring, simplified
from cavalcade.world import Box, Circle, Polygon


def area(ring):
    x, y = ring.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_a_block_of_cells_has_its_own_edges():
    mask = np.zeros((10, 12), dtype=bool)
    mask[2:5, 3:9] = True
    (ring,) = cell_rings(mask, 0.1, (0.0, 0.0, 0.0))
    assert ring.min(axis=0) == pytest.approx([0.3, 0.2])
    assert ring.max(axis=0) == pytest.approx([0.9, 0.5])
    # Four corners are cut by a quarter of a cell.
    assert area(ring) == pytest.approx(0.18 - 4 * 0.5 * 0.025**2)
    assert len(ring) == 8


def test_holes_run_the_other_way_and_the_origin_turns_the_grid():
    mask = np.ones((9, 9), dtype=bool)
    mask[4, 4] = False
    outer, hole = sorted(cell_rings(mask, 1.0, (5.0, 6.0, np.pi / 2)), key=len, reverse=True)
    if area(outer) < area(hole):
        outer, hole = hole, outer
    assert area(outer) > 0.0 > area(hole)
    assert outer.min(axis=0) == pytest.approx([-4.0, 6.0])
    assert outer.max(axis=0) == pytest.approx([5.0, 15.0])
    assert hole.mean(axis=0) == pytest.approx([0.5, 10.5])


def test_no_cells_no_rings():
    assert cell_rings(np.zeros((4, 4), dtype=bool), 0.1, (0.0, 0.0, 0.0)) == []


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        (Box((1.0, 2.0), (0.4, 0.2), 0.7), 0.08),
        (Circle((1.0, 2.0), 0.5), np.pi * 0.25),
        (Polygon(((0.0, 0.0), (2.0, 0.0), (0.0, 1.0))), 1.0),
    ],
)
def test_shapes_keep_their_area(shape, expected):
    assert abs(area(shape_ring(shape))) == pytest.approx(expected, rel=0.003)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=1, max_size=40),
    st.floats(0.001, 1.0),
)
def test_simplified_lines_keep_their_ends_and_stay_within_the_tolerance(points, tolerance):
    line = np.array(points)
    thin = simplified(line, tolerance)
    assert (thin[0] == line[0]).all()
    assert (thin[-1] == line[-1]).all()
    assert len(thin) <= len(line)
    for point in line:
        assert _distance_to(thin, point) <= tolerance + 1e-9


def _distance_to(line, point):
    if len(line) == 1:
        return float(np.hypot(*(point - line[0])))
    best = np.inf
    for a, b in pairwise(line):
        span = float((b - a) @ (b - a))
        part = np.clip(((point - a) @ (b - a)) / span, 0.0, 1.0) if span > 0.0 else 0.0
        best = min(best, float(np.hypot(*(a + part * (b - a) - point))))
    return best
