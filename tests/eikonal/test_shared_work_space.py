from __future__ import annotations

import numpy as np

from cavalcade.eikonal import TravelGrid

CELL = 0.1


def speeds(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.2, 1.0, (30, 40))
    speed[rng.random((30, 40)) < 0.1] = 0.0
    speed[2:4, 2:4] = speed[-4:-2, -4:-2] = 1.0
    return speed


def test_grids_that_share_work_space_march_as_if_alone() -> None:
    start, goal = (0.3, 0.3), (3.7, 2.7)
    alone = [TravelGrid(speeds(seed), CELL) for seed in (0, 1)]
    first = TravelGrid(speeds(0), CELL)
    shared = [first, TravelGrid(speeds(1), CELL, beside=first)]
    for _ in range(2):
        for one, other in zip(alone, shared, strict=True):
            np.testing.assert_array_equal(one.field([start]).times, other.field([start]).times)
            way, eta = one.local_path(start, goal)
            other_way, other_eta = other.local_path(start, goal)
            np.testing.assert_array_equal(way, other_way)
            assert eta == other_eta


def test_a_grid_of_another_size_gets_its_own() -> None:
    first = TravelGrid(np.ones((5, 5)), CELL)
    larger = TravelGrid(np.ones((50, 50)), CELL, beside=first)
    assert np.isfinite(larger.field([(0.05, 0.05)]).times).all()


def test_a_field_says_which_cells_it_reaches() -> None:
    speed = np.ones((10, 10))
    speed[:, 5] = 0.0
    field = TravelGrid(speed, CELL).field([(0.05, 0.05)])
    assert field.reaches([(0, 0), (9, 4)])
    assert not field.reaches([(0, 0), (9, 6)])
    assert field.reaches([])
