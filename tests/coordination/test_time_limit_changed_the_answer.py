"""A limit of wall time ends a search that would have gone on; otherwise plans are as without it.

The clock is one that the kernels move: every expansion takes it a while.
"""

from __future__ import annotations

import itertools
import math

import pytest

from cavalcade.coordination import PlanSettings, joint, plan_team
from cavalcade.lattice import deadline, planner
from cavalcade.lattice.deadline import Deadline

LIMITS = (1.0, 2.0, 5.0, 10.0, 30.0, 120.0, 300.0)
WALL = ((4.0, 0.0, 4.3, 2.6), (6.0, 1.4, 6.3, 4.0))
A, B = (2.0, 2.0, 0.0), (7.5, 2.0, 0.0)


class Clock:
    """Time that passes by work alone, s."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch) -> Clock:
    """Expansions of 2 ms each, extensions of trees of 50 ms each."""
    fake, search, grow = Clock(), planner.search, joint.search_joint

    def searching(scene, goal, primitives, to_go, settings, frontier):
        before = int(frontier.counts[2])
        answer = search(scene, goal, primitives, to_go, settings, frontier)
        fake.now += 0.002 * (answer[2] - before)
        return answer

    def growing(team, trees, rng, begin, end):
        answer = grow(team, trees, rng, begin, end)
        fake.now += 0.05 * (answer[2] - begin)
        return answer

    monkeypatch.setattr(deadline, "perf_counter", fake)
    monkeypatch.setattr(planner, "search", searching)
    monkeypatch.setattr(joint, "search_joint", growing)
    return fake


def crowd(make_team, robots):
    """Robots that change sides round two walls."""
    rows = [0.7 + 2.6 * k / max(robots - 1, 1) for k in range(robots)]
    there = [(0.7, y, 0.0) for y in rows]
    back = [(8.3, y, 0.0) for y in rows]
    team = [("go1", a, b) for a, b in zip(there, reversed(back), strict=True)]
    team += [("go1", a, b) for a, b in zip(back, reversed(there), strict=True)]
    return make_team(team, (9.0, 4.0), WALL)


@pytest.mark.parametrize("method", ["auto", "sequential", "cbs", "joint"])
@pytest.mark.parametrize("robots", [1, 2])
def test_limits_only_end_what_would_have_gone_on(make_team, bytes_of, clock, method, robots):
    problem = crowd(make_team, robots)
    settings = PlanSettings(iterations=60_000)
    free = plan_team(problem, method, settings)
    needed = free.planning_time
    for limit in LIMITS:
        plan = plan_team(problem, method, PlanSettings(iterations=60_000, seconds=limit))
        assert plan.planning_time <= 1.05 * limit + 0.5
        if needed < limit:
            assert plan.reason == free.reason
            assert plan.iterations == free.iterations
            assert bytes_of(plan) == bytes_of(free)
        else:
            assert plan.planning_time >= limit
            assert plan.solved or plan.detail.endswith(f"{limit:g} s are over")


def test_a_search_that_needs_long_is_not_given_up_before_its_time(make_team, clock):
    """A closed door: without a limit all is tried; with one, nothing ends before it."""
    problem = crowd(make_team, 2)
    for limit in (1.0, 3.0, 9.0):
        plan = plan_team(problem, "joint", PlanSettings(seconds=limit))
        assert plan.solved or limit <= plan.planning_time <= 1.05 * limit + 0.5


@pytest.mark.parametrize("limit", LIMITS)
@pytest.mark.parametrize("step", [1e-6, 1e-4, 1e-3, 0.02])
def test_slices_hold_the_limit_whatever_a_step_takes(monkeypatch, limit, step):
    clock = Clock()
    monkeypatch.setattr(deadline, "perf_counter", clock)
    watch, at, looks = Deadline(limit), 0, 0
    for end in watch.slices(0, 10**9):
        clock.now += step * (end - at)
        at, looks = end, looks + 1
    assert watch.late
    assert limit <= watch.elapsed <= 1.05 * limit + 0.5
    assert looks <= 40 * limit + 60


def test_without_a_limit_there_is_one_slice():
    assert list(Deadline().slices(3, 1000)) == [1000]
    assert list(Deadline().slices(5, 5)) == []
    assert not Deadline().late
    assert Deadline().left is None


def test_slices_end_where_the_work_does(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(deadline, "perf_counter", clock)
    ends = list(Deadline(10.0).slices(0, 1000))
    assert ends[-1] == 1000
    assert all(a < b for a, b in itertools.pairwise(ends))


def test_a_limit_of_nothing_does_nothing():
    watch = Deadline(0.0)
    assert watch.late
    assert list(watch.slices(0, 10)) == []
    assert not math.isnan(watch.elapsed)
