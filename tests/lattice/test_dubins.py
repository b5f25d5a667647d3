"""Words between two states: each ends where it should, and none is better than it can be."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cavalcade.geometry import Array
from cavalcade.lattice import dubins
from cavalcade.lattice.dubins import backward_factor, connect, no_words
from cavalcade.lattice.motion_limits import MotionLimits, motion_limits
from cavalcade.lattice.primitives import V0, V1, poses_between, sample_moves, trapezoid
from cavalcade.robots import MODELS, robot_model

_FEW = settings(max_examples=400, deadline=None)
_NAMES = st.sampled_from(sorted(MODELS))
_PLACE = st.one_of(st.floats(-6.0, 6.0), st.sampled_from((0.0, 1.0, -2.0)))
_YAW = st.one_of(
    st.floats(-7.0, 7.0), st.sampled_from((0.0, math.pi, -math.pi, math.pi / 2, 2 * math.pi))
)
_POSE = st.tuples(_PLACE, _PLACE, _YAW)
_SHARE = st.sampled_from((0.0, 0.5, 1.0))
_REST = st.just(0.0)


def _words(
    limits: MotionLimits, a: tuple, v0: float, b: tuple, v1: float, price: float = 2.0
) -> list[tuple[Array, float]]:
    """All words, each with its cost."""
    words = no_words()
    words.moves[:] = np.nan
    a, b = np.array(a, dtype=float), np.array(b, dtype=float)
    number = connect(a, v0, b, v1, limits, price, words)
    return [
        (words.moves[k, : words.counts[k]].copy(), float(words.costs[k])) for k in range(number)
    ]


def _blur(limits: MotionLimits) -> float:
    """How much shorter than the straight line a word may be, m.

    Of each of three parts a nanometre is not driven. The length of a straight between two circles
    is the root of a difference of squares, which is known to some 16 roundings of 1.
    """
    return 3e-9 + math.sqrt(16 * np.finfo(float).eps) * limits.radius


def _turned(pose: Array, b: tuple) -> float:
    return abs(math.remainder(pose[2] - b[2], 2 * math.pi))


@_FEW
@given(_NAMES, _POSE, _SHARE, _POSE, _SHARE)
@example("unicycle-sphere", (0.0, 0.0, math.pi / 2), 1.0, (0.0, 7.7e-9, math.pi / 2), 1.0)
def test_words_reach_their_end_at_its_speed(name, a, v0, b, v1):
    limits = motion_limits(robot_model(name))
    v0, v1 = v0 * limits.speed, v1 * limits.speed
    for word, cost in _words(limits, a, v0, b, v1):
        assert np.isfinite(word).all()
        end = poses_between(np.array(a), word)[-1]
        assert math.dist(end[:2], b[:2]) < 1e-6
        if not limits.free:
            assert _turned(end, b) < 1e-6
        # From one move to the next the speed goes on; turns on the spot are between rests.
        speeds = [(row[2], row[3]) for row in word if row[0] != 0.0]
        if speeds:
            assert speeds[0][0] == pytest.approx(v0, abs=1e-6)
            assert speeds[-1][1] == pytest.approx(v1, abs=1e-6)
        else:
            assert v0 == v1 == 0.0 or math.dist(a[:2], b[:2]) < _blur(limits)
        for one, other in itertools.pairwise(speeds):
            assert one[1] == pytest.approx(other[0], abs=1e-6)
        driven = [k for k, row in enumerate(word) if row[0] != 0.0]
        turns = [k for k, row in enumerate(word) if row[0] == 0.0]
        for k in turns:
            assert v0 == 0.0 or k > min(driven)
            assert v1 == 0.0 or k < max(driven)
            assert k in (0, len(word) - 1)
        ahead = all(row[0] > 0.0 for row in word if row[0] != 0.0)
        metre = 1.0 if ahead else backward_factor(limits)
        length = np.abs(word[:, 0]).sum()
        assert cost == pytest.approx(word[:, 5].sum() + 2.0 * metre * length, abs=1e-6)


@_FEW
@given(_NAMES, _POSE, _SHARE, _POSE, _SHARE)
@example("double-integrator", (0.0, 0.0, 0.0), 0.0, (0.0, 6.930851225079091e-13, 0.0), 0.0)
@example("go1", (0.0, 1.0, math.pi / 2), 0.0, (0.0, 1.0 + 5.8e-9, math.pi / 2), 0.0)
def test_no_word_beats_the_straight_line(name, a, v0, b, v1):
    limits = motion_limits(robot_model(name))
    # From rest, time grows with the root of the distance: nanometres take a while.
    distance = max(math.dist(a[:2], b[:2]) - _blur(limits), 0.0)
    least = distance / limits.speed
    if v0 == v1 == 0.0:
        least = trapezoid(distance, 0.0, 0.0, limits.speed, limits.acceleration)[0]
    for word, cost in _words(limits, a, v0 * limits.speed, b, v1 * limits.speed):
        assert np.abs(word[:, 0]).sum() >= distance - 1e-6
        assert word[:, 5].sum() >= least - 1e-6
        assert cost >= least + 2.0 * distance - 1e-6


@pytest.mark.parametrize("short", [0.0, 4e-10, 9e-10, 9.99e-10, 1e-9, 1.1e-9, 1e-8])
@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_a_word_did_not_come_to_rest_where_its_last_parts_were_too_short_to_drive(short, speed):
    limits, words = motion_limits(robot_model("go1")), no_words()
    for lengths in itertools.permutations((1.0, short, short)):
        parts = np.array([(length, 0.0) for length in lengths])
        ends = (speed, 0.0)
        assert dubins._lay(words, 0, (0.0, 0.0), parts, ends, limits, 2.0) == 1
        rows = words.moves[0, : words.counts[0]]
        assert rows[0, V0] == speed
        assert rows[-1, V1] == 0.0
        assert (np.abs(rows[:, 0]) >= 1e-9).all()
        assert rows[1:, V0] == pytest.approx(rows[:-1, V1], abs=0.0)
        expected = rows[:, 5].sum() + 2.0 * rows[:, 0].sum()
        assert words.costs[0] == pytest.approx(expected, abs=1e-12)


@_FEW
@given(_NAMES, _POSE, _SHARE, _POSE, _SHARE)
def test_words_keep_to_the_limits_of_the_robot(name, a, v0, b, v1):
    limits = motion_limits(robot_model(name))
    v0, v1 = v0 * limits.speed, v1 * limits.speed
    for word, _ in _words(limits, a, v0, b, v1):
        time = np.linspace(0.0, word[:, 5].sum(), 301)
        motion = sample_moves(np.array(a), word, limits, time)
        speed = np.hypot(motion[:, 3], motion[:, 4])
        assert speed.max(initial=0.0) <= limits.speed + 1e-9
        assert np.abs(motion[:, 5]).max(initial=0.0) <= limits.yaw_rate + 1e-9
        if len(time) and time[-1] > 0.0 and not v0 and not v1:
            assert np.abs(np.diff(speed)).max() <= limits.acceleration * time[1] * (1 + 1e-6) + 1e-9
        backwards = word[:, 0] < 0.0
        if backwards.any():
            assert np.abs(word[backwards, 0]).sum() <= limits.backwards
            assert (word[backwards, 4] <= limits.backward_speed + 1e-9).all()
            assert (word[:, 0] <= 0.0).all()


@_FEW
@given(_NAMES, _POSE, _POSE)
def test_from_rest_to_rest_there_is_always_a_word(name, a, b):
    limits = motion_limits(robot_model(name))
    words = _words(limits, a, 0.0, b, 0.0)
    assert words
    # At least turn, straight, turn.
    distance = math.dist(a[:2], b[:2])
    turn = (
        0.0
        if limits.free
        else trapezoid(math.pi, 0.0, 0.0, limits.yaw_rate, limits.yaw_acceleration)[0]
    )
    straight = trapezoid(distance, 0.0, 0.0, limits.speed, limits.acceleration)[0]
    assert min(cost for _, cost in words) <= 2 * turn + straight + 2.0 * distance + 1e-6


@_FEW
@given(_NAMES, _POSE, _SHARE, _POSE, _SHARE, st.floats(-3.0, 3.0))
def test_words_do_not_depend_on_where_one_looks_from(name, a, v0, b, v1, angle):
    limits = motion_limits(robot_model(name))
    v0, v1 = v0 * limits.speed, v1 * limits.speed
    if math.dist(a[:2], b[:2]) < 1e-3:
        return

    def cheapest(p: tuple, q: tuple) -> float:
        return min((cost for _, cost in _words(limits, p, v0, q, v1)), default=math.inf)

    def moved(pose: tuple) -> tuple:
        c, s = math.cos(angle), math.sin(angle)
        x, y, yaw = pose
        return c * x - s * y + 1.0, s * x + c * y - 2.0, yaw + angle

    def mirrored(pose: tuple) -> tuple:
        return pose[0], -pose[1], -pose[2]

    least = cheapest(a, b)
    for image in (moved, mirrored):
        other = cheapest(image(a), image(b))
        assert other == pytest.approx(least, abs=1e-4) or _on_an_edge(a, b, limits.radius)


def _centres(pose: tuple, radius: float) -> list[complex]:
    x, y, yaw = pose
    c, s = radius * math.cos(yaw), radius * math.sin(yaw)
    return [complex(x - s, y + c), complex(x + s, y - c)]


def _on_an_edge(a: tuple, b: tuple, radius: float) -> bool:
    """Whether rounding decides on a whole turn more or less, or on whether circles touch."""
    bearing = math.atan2(b[1] - a[1], b[0] - a[0])
    differences = (a[2] - bearing, b[2] - bearing, b[2] - a[2])
    if any(abs(math.remainder(d, math.pi)) < 1e-6 for d in differences):
        return True
    near, far = _centres(a, radius), _centres(b, radius)
    gaps = [abs(p - q) - 2 * radius for p in near for q in far]
    gaps += [abs(p - complex(*b[:2])) - radius for p in near]
    gaps += [abs(q - complex(*a[:2])) - radius for q in far]
    return min(map(abs, gaps)) < 1e-6


@pytest.mark.parametrize(("v0", "v1"), [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])
def test_walking_on_straight_ahead_is_the_straight_line(v0, v1):
    limits = motion_limits(robot_model("go1"))
    v0, v1 = v0 * limits.speed, v1 * limits.speed
    word, cost = min(
        _words(limits, (1, 1, 0.5), v0, (4, 1 + 3 * math.tan(0.5), 0.5), v1),
        key=lambda found: found[1],
    )
    distance = 3.0 / math.cos(0.5)
    assert np.abs(word[:, 0]).sum() == pytest.approx(distance)
    duration, _ = trapezoid(distance, v0, v1, limits.speed, limits.acceleration)
    assert cost == pytest.approx(duration + 2.0 * distance)


def _dubins_length(a: tuple, b: tuple, radius: float) -> float:
    """Shortest of the words arc, straight, arc by tangents of circles drawn one by one."""
    best = math.inf
    sides = itertools.product(
        zip((1, -1), _centres(a, radius), strict=True),
        zip((1, -1), _centres(b, radius), strict=True),
    )
    for (s0, c0), (s1, c1) in sides:
        d, theta = abs(c1 - c0), math.atan2((c1 - c0).imag, (c1 - c0).real)
        if s0 == s1:
            heading, straight = theta, d
        elif d < 2 * radius:
            continue
        else:
            heading = theta + s0 * math.asin(2 * radius / d)
            straight = math.sqrt(d * d - 4 * radius * radius)
        first = (s0 * (heading - a[2])) % (2 * math.pi)
        last = (s1 * (b[2] - heading)) % (2 * math.pi)
        best = min(best, radius * (first + last) + straight)
    return best


@settings(max_examples=200, deadline=None)
@given(_POSE, _POSE)
def test_between_walking_states_the_shortest_arc_straight_arc_word_is_there(a, b):
    limits = motion_limits(robot_model("spirit"))
    if math.dist(a[:2], b[:2]) < 1e-3:
        return
    lengths = [
        np.abs(word[:, 0]).sum() for word, _ in _words(limits, a, limits.speed, b, limits.speed)
    ]
    assert lengths
    expected = _dubins_length(a, b, limits.radius)
    assert min(lengths) == pytest.approx(expected, abs=1e-5) or _on_an_edge(a, b, limits.radius)
