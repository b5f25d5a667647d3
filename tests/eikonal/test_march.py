"""Arrival times: the slow reference, laws, exact answers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cavalcade.eikonal import TravelGrid, arrival_times
from cavalcade.eikonal._march import work_space
from cavalcade.errors import InputError

CELL = 0.05
NEAR = 12  # cells around a source that may have straight-line times


def a_free_cell(speed, seed):
    rng = np.random.default_rng(seed)
    return tuple(int(k) for k in rng.choice(np.argwhere(speed > 0.0)))


def seeds_of(times, source, radius):
    """The cells near a source with their times."""
    r, c = np.indices(times.shape)
    near = np.hypot(r - source[0], c - source[1]) <= radius
    return {tuple(k): times[tuple(k)] for k in np.argwhere(near & np.isfinite(times))}


@pytest.mark.parametrize("seed", range(6))
def test_equals_the_slow_march_from_the_same_seeds(slow_march, clutter, seed):
    speed = clutter(41, 57, seed)
    source = a_free_cell(speed, seed)
    times = arrival_times(speed, [source], CELL)
    slow = slow_march(speed, seeds_of(times, source, NEAR), CELL)
    np.testing.assert_array_equal(np.isfinite(times), np.isfinite(slow))
    np.testing.assert_allclose(times, slow, rtol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_front_of_many_cells_equals_the_slow_march(slow_march, clutter, seed):
    speed = clutter(60, 80, seed)
    front = [(r, c) for r, c in np.argwhere(speed > 0.0) if r < 2]
    assert len(front) > 64
    # Straight lines between neighbours are all that these seeds add to the sources.
    times = arrival_times(speed, front, CELL)
    slow = slow_march(speed, dict.fromkeys(front, 0.0), CELL)
    np.testing.assert_array_equal(np.isfinite(times), np.isfinite(slow))
    finite = np.isfinite(slow)
    np.testing.assert_allclose(times[finite], slow[finite], rtol=1e-9, atol=1e-12)


def test_rough_speeds_equal_the_slow_march(slow_march):
    rng = np.random.default_rng(1)
    speed = 10.0 ** rng.uniform(-3.0, 2.0, (30, 30))
    speed[rng.random(speed.shape) < 0.2] = 0.0
    speed[15, 15] = 1.0
    times = arrival_times(speed, [(15, 15)], CELL)
    slow = slow_march(speed, seeds_of(times, (15, 15), NEAR), CELL)
    np.testing.assert_array_equal(np.isfinite(times), np.isfinite(slow))
    np.testing.assert_allclose(times, slow, rtol=1e-9)


def test_is_a_fixed_point_of_the_scheme(upwind, clutter):
    speed = clutter(40, 40, 3)
    source = a_free_cell(speed, 3)
    times = arrival_times(speed, [source], CELL)
    delay = np.divide(CELL, speed, out=np.full(speed.shape, np.inf), where=speed > 0.0)
    for r, c in np.argwhere(np.isfinite(times)):
        scheme = upwind(times, delay, r, c)
        assert times[r, c] <= scheme * (1.0 + 1e-9)
        if np.hypot(r - source[0], c - source[1]) > NEAR:
            assert times[r, c] == pytest.approx(scheme, rel=1e-9)


@pytest.mark.parametrize(
    "turn", [np.flipud, np.fliplr, np.transpose, np.rot90], ids=lambda f: f.__name__
)
def test_a_turned_map_gives_turned_times(clutter, turn):
    speed = clutter(33, 48, 5)
    source = a_free_cell(speed, 5)
    mark = np.zeros(speed.shape)
    mark[source] = 1.0
    turned = tuple(int(k) for k in np.argwhere(turn(mark) > 0.0)[0])
    expected = turn(arrival_times(speed, [source], CELL))
    np.testing.assert_allclose(arrival_times(turn(speed), [turned], CELL), expected, rtol=1e-9)


def test_triangle_inequality(clutter):
    speed = clutter(40, 40, 8)
    a, b = a_free_cell(speed, 1), a_free_cell(speed, 2)
    from_a, from_b = arrival_times(speed, [a], CELL), arrival_times(speed, [b], CELL)
    # Up to the first-order error, which is a share of a cell for each turn of the front.
    slack = 0.06 * from_a + 2.0 * CELL / np.maximum(speed, 0.02)
    reached = np.isfinite(from_a) & np.isfinite(from_b)
    assert (from_a <= from_a[b] + from_b + slack)[reached].all()


def test_symmetric_between_two_cells(clutter):
    speed = clutter(40, 40, 9)
    a, b = a_free_cell(speed, 4), a_free_cell(speed, 5)
    there, back = arrival_times(speed, [a], CELL)[b], arrival_times(speed, [b], CELL)[a]
    assert there == pytest.approx(back, rel=0.2)  # up to the first-order error


@pytest.mark.parametrize("seed", range(4))
def test_an_obstacle_never_brings_anything_forward(seed):
    rng = np.random.default_rng(seed)
    speed = np.ones((40, 40))
    source = (20, 3)
    before = arrival_times(speed, [source], CELL)
    for _ in range(4):
        r, c = rng.integers(0, 40), rng.integers(6, 40)
        speed[r : r + 8, c : c + 3] = 0.0
        after = arrival_times(speed, [source], CELL)
        assert (after >= before - 1e-9).all()
        before = after


def test_several_sources_in_any_order(clutter):
    speed = clutter(50, 50, 2)
    sources = [a_free_cell(speed, k) for k in range(5)]
    one_way = arrival_times(speed, sources, CELL)
    np.testing.assert_allclose(arrival_times(speed, sources[::-1], CELL), one_way, rtol=1e-9)
    alone = np.min([arrival_times(speed, [s], CELL) for s in sources], axis=0)
    # Only where two fronts meet does the scheme mix them, which brings times forward.
    assert (one_way <= alone + 1e-9).all()
    np.testing.assert_allclose(one_way, alone, rtol=0.2)


def test_bit_identical_when_repeated(clutter):
    speed = clutter(60, 60, 4)
    source = a_free_cell(speed, 4)
    first = arrival_times(speed, [source], CELL)
    assert first.tobytes() == arrival_times(speed, [source], CELL).tobytes()
    grid = TravelGrid(speed, CELL)
    for _ in range(3):  # work space that was used before changes nothing
        assert first.tobytes() == grid.from_cells([source]).tobytes()


@pytest.mark.parametrize("factor", [1e-3, 1e6])
def test_scales_with_cell_and_speed(clutter, factor):
    speed = clutter(40, 40, 6)
    source = a_free_cell(speed, 6)
    times = arrival_times(speed, [source], CELL)
    scaled = arrival_times(speed, [source], CELL * factor)
    np.testing.assert_allclose(scaled, times * factor, rtol=1e-9)
    faster = arrival_times(speed * factor, [source], CELL)
    np.testing.assert_allclose(faster, times / factor, rtol=1e-9)


def test_speeds_over_nine_decades(slow_march):
    rng = np.random.default_rng(0)
    speed = 10.0 ** rng.uniform(-3.0, 6.0, (60, 60))
    times = arrival_times(speed, [(30, 30)], CELL)
    slow = slow_march(speed, seeds_of(times, (30, 30), NEAR), CELL)
    np.testing.assert_allclose(times, slow, rtol=1e-9)


def test_a_fast_cell_does_not_slow_down_a_large_map():
    speed = np.full((400, 400), 1e-3)
    speed[0, 0] = 1e6
    times = arrival_times(speed, [(200, 200)], CELL)
    even = arrival_times(np.full((400, 400), 1e-3), [(200, 200)], CELL)
    np.testing.assert_allclose(times[1:, 1:], even[1:, 1:], rtol=1e-9)


def exact_problems(n):
    h = CELL
    y, x = np.mgrid[:n, :n] * h
    middle = n // 2
    away = np.hypot(x - middle * h, y - middle * h)
    slope = 0.8 / x.max()
    linear = 0.2 + slope * x
    rays = np.arccosh(1.0 + (slope * away) ** 2 / (2.0 * linear * linear[middle, middle])) / slope
    return {"constant": (np.ones((n, n)), away), "linear": (linear, rays)}


@pytest.mark.parametrize("n", [101, 301])
@pytest.mark.parametrize("problem", ["constant", "linear"])
def test_error_no_worse_than_scikit_fmm(n, problem):
    skfmm = pytest.importorskip("skfmm")
    speed, exact = exact_problems(n)[problem]
    source = (n // 2, n // 2)
    yy, xx = np.indices((n, n)) - n // 2
    marked = np.ones((n, n))
    marked[source] = 0.0
    for phi in (marked, CELL * np.hypot(yy, xx) - 1e-9):  # the latter tells it exact distances
        theirs = np.abs(skfmm.travel_time(phi, speed, dx=CELL, order=1) - exact)
        ours = np.abs(arrival_times(speed, [source], CELL) - exact)
        assert ours.max() <= theirs.max()
        assert ours.mean() <= theirs.mean()


def test_error_falls_with_the_cell_size():
    errors = []
    for n in (101, 201, 401, 801):
        cell = 10.0 / (n - 1)
        y, x = np.mgrid[:n, :n] * cell - 5.0
        times = arrival_times(np.ones((n, n)), [(n // 2, n // 2)], cell)
        errors.append(np.abs(times - np.hypot(x, y)).max())
    assert all(b < 0.72 * a for a, b in pairwise(errors))


def test_unreachable_is_inf():
    speed = np.ones((20, 30))
    speed[:, 15] = 0.0
    times = arrival_times(speed, [(10, 4)], CELL)
    assert np.isfinite(times[:, :15]).all()
    assert np.isinf(times[:, 15:]).all()


def test_two_blocked_cells_that_touch_at_a_corner_close_the_way():
    speed = np.ones((8, 8))
    for k in range(8):
        speed[k, 7 - k] = 0.0
    times = arrival_times(speed, [(2, 2)], CELL)
    r, c = np.indices(speed.shape)
    assert np.isfinite(times[r + c < 7]).all()
    assert np.isinf(times[r + c >= 7]).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1), (2, 2), (3, 3)])
def test_tiny_maps_and_their_borders(shape):
    for source in {(0, 0), (shape[0] - 1, shape[1] - 1), (0, shape[1] - 1)}:
        times = arrival_times(np.ones(shape), [source], 1.0)
        r, c = np.indices(shape)
        straight = np.hypot(r - source[0], c - source[1])
        assert (np.abs(times - straight) <= 0.1 * straight + 1e-9).all()


def test_a_blocked_source_is_zero_and_starts_nothing():
    speed = np.ones((9, 9))
    speed[4, 4] = 0.0
    times = arrival_times(speed, [(4, 4)], CELL)
    assert times[4, 4] == 0.0
    assert np.isinf(times).sum() == 80
    assert np.isfinite(arrival_times(speed, [(4, 4), (0, 0)], CELL)).all()


def test_a_map_without_free_cells_and_no_sources():
    assert np.isinf(arrival_times(np.zeros((5, 5)), [], CELL)).all()
    assert np.isinf(arrival_times(np.ones((5, 5)), [], CELL)).all()
    assert np.isinf(arrival_times(np.zeros((5, 5)), [(1, 1)], CELL)).sum() == 24


@pytest.mark.parametrize("seed", range(4))
def test_stopping_early_changes_no_value_at_the_targets(clutter, seed):
    speed = clutter(120, 120, seed, blocks=40)
    source = a_free_cell(speed, seed)
    targets = [a_free_cell(speed, 10 + k) for k in range(3)]
    full = arrival_times(speed, [source], CELL)
    early = arrival_times(speed, [source], CELL, targets)
    for target in targets:
        assert early[target] == pytest.approx(full[target], rel=1e-9)
    assert (early >= full * (1.0 - 1e-9)).all()


def test_stopping_early_leaves_the_rest_out_and_the_work_space_clean():
    grid = TravelGrid(np.ones((200, 200)), CELL)
    full = grid.from_cells([(100, 100)])
    early = grid.from_cells([(100, 100)], [(100, 120)])
    assert np.isfinite(early).mean() < 0.2
    assert grid.from_cells([(100, 100)]).tobytes() == full.tobytes()


def test_work_space_grows_where_it_does_not_suffice(clutter, monkeypatch):
    speed = clutter(80, 80, 7)
    source, other = a_free_cell(speed, 7), a_free_cell(speed, 3)
    points = [(np.array(k[::-1]) + 0.5) * CELL for k in (source, other)]
    expected = arrival_times(speed, [source], CELL)
    expected_path, expected_eta = TravelGrid(speed, CELL).local_path(*points)
    made = []

    def tight(size, nodes=0):
        made.append(nodes)
        work = work_space(size, nodes)
        if nodes:
            return work
        return work._replace(cells=work.cells[:8], links=work.links[:8], spares=work.spares[:8])

    monkeypatch.setattr("cavalcade.eikonal._march.work_space", tight)
    np.testing.assert_array_equal(TravelGrid(speed, CELL).from_cells([source]), expected)
    assert made == [0, 32]
    path, eta = TravelGrid(speed, CELL).local_path(*points)
    np.testing.assert_array_equal(path, expected_path)
    assert eta == expected_eta
    assert made == [0, 32, 0, 32]


def test_blocked_targets_are_not_waited_for():
    speed = np.ones((100, 100))
    speed[0, 0] = 0.0
    assert np.isfinite(arrival_times(speed, [(50, 50)], CELL, [(0, 0), (50, 52)])).mean() < 0.5


@pytest.mark.parametrize("key", ["sources", "targets"])
@pytest.mark.parametrize(
    "cells", [[(-1, 0)], [(0, 5)], [(4, 0)], [(0.5, 1)], [(1, 2, 3)], [("a", "b")], [(np.nan, 0)]]
)
def test_cells_outside_the_grid_are_refused(key, cells):
    arguments = {"sources": [(0, 0)], "targets": None} | {key: cells}
    with pytest.raises(InputError, match=key):
        arrival_times(np.ones((4, 5)), cell=CELL, **arguments)
