"""Clocks that repeat, jump or are set back: the planner counts its own cycles."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.fleet import CommandDelay, IdealFleet
from cavalcade.formation.cycle_clock import CycleClock
from cavalcade.robots import robot_model

GO1, BODY = robot_model("go1"), (0.65, 0.28)
PERIOD = 0.05
ROOM = cv.OccupancyMap.empty((9.0, 7.0), 0.05)
SQUARE = cv.Formation.square()

CLOCKS = {
    "steady": lambda t: t,
    "10 Hz": lambda t: math.floor(t * 10 + 1e-6) / 10,
    "1 Hz": lambda t: float(math.floor(t + 1e-6)),
    "repeats once a second": lambda t: t - PERIOD * (round(t / PERIOD) % 20 == 0),
    "stands still": lambda t: 7.0,
    "set back by 100 s": lambda t: t - 100.0 * (t > 5.0),
    "set back by 0.3 s": lambda t: t - 0.3 * (t > 5.0),
    "jumps ahead": lambda t: t + 50.0 * (t > 5.0),
    "jumps to and fro": lambda t: t + 30.0 * (int(t) % 3),
    "since 1970": lambda t: t + 1.8e9,
}


def advanced(times, period: float = PERIOD, foreseen: bool = True) -> list[float]:
    clock = CycleClock(period)
    return [clock.advance(time, lambda _: foreseen) for time in times]


@pytest.mark.parametrize("name", CLOCKS)
def test_own_time_is_that_of_the_cycles(name):
    true = PERIOD * np.arange(400)
    times = np.array(advanced(map(CLOCKS[name], true.tolist())))
    assert (np.diff(times) > 0.0).all()
    np.testing.assert_allclose(times - times[0], true, atol=0.051)


def test_a_steady_clock_is_taken_as_it_is():
    times = [0.0, 0.05, 0.1, 0.17, 0.2, 0.6]
    assert advanced(times) == times


@pytest.mark.parametrize(("gap", "counted"), [(0.49, 0.49), (0.5, PERIOD), (3.0, PERIOD)])
def test_a_jump_with_the_team_where_it_would_be_is_one_cycle(gap, counted):
    times = advanced([1.0, 1.0 + gap, 1.05 + gap])
    assert np.diff(times) == pytest.approx([counted, PERIOD])


def test_time_that_has_passed_counts_if_the_team_has_moved_on():
    assert advanced([1.0, 3.0, 3.05], foreseen=False) == [1.0, 3.0, 3.05]


def test_after_a_pause_time_has_passed():
    clock = CycleClock(PERIOD)
    clock.advance(1.0, lambda _: True)
    clock.expect_gap()
    assert clock.advance(9.0, lambda _: True) == 9.0
    assert clock.advance(19.0, lambda _: True) == 9.05


@pytest.mark.parametrize(
    ("time", "times", "message"),
    [
        (2.0, 11, "stands still"),
        (-98.0, 5, "was set back by 100 s"),
        (102.0, 5, "jumped ahead by 100 s"),
    ],
)
def test_what_is_odd_is_told_for_a_second(time, times, message):
    clock = CycleClock(PERIOD)
    clock.advance(2.0, lambda _: True)
    for _ in range(times):
        clock.advance(time, lambda _: True)
    assert message in clock.message
    for _ in range(45):
        time += PERIOD
        clock.advance(time, lambda _: True)
    assert clock.message == ""


@pytest.mark.parametrize("stall", [0.0, 0.05, 0.1, 0.3, 0.5, 2.0, 60.0])
def test_a_clock_that_stood_still_and_goes_on_costs_no_time(stall):
    """Own time crept on at a tenth of its pace until the clock had caught up."""
    true = PERIOD * np.arange(40 + round(stall / PERIOD) + 40)
    clock = np.where(true < 2.0 + stall, np.minimum(true, 2.0), true - stall)
    times = np.array(advanced(clock.tolist()))
    np.testing.assert_allclose(times, true, atol=PERIOD + 1e-9)
    assert np.diff(times)[-20:] == pytest.approx(PERIOD)


@pytest.mark.parametrize("stall", [0.2, 5.0])
@pytest.mark.parametrize("delay", [0.0, 0.1])
def test_a_team_goes_on_as_soon_as_a_simulation_does_that_was_halted(stall, delay):
    """Its clock and its stamps stand still; the team stood as long again when they went on."""
    planner = cv.FormationPlanner(ROOM, SQUARE, expected=cv.Imperfections(delay=delay))
    planner.set_goal((7.4, 3.5, 0.0))
    starts = np.column_stack([SQUARE.placed((1.6, 3.5, 0.0)), np.zeros(4)])
    fleet = IdealFleet((GO1,) * 4, starts, delay=CommandDelay(delay))
    halted = range(100, 100 + round(stall / PERIOD))
    for cycle in range(halted.stop + 20):
        seen = fleet.observe()
        commands = planner.step(seen.poses, seen.time, seen.stamps)
        if cycle > halted.stop:
            assert planner.status.state != "stale"
            assert commands.any()
        fleet.send(commands)
        if cycle not in halted:
            fleet.advance(PERIOD)


@pytest.mark.parametrize("factor", [1e3, 1e6])
def test_milliseconds_given_as_seconds_are_refused(factor):
    planner = cv.FormationPlanner(ROOM, SQUARE)
    poses = np.column_stack([SQUARE.placed((2.0, 3.0, 0.0)), np.zeros(4)])
    for cycle in range(3):
        planner.step(poses, factor * PERIOD * cycle)
    with pytest.raises(cv.InputError, match=r"time: advances by .* expected seconds"):
        planner.step(poses, factor * PERIOD * 3)
    with pytest.raises(cv.InputError, match="time: expected"):
        planner.step(poses, 1.8e12)  # since 1970


@pytest.mark.parametrize("per_cycle", [0.02, 0.05, 0.4, 1.0, 4.9])
def test_slow_loops_are_no_milliseconds(per_cycle):
    advanced(per_cycle * np.arange(10))


def test_stamps_move_with_the_clock():
    clock = CycleClock(PERIOD)
    clock.advance(100.0, lambda _: True)
    assert clock.placed(np.array([99.9, 99.0])).tolist() == [99.9, 99.0]
    clock.advance(40.0, lambda _: True)  # set back by a minute and a cycle
    # One measured since, one whose report of before comes now, and next time none anew.
    assert clock.placed(np.array([39.98, 99.95])) == pytest.approx([100.03, 99.95])
    clock.advance(40.05, lambda _: True)
    assert clock.placed(np.array([39.98, 99.95])) == pytest.approx([100.03, 99.95])


def gap_of(tools, poses) -> float:
    pairs = [(i, j) for i in range(4) for j in range(i)]
    near = [(a, b) for a, b in pairs if np.hypot(*(poses[a] - poses[b])[:2]) < 0.8]
    return min((tools.sampled_gap(poses[a], poses[b], BODY, BODY, 0.2) for a, b in near), default=1)


@pytest.fixture(scope="module")
def clutter():
    shapes = cv.generate("clutter", (9.0, 7.0), 3, obstacles=10, require_feasible=True).shapes
    return ROOM.with_shapes(shapes)


@pytest.mark.parametrize(
    ("name", "delay"),
    [*product(CLOCKS, (0.0, 0.3)), *product(("steady", "10 Hz", "stands still"), (0.1,))],
)
def test_commands_under_way_are_not_forgotten(name, delay, tools, clutter):
    """With 0.3 s of delay and a clock of 10 Hz, teams touched things in seven of ten worlds."""
    world = clutter
    planner = cv.FormationPlanner(world, SQUARE, expected=cv.Imperfections(delay=delay))
    planner.set_goal((7.4, 3.5, 0.0))
    starts = np.column_stack([SQUARE.placed((1.6, 3.5, 0.0)), np.zeros(4)])
    fleet = IdealFleet((GO1,) * 4, starts, delay=CommandDelay(delay))
    for cycle in range(600):
        seen = fleet.observe()
        fleet.send(planner.step(seen.poses, CLOCKS[name](seen.time)))
        fleet.advance(PERIOD)
        poses = fleet.true_poses()
        if cycle % 4 == 0:
            assert gap_of(tools, poses) > 0.0
            for pose in poses:
                assert tools.occupied_gap(pose, BODY, world.occupied, 0.05) > 0.0
        if planner.status.arrived:
            break
    assert planner.status.arrived


@pytest.mark.parametrize("step", [-100.0, -0.3, 0.0, 100.0])
def test_a_clock_that_is_set_does_not_silence_deadlock_detection(step):
    """A robot that stands in the way for good: the team is stuck as soon as ever."""
    planner = cv.FormationPlanner(ROOM, SQUARE)
    planner.set_goal((6.0, 3.5, 0.0))
    poses = np.column_stack([SQUARE.placed((2.0, 3.5, 0.0)), np.zeros(4)])
    states = []
    for cycle in range(120):
        planner.step(poses, 200.0 + cycle * PERIOD + step * (cycle > 20))
        states.append(planner.status.state)
    assert states.index("resolving") == pytest.approx(60, abs=8)
