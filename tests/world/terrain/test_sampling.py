"""Bilinear values between cells' centres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator

from cavalcade.world.terrain.samples import block_means, resample
from cavalcade.world.terrain.terrain import sample

_COORDINATE = st.floats(-3.0, 5.0)


@given(st.integers(0, 2**32 - 1), st.integers(2, 6), st.integers(2, 6), _COORDINATE, _COORDINATE)
@settings(deadline=None, max_examples=60)
def test_values_are_those_of_another_implementation(
    seed: int, rows: int, cols: int, x: float, y: float
) -> None:
    field, cell = np.random.default_rng(seed).uniform(size=(rows, cols)), 0.3
    centers = [(np.arange(n) + 0.5) * cell for n in (rows, cols)]
    inside = [np.clip(v, c[0], c[-1]) for v, c in zip((y, x), centers, strict=True)]
    expected = RegularGridInterpolator(centers, field)(inside)[0]
    assert sample(field, cell, x, y) == pytest.approx(expected, abs=1e-12)


def test_one_cell_is_the_same_everywhere() -> None:
    assert sample(np.array([[3.0]]), 0.1, 7.0, -2.0) == 3.0
    assert sample(np.array([[1.0, 2.0]]), 1.0, 1.0, 9.0) == pytest.approx(1.5)


def test_at_centres_values_are_exact() -> None:
    field = np.random.default_rng(0).uniform(size=(4, 5))
    for row in range(4):
        for col in range(5):
            assert sample(field, 0.05, (col + 0.5) * 0.05, (row + 0.5) * 0.05) == pytest.approx(
                field[row, col], abs=1e-12
            )


def test_a_plane_stays_one_on_another_grid() -> None:
    y, x = np.indices((7, 9)) * 0.2
    out = np.empty((20, 28))
    resample(2.0 * x - y + 1.0, 0.2, out, 0.05, 0.1, 0.05)
    rows, cols = np.indices(out.shape)
    there = 2.0 * (0.1 + (cols + 0.5) * 0.05) - (0.05 + (rows + 0.5) * 0.05) + 1.0
    assert out == pytest.approx(there)


def test_means_of_blocks() -> None:
    field = np.random.default_rng(0).uniform(size=(7, 8))
    assert block_means(field, 3) == pytest.approx(
        field[:6, :6].reshape(2, 3, 2, 3).mean(axis=(1, 3))
    )
