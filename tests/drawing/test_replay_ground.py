from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cavalcade.drawing.replay import ground


def area(ring: np.ndarray) -> float:
    x, y = ring.T
    return 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


@given(st.lists(st.floats(0.2, 2.0), min_size=3, max_size=25))
def test_triangles_fill_a_star_shaped_outline(radii):
    angles = np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
    ring = np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    found = ground.triangulate(ring)
    assert found.shape == (len(ring) - 2, 3)
    areas = [area(ring[triangle]) for triangle in found]
    assert min(areas) >= -1e-9
    assert sum(areas) == pytest.approx(area(ring))


def test_an_outline_is_turned_the_right_way():
    square = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    assert area(square) < 0.0 < area(ground.counter_clockwise(square))
    assert area(ground.counter_clockwise(square[::-1])) > 0.0


@given(hnp.arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_rectangles_cover_exactly_the_true_cells(mask):
    found, factor = ground.rectangles(mask)
    assert factor == 1
    covered = np.zeros(mask.shape, dtype=int)
    for r0, c0, r1, c1 in found:
        covered[r0:r1, c0:c1] += 1
    np.testing.assert_array_equal(covered, mask.astype(int))


def test_a_very_ragged_grid_is_joined():
    mask = np.random.default_rng(0).random((301, 300)) < 0.5
    found, factor = ground.rectangles(mask)
    assert factor > 1
    assert len(found) <= 3000
    covered = np.zeros(mask.shape, dtype=bool)
    for r0, c0, r1, c1 in found * factor:
        covered[r0:r1, c0:c1] = True
    assert covered[mask].all()
