"""The control cycle and its supervisor: who is commanded what, and when."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cavalcade.execution.control import ControlLoop
from cavalcade.execution.supervisor import Supervisor
from cavalcade.fleet import CommandDelay, IdealFleet, Observation
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

SLOTS = ((0.0, 1.0), (0.0, 0.0), (0.0, -1.0))
STARTS = [(2.0, 4.0, 0.0), (2.0, 3.0, 0.0), (2.0, 2.0, 0.0)]
AREA = OccupancyMap.empty((12.0, 6.0))


class Bench:
    """A loop over an ideal fleet whose reports can be spoilt; keeps every command sent."""

    def __init__(self, planner: Any, **fleet: Any) -> None:
        models = [robot_model("go1")] * 3
        self.fleet = IdealFleet(models, STARTS, **fleet)
        self.planner = planner
        self.loop = ControlLoop(planner, self.fleet, Supervisor(models, 0.05, area=AREA))
        self.sent: list[np.ndarray] = []
        self.spoil: Any = None
        observe, send = self.fleet.observe, self.fleet.send

        def seen() -> Observation:
            observation = observe()
            if self.spoil is not None:
                self.spoil(observation.poses)
            return observation

        def noted(commands: Any) -> None:
            self.sent.append(np.array(commands))
            send(commands)

        self.fleet.observe = seen  # type: ignore[method-assign]
        self.fleet.send = noted  # type: ignore[method-assign]

    def cycles(self, count: int) -> None:
        for _ in range(count):
            self.loop.send(self.loop.plan().commands)
            self.fleet.advance(0.05)


@pytest.fixture
def bench(straight: Any, make_scenario: Any) -> Bench:
    scenario = make_scenario(robots=3, goal=(8.0, 3.0, 0.0))
    planner = straight(scenario, None)
    planner.slots = np.array(SLOTS)
    return Bench(planner)


def nonsense(poses: np.ndarray) -> None:
    poses[1, 0] = np.nan


def outside(poses: np.ndarray) -> None:
    poses[1, 1] = -1.0


def elsewhere(poses: np.ndarray) -> None:
    poses[1, 0] += 2.0


@pytest.mark.parametrize("spoil", [nonsense, outside, elsewhere])
def test_a_fault_stops_the_whole_team_in_the_same_cycle(bench: Bench, spoil: Any) -> None:
    bench.cycles(20)
    assert np.all(bench.sent[-1][:, 0] > 0.3)
    bench.spoil = spoil
    bench.cycles(1)
    assert np.array_equal(bench.sent[-1], np.zeros((3, 3)))
    assert bench.planner.paused
    bench.cycles(12)
    assert np.array_equal(bench.fleet.true_velocities(), np.zeros((3, 3)))


def test_a_robot_that_stops_answering_is_noticed_after_half_a_second(bench: Bench) -> None:
    bench.cycles(20)
    bench.fleet.silence(1)
    bench.cycles(11)
    assert np.any(bench.sent[-1] != 0.0)
    bench.cycles(1)
    assert np.array_equal(bench.sent[-1], np.zeros((3, 3)))


def test_sound_data_alone_do_not_start_the_team_again(bench: Bench) -> None:
    bench.cycles(10)
    bench.spoil = nonsense
    bench.cycles(1)
    bench.spoil = None
    planned = bench.planner.steps
    bench.cycles(20)
    assert bench.planner.steps == planned
    assert all(np.array_equal(sent, np.zeros((3, 3))) for sent in bench.sent[-20:])
    bench.loop.resume()
    bench.cycles(1)
    assert np.any(bench.sent[-1] != 0.0)
    assert not bench.planner.paused


def test_resuming_while_the_fault_lasts_does_nothing(bench: Bench) -> None:
    bench.cycles(10)
    bench.fleet.silence(0)
    bench.cycles(13)
    bench.loop.resume()
    bench.cycles(2)
    assert np.array_equal(bench.sent[-1], np.zeros((3, 3)))
    bench.fleet.revive(0)
    bench.cycles(2)
    assert np.array_equal(bench.sent[-1], np.zeros((3, 3)))
    bench.loop.resume()
    bench.cycles(1)
    assert np.any(bench.sent[-1] != 0.0)


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
def test_however_the_loop_is_left_the_last_command_is_zero(
    bench: Bench, error: type[BaseException]
) -> None:
    def leave() -> None:
        with bench.loop:
            bench.cycles(20)
            raise error

    with pytest.raises(error):
        leave()
    assert np.array_equal(bench.sent[-1], np.zeros((3, 3)))
    bench.fleet.advance(1.0)
    assert np.array_equal(bench.fleet.true_velocities(), np.zeros((3, 3)))


def test_the_team_goes_on_without_a_robot_known_to_be_lost(bench: Bench) -> None:
    bench.cycles(20)
    bench.fleet.silence(2)
    bench.loop.lose(2)
    bench.cycles(40)
    assert bench.planner.called("lose") == [(2,)]
    assert np.all(bench.sent[-1][:2, 0] > 0.0)
    assert np.array_equal(bench.sent[-1][2], np.zeros(3))
    bench.fleet.revive(2)
    bench.cycles(1)
    bench.loop.rejoin(2)
    bench.cycles(1)
    assert bench.planner.called("rejoin") == [(2,)]
    assert np.any(bench.sent[-1][2] != 0.0)


def test_a_policy_that_was_exchanged_is_the_one_that_hears_of_lost_robots(
    bench: Bench, straight: Any, make_scenario: Any
) -> None:
    bench.cycles(1)
    other = straight(make_scenario(robots=3, goal=(8.0, 3.0, 0.0)), None)
    bench.loop.policy = other
    bench.loop.lose(2)
    bench.loop.rejoin(2)
    assert (other.called("lose"), other.called("rejoin")) == ([(2,)], [(2,)])
    assert bench.planner.called("lose") == []


def test_the_planner_never_sees_nonsense_of_a_lost_robot(bench: Bench) -> None:
    bench.cycles(5)
    bench.loop.lose(1)
    seen: list[np.ndarray] = []
    step = bench.planner.step

    def watched(poses: np.ndarray, time: float, stamps: np.ndarray) -> np.ndarray:
        seen.append(poses)
        return step(poses, time)

    bench.planner.step = watched
    bench.spoil = nonsense
    bench.cycles(5)
    assert all(np.isfinite(poses).all() for poses in seen)
    assert np.ptp([poses[1] for poses in seen], axis=0).max() == 0.0
    assert len({poses[0, 0] for poses in seen}) == 5


def test_nor_a_time_that_is_none(bench: Bench) -> None:
    bench.cycles(5)
    bench.loop.lose(1)
    bench.cycles(1)
    known = bench.fleet.time - 0.05
    seen: list[np.ndarray] = []
    step, observe = bench.planner.step, bench.fleet.observe

    def watched(poses: np.ndarray, time: float, stamps: np.ndarray) -> np.ndarray:
        seen.append(stamps)
        return step(poses, time)

    def timeless() -> Observation:
        observation = observe()
        observation.stamps[1] = np.nan
        return observation

    bench.planner.step, bench.fleet.observe = watched, timeless  # type: ignore[method-assign]
    bench.cycles(5)
    assert [stamps[1] for stamps in seen] == pytest.approx([known] * 5)
    assert len({stamps[0] for stamps in seen}) == 5


def test_lossy_radio_does_not_trip_the_supervisor(straight: Any, make_scenario: Any) -> None:
    planner = straight(make_scenario(robots=3, goal=(8.0, 3.0, 0.0)), None)
    planner.slots = np.array(SLOTS)
    lossy = Bench(planner, delay=CommandDelay(mean=0.05, jitter=0.02, drop=0.2), seed=2)
    lossy.cycles(320)
    assert not planner.paused
    assert lossy.fleet.true_poses()[:, 0] == pytest.approx(8.0, abs=0.05)
