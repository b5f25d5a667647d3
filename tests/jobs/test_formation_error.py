from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cavalcade.geometry import rotation
from cavalcade.metrics.run_summary import placement_errors

SQUARE = np.array([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)])
ALL = np.ones((1, 4), dtype=bool)


@settings(max_examples=50, deadline=None)
@given(st.floats(-np.pi, np.pi), st.floats(-50, 50), st.floats(-50, 50))
def test_any_rigid_placement_is_perfect(yaw: float, x: float, y: float) -> None:
    placed = SQUARE @ rotation(yaw).T + (x, y)
    assert placement_errors(placed[None], SQUARE[None], ALL).max() < 1e-9


@settings(max_examples=50, deadline=None)
@given(
    arrays(float, (4, 2), elements=st.floats(-5, 5)),
    st.floats(-np.pi, np.pi),
    st.floats(-1, 1),
    st.floats(-1, 1),
)
def test_no_other_placement_is_better(
    positions: np.ndarray, yaw: float, x: float, y: float
) -> None:
    best = (placement_errors(positions[None], SQUARE[None], ALL) ** 2).sum()
    other = SQUARE @ rotation(yaw).T + positions.mean(axis=0) + (x, y)
    assert best <= ((positions - other) ** 2).sum() + 1e-9


def test_size_and_mirror_image_are_errors() -> None:
    larger = placement_errors(2.0 * SQUARE[None], SQUARE[None], ALL)
    assert larger == pytest.approx(np.full((1, 4), np.sqrt(0.5)))
    kite = np.array([(2.0, 0.0), (0.0, 1.0), (-0.5, 0.0), (0.0, -0.2)])
    assert placement_errors((kite * (1, -1))[None], kite[None], ALL).max() > 0.1


def test_the_assignment_counts() -> None:
    exchanged = SQUARE[[1, 0, 2, 3]]
    assert placement_errors(exchanged[None], SQUARE[None], ALL).max() > 0.4


def test_robots_without_a_slot_are_left_out() -> None:
    positions = SQUARE.copy()
    positions[2] = (40.0, 40.0)
    part = np.array([[True, True, False, True]])
    errors = placement_errors(positions[None], SQUARE[None], part)
    assert errors.max() < 1e-9
    alone = np.array([[True, False, False, False]])
    assert placement_errors(positions[None], SQUARE[None], alone).max() == 0.0
    nobody = np.zeros((1, 4), dtype=bool)
    assert placement_errors(positions[None], SQUARE[None], nobody).max() == 0.0


def test_one_displaced_robot() -> None:
    line = np.array([(0.0, 0.0), (1.0, 0.0)])
    apart = np.array([(0.0, 0.0), (1.2, 0.0)])
    both = np.ones((1, 2), dtype=bool)
    assert placement_errors(apart[None], line[None], both) == pytest.approx(np.full((1, 2), 0.1))
