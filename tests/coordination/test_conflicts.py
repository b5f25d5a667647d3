"""Conflicts of tracks against brute force every millisecond."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cavalcade.coordination.conflicts import MARGIN, Conflict, conflicts_of, stacked
from cavalcade.geometry import Array
from cavalcade.lattice.planner import MARGINS
from cavalcade.robots import MODELS, RobotModel, robot_model

STEP = 0.05
LOOK = 0.01
Gap = Callable[..., Array]


def _random_tracks(rng: np.random.Generator, count: int) -> list[Array]:
    """Walks of up to 0.75 m/s and 1.2 rad/s, smooth enough to meet and part again."""
    out = []
    for _ in range(count):
        length = int(rng.integers(1, 80))
        ways = rng.uniform(-1, 1, (length // 10 + 1, 3)).repeat(10, axis=0)[:length]
        steps = ways * (0.026, 0.026, 0.06)
        out.append((*rng.uniform(0, 2.5, 2), rng.uniform(-3, 3)) + np.cumsum(steps, axis=0))
    return out


def _brute(
    gap: Gap, tracks: list[Array], models: list[RobotModel], margin: float, distance: float | None
) -> dict[tuple[int, int], list[tuple[float, float]]]:
    """By pair, from when to when two are nearer than the margin."""
    last = (max(map(len, tracks)) - 1) * STEP
    time = np.arange(0.0, last + 0.5, 0.001)
    fine = [
        np.stack([np.interp(time, np.arange(len(t)) * STEP, t[:, k]) for k in range(3)], axis=1)
        for t in tracks
    ]
    found = {}
    for i, j in combinations(range(len(tracks)), 2):
        if distance is not None:
            near = np.hypot(*(fine[i] - fine[j]).T[:2]) < distance
        else:
            one, other = ((m.length / 2, m.width / 2, m.round) for m in (models[i], models[j]))
            near = gap(one, fine[i], other, fine[j]) < margin
        edges = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]]).astype(int)))
        spans = [(time[a], time[b - 1]) for a, b in edges.reshape(-1, 2)]
        if near[-1]:
            spans[-1] = (spans[-1][0], math.inf)
        found[i, j] = spans
    return found


def _check(gap: Gap, tracks: list[Array], models: list[RobotModel], distance: float | None) -> None:
    most = 50
    found = conflicts_of(tracks, models, most, distance)
    assert found == sorted(found, key=lambda c: c.begin)
    # Boxes at corners are kept apart by up to 1.4 margins.
    strict = _brute(gap, tracks, models, MARGIN * math.sqrt(2.0) + 1e-6, distance)
    lenient = _brute(gap, tracks, models, MARGIN - 1e-6, distance)
    # Robots that begin or end nearer than that to anybody are planned with less than that, past
    # everybody: they keep as much as their starts and goals have to.
    close = _brute(gap, tracks, models, MARGINS[-1].others - 1e-6, distance)
    spared = {
        robot
        for pair, spans in strict.items()
        if any(begin == 0.0 or end == math.inf for begin, end in spans)
        for robot in pair
    }
    for pair in strict:
        if spared.intersection(pair):
            lenient[pair] = close[pair]
    for pair, spans in lenient.items():
        mine = [c for c in found if (c.i, c.j) == pair]
        for begin, end in spans:
            if end - begin < 2 * LOOK:
                continue  # too short to be seen for sure
            inside = [c for c in mine if c.begin <= begin + LOOK + 2e-3 and c.end >= end - LOOK]
            assert inside, (pair, begin, end, mine)
            assert end < math.inf or inside[-1].end == math.inf
    for c in found:
        touching = [s for s in strict[c.i, c.j] if s[0] - 2e-3 <= c.begin <= s[1] + 2e-3]
        assert touching, c
        # From one meeting to the next some look may have missed that they were apart.
        assert any(s[1] >= min(c.end, 1e9) - LOOK - 2e-3 for s in strict[c.i, c.j]), c


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 4))
@example(188051, 3)  # 0 ends beside 2, and meets 1
@example(397097, 4)
@example(12791571, 3)
def test_conflicts_are_those_that_brute_force_finds(footprint_gap, seed, count):
    rng = np.random.default_rng(seed)
    models = [robot_model(str(rng.choice(sorted(MODELS)))) for _ in range(count)]
    _check(footprint_gap, _random_tracks(rng, count), models, None)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.2, 1.0))
def test_conflicts_of_centres(footprint_gap, seed, distance):
    rng = np.random.default_rng(seed)
    models = [robot_model("spirit"), robot_model("go1"), robot_model("unicycle")]
    tracks = _random_tracks(rng, 3)
    found = conflicts_of(tracks, models, 50, distance)
    brute = _brute(footprint_gap, tracks, models, 0.0, distance)
    for pair, spans in brute.items():
        mine = [c for c in found if (c.i, c.j) == pair]
        for begin, end in spans:
            if end - begin >= 2 * LOOK:
                assert any(c.begin <= begin + LOOK + 2e-3 and c.end >= end - LOOK for c in mine)
    for c in found:
        assert any(s[0] - 2e-3 <= c.begin <= s[1] + 2e-3 for s in brute[c.i, c.j])


def _line(a: tuple, b: tuple, count: int) -> Array:
    return np.linspace((*a, 0.0), (*b, 0.0), count)


def test_two_that_pass_conflict_for_as_long_as_their_bodies_overlap():
    go1 = robot_model("go1")
    # 1 m/s each: they overlap while their centres are less than 0.65 m apart.
    tracks = [_line((0, 0), (4, 0), 81), _line((4, 0), (0, 0), 81)]
    (found,) = conflicts_of(tracks, [go1, go1])
    assert (found.i, found.j) == (0, 1)
    assert found.begin == pytest.approx((4.0 - 0.65) / 2, abs=0.011)
    assert found.end == pytest.approx((4.0 + 0.65) / 2, abs=0.011)


def test_a_conflict_that_stays_has_no_end():
    go1 = robot_model("go1")
    tracks = [_line((0, 0), (2, 0), 41), _line((2.5, 0), (2.5, 0), 1)]
    (found,) = conflicts_of(tracks, [go1, go1])
    assert found.end == math.inf
    assert found.begin == pytest.approx(2.5 - 0.65, abs=0.011)


def test_who_touches_at_the_last_moment_stays():
    go1 = robot_model("go1")
    tracks = [_line((0, 0), (2, 0), 41), _line((2.649, 0), (2.649, 0), 1)]
    (found,) = conflicts_of(tracks, [go1, go1])
    assert found.end == math.inf


def test_all_stand_and_nobody_moves():
    go1 = robot_model("go1")
    still = [np.zeros((1, 3)), np.array([[0.1, 0.1, 1.0]]), np.array([[5.0, 5.0, 0.0]])]
    assert conflicts_of(still, [go1] * 3) == [Conflict(0, 1, 0.0, math.inf)]


def test_no_more_than_so_many_of_each_pair_and_in_order_of_time():
    go1 = robot_model("go1")
    to_and_fro = np.concatenate([_line((0, 0), (3, 0), 41), _line((3, 0), (0, 0), 41)] * 3)
    models = [go1] * 3
    stand = [np.array([[1.5, 0.0, 0.0]]), np.array([[2.0, 3.0, 0.0]])]
    tracks = [to_and_fro, *stand]
    assert len(conflicts_of(tracks, models, 50)) == 6
    few = conflicts_of(tracks, models, 2)
    assert few == conflicts_of(tracks, models, 50)[:2]
    assert few[0].begin < few[0].end < few[1].begin


def test_stacked_tracks_stand_at_their_last_pose():
    table = stacked([np.arange(6.0).reshape(2, 3), np.arange(12.0).reshape(4, 3)])
    assert table.shape == (2, 4, 3)
    assert (table[0, 1:] == [3.0, 4.0, 5.0]).all()
