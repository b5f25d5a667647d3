"""Breaks of the ground as the checker finds them, and leaps that are told to be made."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.checking.ground import Floor
from cavalcade.checking.heights import Heights, floor_of
from cavalcade.checking.physics.leaps import find_leap
from cavalcade.geometry import transform_points


def ground(first: float, width: float, depth: float, rise: float, origin: Any) -> Floor:
    """Level up to `first` m along x, then a pit, then level again, on a turned grid of 2 cm."""
    x = (np.arange(300) + 0.5) * 0.02
    row = np.where(x < first, 0.0, np.where(x < first + width, -depth, rise))
    heights = Heights(np.tile(row, (200, 1)), 0.02, origin)
    return floor_of(heights, transform_points(origin, np.array([[0.5, 0.5], [5.5, 3.5]])))


@settings(max_examples=40, deadline=None)
@given(
    width=st.floats(0.1, 0.6),
    rise=st.floats(-0.2, 0.2),
    yaw=st.floats(-math.pi, math.pi),
    askew=st.floats(-0.4, 0.4),
)
def test_the_far_edge_is_found_however_the_way_lies(
    width: float, rise: float, yaw: float, askew: float
) -> None:
    origin = (1.0, -2.0, yaw)
    there = ground(2.5, width, 1.0, rise, origin)
    start = np.array([1.8, 2.0])
    end = start + (width + 1.6) * np.array([math.cos(askew), math.sin(askew)])
    way = transform_points(origin, np.stack([start, end]))
    leap = find_leap(there, way[0], way[1], 0.5)
    assert leap is not None
    # Feet on both sides of the edge, which is a cell wide.
    for off, past in ((-0.03, False), (0.05, True)):
        for y in (1.85, 2.0, 2.15):
            place = transform_points(origin, np.array([[2.5 + width + off, y]]))
            assert (leap.past(place)[0] > 0.0) == past
    assert leap.before == pytest.approx(0.0, abs=1e-9)
    assert leap.beyond == pytest.approx(rise, abs=1e-9)
    assert leap.begin == 0.5


@pytest.mark.parametrize("height", [0.1, 0.2, -0.2])
def test_a_step_breaks_once(height: float) -> None:
    there = ground(3.0, 0.0, 0.0, height, (0.0, 0.0, 0.0))
    leap = find_leap(there, np.array([2.0, 2.0]), np.array([4.0, 2.0]), 0.0)
    assert leap is not None
    assert leap.edge[0] == pytest.approx(3.0, abs=0.025)
    assert leap.heading == pytest.approx(0.0, abs=1e-6)
    assert leap.beyond == height


def test_level_ground_and_short_ways_do_not_break() -> None:
    there = ground(3.0, 0.0, 0.0, 0.03, (0.0, 0.0, 0.0))
    assert find_leap(there, np.array([2.0, 2.0]), np.array([4.0, 2.0]), 0.0) is None
    assert find_leap(there, np.array([2.0, 2.0]), np.array([2.1, 2.0]), 0.0) is None
