"""Who waits for whom, against an obvious version of it and as laws."""

from __future__ import annotations

import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.execution._precedence import CONCESSION, NEVER
from cavalcade.execution.precedence import Precedence
from cavalcade.geometry.trajectory import WALK, Trajectory
from cavalcade.robots import robot_model

GO1, DISC = robot_model("go1"), robot_model("single-integrator")
REACH = 0.5


def wandering(seed: int, robots: int, seconds: float, size: float = 3.0) -> list[Trajectory]:
    """Legs at up to 0.75 m/s between random points, with rests; they may well run into others."""
    rng = np.random.default_rng(seed)
    paths = []
    for _ in range(robots):
        time, points, yaws = [0.0], [rng.uniform(0, size, 2)], [rng.uniform(-3, 3)]
        while time[-1] < seconds * rng.uniform(0.6, 1.0):
            if rng.random() < 0.3:
                time.append(time[-1] + rng.uniform(0.3, 1.5))
                points.append(points[-1])
                yaws.append(yaws[-1])
                continue
            goal = rng.uniform(0, size, 2)
            yaw = yaws[-1] + rng.uniform(-1, 1)
            took = max(np.hypot(*(goal - points[-1])) / 0.75, abs(yaw - yaws[-1]) / 1.2, 0.05)
            time.append(time[-1] + took)
            points.append(goal)
            yaws.append(yaw)
        fine = np.unique(np.concatenate([np.arange(0.0, time[-1], 0.025), time]))
        xy = np.array(points)
        position = np.column_stack(
            [np.interp(fine, time, xy[:, 0]), np.interp(fine, time, xy[:, 1]), 0.0 * fine]
        )
        velocity = np.gradient(position, fine, axis=0)
        yaw = np.interp(fine, time, yaws)
        paths.append(Trajectory(fine, position, velocity, yaw, np.full(len(fine), WALK, np.int8)))
    return paths


def shape(model):
    return 0.5 * model.length, 0.5 * model.width, model.round


def blocked_cells(paths, models, order, gap_of, margin=0.10):
    """`(K, K)` of the first two robots, from the definition: which (a, b) are blocked."""
    count = order.near.shape[-1]
    poses = [path.poses_at(order.step * np.arange(count)) for path in paths]
    loose = []
    for model, own in zip(models, poses, strict=True):
        radius = 0.0 if model.round else 0.5 * math.hypot(model.length, model.width)
        step = [math.dist(p[:2], q[:2]) + radius * abs(p[2] - q[2]) for p, q in pairwise(own)]
        loose.append([0.5 * max(a, b) for a, b in zip([0.0, *step], [*step, 0.0], strict=True)])
    grid = [np.tile(poses[1], (count, 1)), np.repeat(poses[0], count, axis=0)]
    gaps = np.maximum(gap_of(shape(models[0]), grid[1], shape(models[1]), grid[0]), 0.0)
    gaps = gaps.reshape(count, count)
    blocked = np.zeros((count, count), dtype=bool)
    for a in range(count):
        for b in range(a + 1, count):
            if any(np.abs(own[a : b + 1] - own[a]).max() <= 1e-9 for own in poses):
                continue
            room = loose[0][a] + loose[1][b]
            wanted = margin + room
            if b - a <= order.band:
                least = min(gaps[k, k] for k in range(a, b + 1))
                wanted = max(min(wanted, least - CONCESSION), room)
            blocked[a, b] = gaps[a, b] < wanted
    return blocked


@pytest.mark.parametrize("seed", range(6))
def test_cells_are_those_of_the_definition(seed, footprint_gap):
    models = [GO1, DISC if seed % 2 else GO1]
    paths = wandering(seed, 2, 4.0, 1.5)
    order = Precedence(paths, models, REACH, step=0.1)
    blocked = blocked_cells(paths, models, order, footprint_gap)
    count = len(blocked)
    assert blocked.any()
    for a in range(count):
        row = np.flatnonzero(blocked[a])
        near = row[row <= a + order.band]
        assert order.near[0, 1, a] == (near[0] if len(near) else NEVER)
        later = [
            b for k in range(a, count) for b in np.flatnonzero(blocked[k]) if b > k + order.band
        ]
        assert order.far[0, 1, a] == min(later, default=NEVER)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 5), st.data())
def test_somebody_may_always_go_on(seed, robots, data):
    """Whatever the ways are, even through each other: the last of all is never held up."""
    paths = wandering(seed, robots, 4.0)
    order = Precedence(paths, [GO1] * robots, REACH)
    end = max(path.duration for path in paths)
    rng = np.random.default_rng(data.draw(st.integers(0, 10_000)))
    progress = np.zeros(robots)
    for _ in range(20_000):
        bounds = order.bounds(progress)
        last = int(np.argmin(progress))
        if progress[last] >= end:
            break
        assert bounds[last] > progress[last]
        # Somebody moves, as far as it likes within its bound; robots may be as slow as they like.
        mover = last if rng.random() < 0.3 else int(rng.integers(robots))
        far = progress[mover] + rng.exponential(1.0)
        progress[mover] = max(min(far, bounds[mover], end), progress[mover])
    assert progress.min() >= end


@pytest.mark.parametrize("seed", range(8))
def test_a_plan_without_contact_stays_one_however_late_anybody_is(seed, footprint_gap, crowd):
    paths, models = crowd(seed)
    order = Precedence(paths, models, REACH)
    end = max(path.duration for path in paths)
    rng = np.random.default_rng(seed)
    progress = np.zeros(len(paths))
    speed = rng.uniform(0.05, 1.0, len(paths))
    seen = [progress]
    while progress.min() < end:
        if rng.random() < 0.02:
            speed = rng.uniform(0.0, 1.0, len(paths)) * (rng.random(len(paths)) < 0.7)
        wanted = progress + 0.05 * np.maximum(speed, 0.02)
        progress = np.maximum(np.minimum(wanted, order.bounds(progress)), progress)
        seen.append(progress)
    poses = [path.poses_at(s) for path, s in zip(paths, np.array(seen).T, strict=True)]
    for i, j in combinations(range(len(paths)), 2):
        gaps = footprint_gap(shape(models[i]), poses[i], shape(models[j]), poses[j])
        assert gaps.min() > 0.0


def test_who_is_first_in_the_plan_is_waited_for(straight_way):
    """Two ways that cross; the second robot comes 4 s after the first one."""
    paths = [
        straight_way((1.0, 3.0, 0.0), (7.0, 3.0, 0.0)),
        straight_way((4.0, 1.0, np.pi / 2), (4.0, 5.0, np.pi / 2), 4.0),
    ]
    order = Precedence(paths, [GO1, GO1], REACH)
    at_start = order.bounds(np.array([0.0, 0.0]))
    assert at_start[0] == np.inf
    y = paths[1].poses_at(at_start[1:])[0, 1]
    # Its nose stays 0.10 m before the flank of the first one.
    assert y + 0.325 < 3.0 - 0.14 - 0.10
    assert y + 0.325 > 3.0 - 0.14 - 0.10 - 0.15
    assert order.bounds(np.array([6.5, 0.0]))[1] == np.inf


def test_a_parked_robot_holds_nobody_up(straight_way):
    """The second one passes 5 cm from where the first one has been standing for long."""
    paths = [
        straight_way((1.0, 3.0, 0.0), (3.0, 3.0, 0.0)),
        straight_way((0.5, 3.33, 0.0), (7.0, 3.33, 0.0), 8.0),
    ]
    order = Precedence(paths, [GO1, GO1], REACH)
    parked = paths[0].duration
    assert order.bounds(np.array([parked + 0.02, 0.0]))[1] == np.inf
    assert np.isfinite(order.bounds(np.array([parked - 1.0, 0.0]))[1])
