"""Whatever comes in, the answer is a value or an InputError."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cavalcade.eikonal import TravelGrid, arrival_times
from cavalcade.errors import InputError

ANY_ARRAY = hnp.arrays(
    st.sampled_from([np.float64, np.float32, np.int8, np.bool_, np.complex128]),
    hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=5),
)
ANY_NUMBER = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=150, deadline=None)
@given(speed=ANY_ARRAY, cell=ANY_NUMBER)
@pytest.mark.filterwarnings("ignore::numpy.exceptions.ComplexWarning")
def test_malformed_speeds_and_cells(speed, cell):
    try:
        times = arrival_times(speed, [(0, 0)], cell)
    except InputError:
        return
    assert times.shape == speed.shape
    assert not np.isnan(times).any()
    assert (times >= 0.0).all()


@settings(max_examples=150, deadline=None)
@given(
    speed=hnp.arrays(
        np.float64,
        hnp.array_shapes(min_dims=2, max_dims=2, max_side=7),
        elements=st.one_of(st.just(0.0), st.floats(1e-3, 1e6)),
    ),
    start=st.tuples(ANY_NUMBER, ANY_NUMBER),
    goal=st.tuples(st.floats(-0.1, 0.5), st.floats(-0.1, 0.5)),
)
def test_any_start_and_goal(speed, start, goal):
    grid = TravelGrid(speed, 0.05)
    field = grid.field(goal)
    assert not np.isnan(field.times).any()
    try:
        points, stamps = field.path(start)
        local, eta = grid.local_path(start, goal)
    except InputError:
        assert not np.isfinite(start).all()
        return
    assert np.isfinite(points).all()
    assert np.isfinite(stamps).all()
    assert np.isfinite(local).all()
    assert (len(points) > 0) == (field.eta(start) < np.inf) == (len(local) > 0) == (eta < np.inf)


@settings(max_examples=60, deadline=None)
@given(
    speed=hnp.arrays(np.bool_, (6, 6)),
    source=st.tuples(st.integers(0, 5), st.integers(0, 5)),
)
def test_reached_is_what_four_neighbours_connect(speed, source):
    from scipy.ndimage import label

    parts, _ = label(speed)
    times = arrival_times(speed, [source], 1.0)
    expected = (parts == parts[source]) & speed
    expected[source] = True
    np.testing.assert_array_equal(np.isfinite(times), expected)


@pytest.mark.parametrize(
    "speed",
    [
        [1.0, 2.0],
        np.ones((2, 2, 2)),
        np.empty((0, 3)),
        [[1.0, np.nan]],
        [[1.0, np.inf]],
        [[-1e-9, 1.0]],
        [["fast", "slow"]],
        [[1.0], [1.0, 2.0]],
        None,
    ],
)
def test_malformed_speeds_name_the_key(speed):
    with pytest.raises(InputError, match="speed"):
        TravelGrid(speed, 0.05)


@pytest.mark.parametrize("cell", [0.0, -0.05, np.nan, np.inf, "wide", None])
def test_malformed_cells_name_the_key(cell):
    with pytest.raises(InputError, match="cell"):
        TravelGrid(np.ones((3, 3)), cell)


@pytest.mark.parametrize("point", [(np.nan, 0.0), (np.inf, 0.0), (1.0,), (1.0, 2.0, 3.0), "ab"])
def test_malformed_points_name_the_key(point):
    grid = TravelGrid(np.ones((3, 3)), 0.05)
    for call in (grid.field, grid.is_free, grid.nearest_free, grid.field((0.1, 0.1)).path):
        with pytest.raises(InputError, match="point"):
            call(point)


def test_minus_zero_is_zero():
    assert np.isinf(arrival_times(np.array([[1.0, -0.0, 1.0]]), [(0, 0)], 1.0)[0, 1:]).all()
