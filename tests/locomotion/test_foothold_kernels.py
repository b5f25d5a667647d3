"""The compiled kernels against slow, obvious implementations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from cavalcade.locomotion import _footholds
from cavalcade.locomotion.records import Footing

CELL = 0.05


@pytest.fixture
def field():
    rng = np.random.default_rng(3)
    shape = (30, 40)
    return rng.random(shape) < 0.3, rng.random(shape), rng.random(shape)


def nearest_slowly(x, y, solid, traversability, reach):
    """All cells, sorted by the distance of their centres."""
    rows, cols = solid.shape
    row, col = int(np.floor(y / CELL)), int(np.floor(x / CELL))
    inside = 0 <= row < rows and 0 <= col < cols
    if inside and not solid[row, col] and traversability[row, col] >= 0.3:
        return x, y, True
    options = []
    for r in range(rows):
        for c in range(cols):
            mx, my = (c + 0.5) * CELL, (r + 0.5) * CELL
            away = (mx - x) ** 2 + (my - y) ** 2
            if not solid[r, c] and traversability[r, c] >= 0.3 and away < reach**2:
                options.append((away, r, c))
    if not options:
        return x, y, False
    _, r, c = min(options)
    return (c + 0.5) * CELL, (r + 0.5) * CELL, True


def test_nearest_place(field):
    solid, traversability, height = field
    footing = Footing(CELL, solid, False, height, traversability, np.zeros(3))
    rng = np.random.default_rng(0)
    for x, y in rng.uniform((-0.2, -0.2), (2.2, 1.7), (300, 2)):
        found = _footholds.nearest_place(x, y, footing, 0.3, 0.12)
        assert found == pytest.approx(nearest_slowly(x, y, solid, traversability, 0.12))


def test_interpolate(field):
    *_, height = field
    y, x = ((np.arange(n) + 0.5) * CELL for n in height.shape)
    slow = RegularGridInterpolator((y, x), height)
    rng = np.random.default_rng(1)
    for px, py in rng.uniform((-0.1, -0.1), (2.1, 1.6), (200, 2)):
        inside = (np.clip(py, y[0], y[-1]), np.clip(px, x[0], x[-1]))
        assert _footholds.interpolate(px, py, CELL, height) == pytest.approx(slow(inside).item())


def test_leg_lengths():
    rng = np.random.default_rng(2)
    times = np.arange(0.0, 3.0, 0.03)
    hips = rng.random((len(times), 4, 3))
    needed = rng.random((len(times), 4)) < 0.8
    down = rng.uniform(0.0, 2.0, 20)
    up = down + rng.uniform(0.0, 0.5, 20)
    feet = np.column_stack([rng.integers(0, 4, 20), rng.random((20, 3))])
    found = _footholds.leg_lengths(_footholds.Stances(times, hips, needed, down, up, feet))
    for m in range(20):
        leg = int(feet[m, 0])
        inside = (times >= down[m]) & (times <= up[m]) & needed[:, leg]
        away = np.linalg.norm(hips[inside, leg] - feet[m, 1:], axis=1)
        assert found[m] == pytest.approx(away.max(initial=0.0))
