"""Goals of single robots that change while they are driven to: no contacts, no surprises."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.coordination import PlanSettings
from cavalcade.errors import InputError
from cavalcade.execution.fleets import tracking_model
from cavalcade.execution.individual_navigator import PLANNING, AtOnce, IndividualNavigator
from cavalcade.fleet import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.geometry.distances import nearest_gaps
from cavalcade.robots import robot_model
from cavalcade.world import Box

SPIRIT = robot_model("spirit")
PERIOD, STEP = 0.05, 0.01
HALL = cv.OccupancyMap.empty((14.0, 14.0), 0.05)
NOISY: dict[str, Any] = {
    "noise": LocalisationNoise(0.02, 0.02),
    "delay": CommandDelay(0.05, 0.02, 0.05),
}


class Later(Executor):
    """Work is done at once, or when `work` is called."""

    def __init__(self, at_once: bool = True) -> None:
        self.at_once = at_once
        self.waiting: list[Callable[[], None]] = []

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        if self.at_once:
            return AtOnce().submit(fn, *args, **kwargs)
        future: Future[Any] = Future()
        self.waiting.append(lambda: future.set_result(fn(*args, **kwargs)))
        return future

    def work(self) -> None:
        waiting, self.waiting = self.waiting, []
        for one in waiting:
            one()


class Drive:
    """A navigator, its robots, and what became of them every 10 ms."""

    def __init__(
        self, starts: Any, at_once: bool = True, executor: Executor | None = None,
        map: cv.OccupancyMap = HALL, model: Any = SPIRIT, settings: Any = PLANNING,
        seed: int = 0, **imperfect: Any,
    ) -> None:  # fmt: skip
        self.worker = Later(at_once)
        starts = np.array(starts, dtype=float)
        models = [model] * len(starts)
        self.navigator = IndividualNavigator(
            models, map, 1.0 / PERIOD, settings, executor=executor or self.worker
        )
        self.fleet = IdealFleet(
            [tracking_model(one, False) for one in models], starts, seed=seed, **imperfect
        )
        self.bodies = np.array([one.body for one in models])
        self.track = [self.fleet.true_poses()]
        self.commands = [np.zeros_like(starts)]

    @property
    def status(self) -> Any:
        return self.navigator.status

    def cycle(self) -> np.ndarray:
        seen = self.fleet.observe()
        commands = self.navigator.step(seen.poses, seen.time, seen.stamps)
        assert np.isfinite(commands).all()
        self.commands.append(commands)
        self.fleet.send(commands)
        for _ in range(round(PERIOD / STEP)):
            self.fleet.advance(STEP)
            self.track.append(self.fleet.true_poses())
        return commands

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        for _ in range(round(seconds / PERIOD)):
            self.cycle()
            if until():
                return True
        return False

    def arrive(self, seconds: float = 90.0) -> bool:
        return self.run(seconds, lambda: self.status.arrived)

    def gap(self) -> float:
        """The least between two bodies so far, m."""
        return float(nearest_gaps(np.array(self.track), self.bodies).min())

    def at(self, robot: int, goal: Any) -> bool:
        x, y, yaw = self.fleet.true_poses()[robot]
        near = math.hypot(x - goal[0], y - goal[1]) < 0.15
        return near and abs(math.remainder(yaw - goal[2], math.tau)) < 0.2


def circle(count: int, radius: float = 4.0, turned: float = 0.0) -> list[tuple[float, ...]]:
    """Poses that face the middle of the hall."""
    angles = [turned + math.tau * k / count for k in range(count)]
    return [(7.0 + radius * math.cos(a), 7.0 + radius * math.sin(a), facing(a)) for a in angles]


def facing(angle: float) -> float:
    return math.remainder(angle + math.pi, math.tau)


def across(starts: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    half = len(starts) // 2
    return [(*starts[(k + half) % len(starts)][:2], pose[2]) for k, pose in enumerate(starts)]


def ordered(drive: Drive, goals: Any) -> None:
    for robot, goal in enumerate(goals):
        drive.navigator.set_goal(robot, goal)


@pytest.mark.parametrize(("seed", "robots"), [*((seed, 6) for seed in range(6)), (6, 8), (7, 8)])
def test_robots_meet_nobody_though_goals_change_on_the_way(seed: int, robots: int) -> None:
    rng = np.random.default_rng(seed)
    starts = circle(robots)
    drive = Drive(starts, seed=seed, **NOISY)
    goals = across(starts)
    ordered(drive, goals)
    spare = [*circle(4, 2.0, 0.3), *circle(4, 6.3, 0.4)]
    for place in rng.permutation(len(spare))[: rng.integers(1, 4)]:
        drive.run(rng.uniform(0.0, 6.0))
        robot = int(rng.integers(robots))
        goals[robot] = spare[place]
        drive.navigator.set_goal(robot, spare[place])
    assert drive.arrive(), drive.status
    assert drive.gap() > 0.0
    assert all(drive.at(robot, goal) for robot, goal in enumerate(goals))
    assert not drive.status.message
    assert (drive.status.eta == 0.0).all()


def test_a_goal_that_is_replaced_before_its_plan_is_made_is_never_driven_to() -> None:
    drive = Drive([(3.0, 7.0, 0.0)], at_once=False)
    drive.navigator.set_goal(0, (11.0, 7.0, 0.0))
    drive.run(1.0)
    drive.navigator.set_goal(0, (3.0, 10.0, math.pi / 2.0))
    drive.run(0.5)
    drive.worker.work()  # the first plan, which nobody wants any more
    assert drive.status.state == "partial"
    for _ in range(3):
        drive.run(0.2)
        drive.worker.work()
    assert drive.arrive()
    assert max(pose[0, 0] for pose in drive.track) < 4.5
    assert drive.at(0, (3.0, 10.0, math.pi / 2.0))


def test_robots_go_on_in_their_order_while_a_plan_is_made() -> None:
    starts = circle(4)
    drive = Drive(starts)
    ordered(drive, across(starts))
    drive.run(4.0)
    drive.worker.at_once = False
    drive.navigator.set_goal(1, (7.0, 12.0, 0.0))
    drive.run(5.0)
    assert drive.status.state == "partial"
    assert not drive.status.arrived
    assert drive.status.eta[1] == math.inf
    assert np.abs(drive.commands[-1]).max() == 0.0  # they wait at rest, however long it takes
    drive.worker.work()
    drive.worker.at_once = True
    assert drive.arrive()
    assert drive.gap() > 0.0


def test_ramps_of_pause_and_resume_keep_to_the_limits() -> None:
    starts = circle(4)
    drive = Drive(starts)
    ordered(drive, across(starts))
    drive.run(4.0)
    assert np.hypot(*drive.commands[-1][:, :2].T).max() > 0.3
    drive.navigator.pause()
    assert drive.run(3.0, lambda: not drive.commands[-1].any())
    assert drive.status.state == "paused"
    drive.run(5.0)
    assert not np.array(drive.commands[-100:]).any()
    drive.navigator.resume()
    assert drive.arrive()
    assert drive.gap() > 0.0
    legs = SPIRIT.legs
    assert legs is not None
    speeds = np.hypot(*np.array(drive.commands)[:, :, :2].transpose(2, 0, 1))
    assert np.abs(np.diff(speeds, axis=0)).max() <= 2.0 * legs.acceleration * PERIOD


def test_goals_while_paused_are_driven_to_after_it() -> None:
    drive = Drive([(3.0, 7.0, 0.0)])
    drive.navigator.pause()
    drive.navigator.set_goal(0, (6.0, 7.0, 0.0))
    drive.run(3.0)
    assert not np.array(drive.commands).any()
    assert drive.status.state == "paused"
    drive.navigator.resume()
    assert drive.arrive()


@pytest.mark.parametrize("told", [True, False])
def test_a_robot_that_fails_is_named_and_the_others_arrive(told: bool) -> None:
    starts = circle(6)
    drive = Drive(starts, **NOISY)
    goals = across(starts)
    ordered(drive, goals)
    drive.run(5.0)
    drive.fleet.disable(2)
    if told:
        drive.run(2.0)
        drive.navigator.lose(2)
        assert drive.arrive()
        others = [k for k in range(6) if k != 2 and not drive.status.message]
        assert all(drive.at(k, goals[k]) for k in others)
        assert drive.status.eta[2] == math.inf
        drive.fleet.enable(2)
        drive.navigator.rejoin(2)
        assert drive.arrive()
        assert drive.at(2, goals[2])
    else:
        assert drive.run(60.0, lambda: 2 in drive.status.involved)
        assert "robot 2" in drive.status.message
        drive.run(20.0)
        assert not drive.status.arrived
        drive.fleet.enable(2)
        assert drive.arrive()
    assert drive.gap() > 0.0


def test_a_map_that_closes_the_way_stops_who_would_meet_it_and_sends_him_round() -> None:
    drive = Drive([(3.0, 7.0, 0.0), (3.0, 2.0, 0.0)])
    ordered(drive, [(11.0, 7.0, 0.0), (11.0, 2.0, 0.0)])
    drive.run(5.0)
    x = drive.fleet.true_poses()[0, 0]
    wall = Box((float(x) + 1.0, 7.0), (0.2, 3.0))
    drive.navigator.set_map(HALL.with_shapes([wall]))
    assert drive.arrive()
    half = 0.5 * math.hypot(SPIRIT.length, SPIRIT.width)
    places = np.array(drive.track)[:, 0, :2]
    assert float(wall.distance(places).min()) > 0.5 * SPIRIT.width
    assert half < 0.5


def test_a_map_without_a_way_is_said_and_a_later_one_tried() -> None:
    drive = Drive([(3.0, 7.0, 0.0), (3.0, 2.0, 0.0)])
    ordered(drive, [(11.0, 7.0, 0.0), (5.0, 2.0, 0.0)])
    drive.run(3.0)
    drive.navigator.set_map(HALL.with_shapes([Box((8.0, 7.0), (0.2, 14.0))]))
    assert not drive.arrive(20.0)
    assert drive.status.state == "infeasible"
    assert drive.status.involved == (0,)
    assert "robot 0" in drive.status.message
    assert drive.at(1, (5.0, 2.0, 0.0))
    drive.navigator.set_map(HALL)
    assert drive.arrive()
    assert drive.at(0, (11.0, 7.0, 0.0))


def test_a_map_with_an_obstacle_far_from_all_plans_stops_nobody() -> None:
    drive = Drive([(3.0, 7.0, 0.0)])
    drive.navigator.set_goal(0, (11.0, 7.0, 0.0))
    drive.run(5.0)
    drive.navigator.set_map(HALL.with_shapes([Box((7.0, 12.0), (1.0, 1.0))]))
    drive.run(1.0)
    assert np.array(drive.commands[-20:])[:, 0, 0].min() > 0.3


def test_a_goal_that_is_refused_leaves_the_robots_their_plan() -> None:
    starts = circle(4)
    goals = across(starts)
    drive = Drive(starts, map=HALL.with_shapes([Box((1.0, 1.0), (1.0, 1.0))]))
    ordered(drive, goals)
    drive.run(3.0)
    drive.navigator.set_goal(2, (1.0, 1.0, 0.0))
    drive.run(3.0)
    assert drive.status.involved == (2,)
    assert "goal of robot 2 refused" in drive.status.message
    assert "occupied cell" in drive.status.message
    assert not drive.arrive(40.0)  # one was told otherwise
    assert drive.status.state == "infeasible"
    assert all(drive.at(robot, goal) for robot, goal in enumerate(goals))
    drive.navigator.set_goal(2, goals[2])
    assert drive.arrive(2.0)


def test_goals_of_a_swap_may_come_one_after_the_other() -> None:
    starts = [(4.0, 7.0, 0.0), (10.0, 7.0, math.pi)]
    drive = Drive(starts)
    drive.navigator.set_goal(0, (10.0, 7.0, 0.0))
    drive.run(3.0)
    assert drive.status.message.startswith("goal of robot 0 refused: robot 1 is in its place")
    drive.navigator.set_goal(1, (4.0, 7.0, math.pi))
    assert drive.arrive()
    assert drive.at(0, (10.0, 7.0, 0.0))
    assert drive.gap() > 0.0


def test_a_robot_that_was_carried_off_its_plan_goes_on_from_there() -> None:
    drive = Drive([(3.0, 7.0, 0.0), (3.0, 3.0, 0.0)])
    ordered(drive, [(11.0, 7.0, 0.0), (11.0, 3.0, 0.0)])
    drive.run(4.0)
    drive.fleet._poses[0] = (5.0, 10.0, 2.0)
    drive.run(0.2)
    assert not drive.commands[-1][0].any()
    assert drive.arrive()
    assert all(drive.at(k, (11.0, y, 0.0)) for k, y in ((0, 7.0), (1, 3.0)))


def test_robots_that_somebody_else_has_driven_meanwhile_are_not_sent_back() -> None:
    drive = Drive([(3.0, 7.0, 0.0), (3.0, 3.0, 0.0)])
    ordered(drive, [(6.0, 7.0, 0.0), (6.0, 3.0, 0.0)])
    assert drive.arrive()
    drive.fleet._poses[:] = (10.0, 7.0, 3.0), (10.0, 3.0, 3.0)
    drive.fleet.advance(30.0)
    drive.navigator.set_goal(0, (11.0, 10.0, 0.0))
    drive.navigator.set_goal(1, None)
    drive.run(0.5)
    assert not np.array(drive.commands[-10:]).any()
    assert drive.arrive()
    assert drive.at(1, (10.0, 3.0, 3.0))
    assert drive.at(0, (11.0, 10.0, 0.0))


def test_a_supervisor_stops_live_goals_and_they_go_on_from_rest() -> None:
    starts = circle(4)
    drive = Drive(starts)
    team = cv.SupervisedPlanner(drive.navigator, models=["spirit"] * 4, rate=20.0, area=HALL)
    ordered(drive, across(starts))
    for cycle in range(2400):
        seen = drive.fleet.observe()
        if 100 <= cycle < 110:
            seen.poses[1] = np.nan
        commands = team.step(seen.poses, seen.time, seen.stamps)
        if 100 <= cycle < 200:
            assert not commands.any()
            assert team.status.state == "stopped"
            assert not team.status.arrived
        if cycle == 199:
            team.resume()
        drive.fleet.send(commands)
        for _ in range(5):
            drive.fleet.advance(STEP)
            drive.track.append(drive.fleet.true_poses())
        if team.status.arrived:
            break
    assert team.status.arrived
    assert drive.gap() > 0.0


def test_a_robot_without_a_goal_steps_aside_and_returns() -> None:
    lane = HALL.with_shapes([Box((7.0, 5.6), (12.0, 1.4)), Box((7.0, 8.4), (12.0, 1.4))])
    drive = Drive([(1.0, 7.0, 0.0), (11.0, 7.0, 0.0)], map=lane)
    drive.navigator.set_goal(0, (13.4, 7.0, 0.0))
    drive.arrive()
    assert drive.status.arrived or drive.status.message
    assert drive.gap() > 0.0


def test_what_is_malformed_is_refused() -> None:
    drive = Drive([(3.0, 7.0, 0.0)])
    with pytest.raises(InputError):
        drive.navigator.set_goal(1, (0.0, 0.0, 0.0))
    with pytest.raises(InputError):
        drive.navigator.set_goal(0, (math.nan, 0.0, 0.0))
    with pytest.raises(InputError):
        drive.navigator.step(np.full((1, 3), np.nan), 0.0, np.zeros(1))
    with pytest.raises(InputError):
        IndividualNavigator([], HALL, 20.0)


def test_a_planner_that_fails_is_no_secret(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = Drive([(3.0, 7.0, 0.0)])

    def broken(*_: Any) -> None:
        raise RuntimeError("broken")

    monkeypatch.setattr("cavalcade.execution.individual_navigator.answer", broken)
    drive.navigator.set_goal(0, (5.0, 7.0, 0.0))
    with pytest.raises(RuntimeError, match="broken"):
        drive.run(2.0)


def test_a_plan_that_exceeds_its_budget_moves_nobody_and_is_said() -> None:
    settings = PlanSettings(iterations=1)
    drive = Drive([(3.0, 7.0, 0.0)], map=HALL.with_shapes([Box((6.0, 7.0), (0.2, 8.0))]),
                  settings=settings)  # fmt: skip
    drive.navigator.set_goal(0, (11.0, 7.0, 0.0))
    drive.run(3.0)
    assert drive.status.state == "infeasible"
    assert "1 iterations" in drive.status.message
    assert not np.array(drive.commands).any()


def test_any_thread_may_call() -> None:
    starts = circle(8)
    drive = Drive(starts)
    navigator = IndividualNavigator([SPIRIT] * 8, HALL, 20.0)
    stop, errors = threading.Event(), []

    def call(number: int) -> None:
        rng = np.random.default_rng(number)
        places = circle(10, 5.0, 0.2)
        try:
            while not stop.is_set():
                robot = int(rng.integers(8))
                match int(rng.integers(6)):
                    case 0:
                        navigator.set_goal(robot, places[number])
                    case 1:
                        navigator.set_map(HALL.with_shapes([Box((7.0, 7.0), (0.5, 0.5 + number))]))
                    case 2:
                        navigator.lose(robot)
                        navigator.rejoin(robot)
                    case 3:
                        navigator.pause()
                        navigator.resume()
                    case 4:
                        navigator.set_goal(robot, None)
                    case _:
                        status = navigator.status
                        assert len(status.eta) == len(status.paths) == len(status.roles) == 8
                stop.wait(0.02)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=call, args=(k,), name=f"caller {k}") for k in range(10)]
    for thread in threads:
        thread.start()
    drive.navigator = navigator
    drive.run(10.0)
    stop.set()
    for thread in threads:
        thread.join()
    assert not errors
    goals = across(starts)
    ordered(drive, goals)
    navigator.set_map(HALL)
    assert drive.arrive(300.0)
    navigator.close()
    assert drive.gap() > 0.0
    assert not drive.navigator.step(drive.track[-1], 1e4, np.full(8, 1e4)).any()
