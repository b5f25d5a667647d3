"""Moves: what a trapezoid, an arc and a sampled plan in the plane are, by numeric integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.lattice.motion_limits import motion_limits, primitives_of
from cavalcade.lattice.primitives import (
    advanced,
    along,
    make_move,
    poses_between,
    sample_moves,
    trapezoid,
    within,
)
from cavalcade.robots import MODELS, robot_model

_FEW = settings(max_examples=200, deadline=None)
_LENGTH = st.floats(0.0, 20.0)
_SPEED = st.floats(0.0, 1.0)
_ACCELERATION = st.floats(0.1, 4.0)
_POSE = st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-4.0, 4.0))


def _quickest(length: float, v0: float, v1: float, vmax: float, acceleration: float) -> float:
    """Duration of the way at the largest speed that both ends allow everywhere, s."""
    top = max(vmax, v0, v1)
    # Dense where speeds are small.
    grid = length * np.sin(np.linspace(0.0, np.pi / 2, 20_001)) ** 2
    s = 0.5 * (grid[1:] + grid[:-1])
    fast = np.minimum(v0**2 + 2 * acceleration * s, v1**2 + 2 * acceleration * (length - s))
    return float((np.diff(grid) / np.minimum(np.sqrt(fast), top)).sum())


@_FEW
@given(_LENGTH, _SPEED, _SPEED, st.floats(0.05, 1.5), _ACCELERATION)
def test_trapezoid_is_the_quickest_way_within_its_limits(length, v0, v1, vmax, acceleration):
    vmax = max(vmax, v0, v1)
    duration, peak = trapezoid(length, v0, v1, vmax, acceleration)
    needed = abs(v1 * v1 - v0 * v0) / (2.0 * acceleration)
    if duration < 0.0:
        assert length < needed + 1e-6
        return
    assert length > needed - 1e-6
    assert max(v0, v1) - 1e-9 <= peak <= vmax + 1e-9
    if length > 1e-6:
        expected = _quickest(length, v0, v1, vmax, acceleration)
        assert duration == pytest.approx(expected, rel=3e-3)
    else:
        assert duration <= 0.01


@_FEW
@given(_LENGTH, _SPEED, _SPEED, st.floats(0.05, 1.5), _ACCELERATION)
def test_along_is_the_integral_of_its_own_speed(length, v0, v1, vmax, acceleration):
    vmax = max(vmax, v0, v1)
    duration, peak = trapezoid(length, v0, v1, vmax, acceleration)
    if duration <= 1e-6:
        return
    time = np.linspace(0.0, duration, 2_001)
    way, speed = np.array([along(duration, v0, v1, peak, acceleration, t) for t in time]).T
    step = time[1]
    assert way[0] == 0.0
    assert speed[0] == pytest.approx(v0, abs=1e-9)
    assert way[-1] == pytest.approx(length, abs=1e-6)
    assert speed[-1] == pytest.approx(v1, abs=1e-6)
    assert speed.min() >= -1e-9
    assert speed.max() <= peak + 1e-9
    assert np.abs(np.diff(speed)).max() <= acceleration * step * (1 + 1e-6) + 1e-9
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * step)])
    assert np.abs(summed - way).max() <= acceleration * step * step + 1e-9


def test_no_way_is_too_short_for_the_speeds_and_none_takes_no_time():
    assert trapezoid(0.1, 0.0, 1.0, 1.0, 1.0)[0] == -1.0
    assert trapezoid(0.5, 0.0, 1.0, 1.0, 1.0) == pytest.approx((1.0, 1.0))
    assert trapezoid(0.0, 0.0, 0.0, 1.0, 1.0) == (0.0, 0.0)


@_FEW
@given(_POSE, st.floats(-5.0, 5.0), st.floats(-3.0, 3.0))
def test_advanced_is_the_integral_of_the_heading(pose, length, turn):
    count = 4_000
    share = (np.arange(count) + 0.5) / count
    heading = pose[2] + turn * share
    x = pose[0] + length * np.cos(heading).mean()
    y = pose[1] + length * np.sin(heading).mean()
    assert advanced(*pose, length, turn) == pytest.approx((x, y, pose[2] + turn), abs=1e-6)


def test_advanced_is_the_same_for_the_smallest_turns():
    straight = advanced(1.0, 2.0, 0.5, 3.0, 0.0)
    for turn in (1e-12, 1e-9, 1e-8, 1e-6):
        assert advanced(1.0, 2.0, 0.5, 3.0, turn) == pytest.approx(straight, abs=1e-5)


@st.composite
def _plans(draw) -> tuple:
    """A robot, a pose and moves whose speeds fit each other."""
    model = robot_model(draw(st.sampled_from(sorted(MODELS))))
    limits = motion_limits(model)
    speed, free = limits.speed, limits.free
    moves, moving = [], 0.0
    for _ in range(draw(st.integers(1, 6))):
        kind = draw(st.sampled_from(("drive", "back", "turn", "stand")))
        row = np.zeros(6)
        if kind == "drive":
            after = draw(st.sampled_from((0.0, 0.5 * speed, speed)))
            turn = 0.0 if free or limits.radius == 0.0 else draw(st.floats(-2.0, 2.0))
            length = max(draw(st.floats(0.05, 3.0)), limits.radius * abs(turn))
            length = max(length, abs(after**2 - moving**2) / (2 * limits.acceleration) + 1e-6)
            assert make_move(row, length, turn, moving, after, speed, limits)
            moving = after
        elif moving > 0.0:
            continue
        elif kind == "back":
            if limits.backwards == 0.0:
                continue
            length = draw(st.floats(0.05, 0.6))
            assert make_move(row, -length, 0.0, 0.0, 0.0, limits.backward_speed, limits)
        elif kind == "turn":
            assert make_move(row, 0.0, draw(st.floats(-math.pi, math.pi)), 0.0, 0.0, 0.0, limits)
        else:
            row[5] = draw(st.floats(0.1, 2.0))
        moves.append(row)
    if moving > 0.0:
        row = np.zeros(6)
        assert make_move(row, moving**2 / limits.acceleration, 0.0, moving, 0.0, speed, limits)
        moves.append(row)
    return limits, np.array(draw(_POSE)), np.array(moves).reshape(-1, 6)


@_FEW
@given(_plans())
def test_sampled_moves_are_one_motion_within_the_limits(plan):
    limits, start, moves = plan
    ends = np.concatenate([[0.0], np.cumsum(moves[:, 5])])
    h = 1e-4
    time = np.arange(-0.1, ends[-1] + 0.2, 0.013)
    # Away from where moves join: there a heading that is free jumps, and so may a yaw rate.
    time = time[np.abs(time[:, None] - ends).min(axis=1) > 2 * h]
    motion = sample_moves(start, moves, limits, time)
    before = sample_moves(start, moves, limits, time - h)
    after = sample_moves(start, moves, limits, time + h)
    change = (after[:, :3] - before[:, :3]) / (2 * h)
    assert np.abs(change - motion[:, 3:]).max() < 5e-3
    speed = np.hypot(motion[:, 3], motion[:, 4])
    assert speed.max() <= limits.speed + 1e-9
    assert np.abs(motion[:, 5]).max() <= limits.yaw_rate * (1 + 1e-9) + 1e-9
    # Along the heading, forwards or backwards.
    across = motion[:, 3] * np.sin(motion[:, 2]) - motion[:, 4] * np.cos(motion[:, 2])
    assert np.abs(across).max() < 1e-9
    # The speed never jumps, not even where moves join.
    for end in ends:
        pair = sample_moves(start, moves, limits, np.array([end - 1e-7, end + 1e-7]))
        assert abs(np.subtract(*np.hypot(pair[:, 3], pair[:, 4]))) < 1e-5
        assert np.hypot(*(pair[1] - pair[0])[:2]) < 1e-5
    still = sample_moves(start, moves, limits, np.array([-1.0, ends[-1] + 1.0]))
    assert (still[:, 3:] == 0.0).all()
    assert still[0, :3] == pytest.approx(start)
    assert still[1, :3] == pytest.approx(poses_between(start, moves)[-1])


@_FEW
@given(_plans())
def test_poses_between_are_where_single_moves_end(plan):
    limits, start, moves = plan
    poses = poses_between(start, moves)
    assert len(poses) == len(moves) + 1
    for k, move in enumerate(moves):
        x, y, yaw, _, _ = within(*poses[k], move, limits, move[5])
        assert (x, y, yaw) == pytest.approx(tuple(poses[k + 1]), abs=1e-6)


def test_a_plan_of_no_moves_stands():
    start = np.array([1.0, 2.0, 3.0])
    motion = sample_moves(
        start, np.zeros((0, 6)), motion_limits(robot_model("go1")), np.arange(3.0)
    )
    assert (motion == [[1.0, 2.0, 3.0, 0.0, 0.0, 0.0]] * 3).all()


@pytest.mark.parametrize("name", sorted(MODELS))
def test_motion_limits_keep_to_those_of_the_models(name):
    model = robot_model(name)
    limits = motion_limits(model)
    assert np.isfinite(limits._replace(backwards=0.0)).all()
    top = model.legs.v_max if model.legs else model.max_speed_x
    assert 0.0 < limits.speed <= top
    assert 0.0 < limits.backward_speed <= limits.speed
    assert 0.0 < limits.acceleration <= model.max_acceleration
    assert 0.0 < limits.yaw_rate <= model.max_yaw_rate
    assert (
        0.0 < limits.yaw_acceleration <= max(model.max_yaw_acceleration, 4.0 if model.legs else 0.0)
    )
    if limits.radius > 0.0:
        # In the tightest arc at full speed, it turns as fast as it may.
        assert limits.speed / limits.radius == pytest.approx(limits.yaw_rate)
    assert limits.free == model.drive.startswith("integrator")
    assert (limits.half_length, limits.half_width) == (model.length / 2, model.width / 2)
    assert limits.round == model.round
    if model.legs:
        # Walking a bend while slowing down stays within what friction allows.
        assert (
            math.hypot(limits.acceleration, limits.speed * limits.yaw_rate) <= model.legs.mu * 9.81
        )
    if model.drive == "unicycle-2":
        assert limits.radius == 0.0  # the yaw rate would jump where an arc begins


@pytest.mark.parametrize("finer", [0, 1, 2])
@pytest.mark.parametrize("name", sorted(MODELS))
def test_primitives_are_moves_of_their_robot(name, finer):
    limits = motion_limits(robot_model(name))
    table = primitives_of(robot_model(name), finer)
    speeds = {0.0: 0.0, 1.0: limits.speed}
    for row in table:
        length, turn, v0, v1, vmax, duration, before, after = row
        assert duration >= 0.0
        assert (v0, v1) == (speeds[before], speeds[after])
        if length == 0.0:
            assert (before, after) == (0.0, 0.0)
        again = np.zeros(6)
        if length != 0.0 or turn != 0.0:
            assert make_move(again, length, turn, v0, v1, vmax, limits)
            assert again == pytest.approx(row[:6])
        if length != 0.0 and turn != 0.0:
            assert abs(length / turn) >= limits.radius - 1e-9 > 0.0
        if length < 0.0:
            assert -length <= limits.backwards
            assert vmax == limits.backward_speed
    # Every one has its mirror image, and somebody may always stand still.
    moves = {tuple(np.round(row, 9) + 0.0) for row in table}
    half = {(*row[:1], -row[1] + 0.0, *row[2:]) for row in moves}
    assert {row for row in moves ^ half if abs(abs(row[1]) - math.pi) > 1e-6} == set()
    assert ((table[:, 0] == 0.0) & (table[:, 1] == 0.0) & (table[:, 5] > 0.0)).sum() == 1
    assert set(table[:, 6]) == {0.0, 1.0}
