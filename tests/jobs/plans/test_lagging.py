"""Teams whose robots do not do what they are told: nobody meets anybody, and all arrive."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest

from cavalcade.checking.distance import corners, seen_from, to_polygons
from cavalcade.execution.fleets import tracking_fleet, tracking_model
from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.time_scaling import EXACT, FollowSettings
from cavalcade.fleet import IdealFleet
from cavalcade.geometry import wrap_angle
from cavalcade.jobs.planning import make_plan
from cavalcade.scenario import build_world, load_scenario, resolve_scenario

CLOCK = FollowSettings(in_order=False)
FINE = 4


class LaggingFleet(IdealFleet):
    """Robots up to 30 % too slow that stop or turn a deaf ear for times drawn at random."""

    def __init__(self, models, poses, seed, pauses=1.0, deaf=0.15):
        super().__init__([tracking_model(model, False) for model in models], poses)
        self.random = np.random.default_rng(seed)
        self.gain = self.random.uniform(0.7, 1.0, len(models))
        self.pauses, self.deaf = pauses, deaf
        self.until = np.zeros(len(models))
        self.state = np.zeros(len(models), dtype=int)
        self.last = np.zeros((len(models), 3))

    def send(self, commands):
        told = np.array(commands)
        for k in range(len(told)):
            if self.time >= self.until[k]:
                self.state[k] = self.random.choice(3, p=(0.5, 0.2, 0.3)) if not self.state[k] else 0
                length = (2.5, self.pauses, 0.0)[self.state[k]]
                wait = self.random.uniform(0.0, self.deaf) + self.random.exponential(length)
                self.until[k] = self.time + wait
            if self.state[k]:
                told[k] = 0.0 if self.state[k] == 1 else self.last[k]
        self.last = told
        super().send(told * self.gain[:, None])


class StuckFleet(LaggingFleet):
    """One robot stands dead for some time."""

    def __init__(self, models, poses, robot, since, until):
        super().__init__(models, poses, 0)
        self.who, self.since, self.back = robot, since, until

    def send(self, commands):
        told = np.array(commands)
        if self.since <= self.time < self.back:
            told[self.who] = 0.0
        IdealFleet.send(self, told)


@cache
def shipped(name):
    scenario = resolve_scenario(load_scenario(name))
    made = make_plan(scenario, build_world(scenario))
    return made.trajectories, scenario.models


def carried(paths, models, fleet, settings, longest=150.0, rate=20.0):
    """The follower and all poses `(T, N, 3)` until everybody stands at its goal, or time is up."""
    starts = [path.poses_at(np.zeros(1))[0] for path in paths]
    goals = np.array([path.poses_at(np.array([path.duration]))[0] for path in paths])
    follower = PlanFollower(paths, models, starts, goals, rate, None, settings)
    poses, still = [fleet.true_poses()], 0
    while still < 10 and fleet.time < longest:
        seen = fleet.observe()
        fleet.send(follower.step(seen.poses, seen.time, seen.stamps))
        for _ in range(FINE):
            fleet.advance(1.0 / rate / FINE)
            poses.append(fleet.true_poses())
        off = poses[-1] - goals
        near = np.hypot(off[:, 0], off[:, 1]).max() < 0.05
        still = still + 1 if near and np.abs(wrap_angle(off[:, 2])).max() < 0.08 else 0
    return follower, np.array(poses), still == 10


def least_gap(poses, models):
    """Between footprints, as the checker measures it, m."""
    halves = [0.5 * np.array([model.length, model.width]) for model in models]
    return min(
        to_polygons(halves[i], seen_from(poses[:, i], corners(poses[:, j], halves[j]))).min()
        for i, j in combinations(range(len(models)), 2)
    )


SHIPPED = ("hexagon-swap", "alcove", "head-on", "corner-swap")


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_teams(name):
    paths, models = shipped(name)
    met = 0
    for seed in range(3):
        starts = [path.poses_at(np.zeros(1))[0] for path in paths]
        follower, poses, done = carried(
            paths, models, LaggingFleet(models, starts, seed), FollowSettings()
        )
        assert done, (seed, follower.progress)
        assert least_gap(poses, models) > 0.0, seed
        assert (follower.delays >= 0.0).all()
        assert follower.delays.max() > 0.0
        # By the clock they run into each other, so the test can fail.
        if met < 1:
            _, poses, _ = carried(paths, models, LaggingFleet(models, starts, seed), CLOCK)
            met += least_gap(poses, models) <= 0.0
    assert met >= 1


def test_crowds(crowd):
    met = 0
    for seed in range(6):
        paths, models = crowd(seed)
        starts = [path.poses_at(np.zeros(1))[0] for path in paths]
        follower, poses, done = carried(
            paths, models, LaggingFleet(models, starts, seed, pauses=2.0), FollowSettings()
        )
        assert done, (seed, follower.progress)
        assert least_gap(poses, models) > 0.0, seed
        if met < 2:
            fleet = LaggingFleet(models, starts, seed, pauses=2.0)
            _, poses, _ = carried(paths, models, fleet, CLOCK)
            met += least_gap(poses, models) <= 0.0
    assert met >= 2


@pytest.mark.parametrize("robot", range(4))
def test_one_that_stands_is_waited_for_by_those_after_it_alone(robot):
    paths, models = shipped("corner-swap")
    starts = [path.poses_at(np.zeros(1))[0] for path in paths]
    fleet = StuckFleet(models, starts, robot, 2.0, 30.0)
    follower, poses, done = carried(paths, models, fleet, FollowSettings(), longest=28.0)
    assert not done
    assert least_gap(poses, models) > 0.0
    order = follower._scaling.precedence
    bounds = order.bounds(follower._scaling.sure)
    for k in range(len(paths)):
        # Held up where it is not its turn, or at the end of its way.
        at_bound = bounds[k] - follower.progress[k] < 0.1
        assert k == robot or at_bound or follower.progress[k] >= paths[k].duration
    fleet = StuckFleet(models, starts, robot, 2.0, 30.0)
    follower, poses, done = carried(paths, models, fleet, FollowSettings())
    assert done
    assert least_gap(poses, models) > 0.0


@pytest.mark.parametrize("name", SHIPPED)
def test_ideal_robots_follow_as_if_by_the_clock(name):
    paths, models = shipped(name)
    scenario = resolve_scenario(load_scenario(name))
    ways = []
    for settings in (EXACT, replace(EXACT, in_order=False)):
        _, poses, done = carried(paths, models, tracking_fleet(scenario, paths), settings)
        assert done
        ways.append(poses)
    np.testing.assert_array_equal(*ways)
    _, poses, done = carried(paths, models, tracking_fleet(scenario, paths), FollowSettings())
    assert done
    # Those who may not rely on each other keep a distance; it takes hardly any longer.
    assert len(poses) < len(ways[0]) + 2.0 * 20 * FINE


def test_rates_change_smoothly(crowd):
    paths, models = crowd(3)
    starts = [path.poses_at(np.zeros(1))[0] for path in paths]
    goals = [path.poses_at(np.array([path.duration]))[0] for path in paths]
    fleet = LaggingFleet(models, starts, 4)
    follower = PlanFollower(paths, models, starts, goals, 20.0, None, FollowSettings())
    before, falls = np.ones(len(paths)), []
    progress = np.zeros(len(paths))
    for _ in range(500):
        seen = fleet.observe()
        fleet.send(follower.step(seen.poses, seen.time, seen.stamps))
        fleet.advance(0.05)
        rates = follower._scaling.rates.copy()
        assert ((rates >= 0.0) & (rates <= 1.0)).all()
        assert (follower.progress >= progress - 1e-9).all()
        falls.append(before - rates)
        before, progress = rates, follower.progress
    # 1 m/s² at 0.75 m/s; harder only where somebody stopped without warning.
    gentle = 0.05 / 0.75 + 1e-9
    assert np.max(falls) <= 2.5 * gentle
    assert np.mean(np.array(falls) <= gentle) > 0.99
    assert -np.min(falls) <= gentle


def test_time_without_commands_is_no_progress(straight_way):
    path = straight_way((0.0, 0.0, 0.0), (6.0, 0.0, 0.0))
    model = shipped("head-on")[1][0]
    follower = PlanFollower([path], [model], [(0, 0, 0)], [(6, 0, 0)], 20.0)
    for k in range(40):
        now = 0.05 * k
        follower.step(path.poses_at(np.array([now])), now, np.array([now]))
    assert follower.progress[0] == pytest.approx(1.95)
    follower.pause()
    follower.resume()
    held = path.poses_at(np.array([1.95]))
    command = follower.step(held, 31.95, np.array([31.95]))
    assert follower.progress[0] < 2.1
    assert np.abs(command).max() < 0.2


def test_small_errors_are_left_alone_at_rest(straight_way):
    path = straight_way((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    model = shipped("head-on")[1][0]
    goal = np.array([[1.0, 0.0, 0.0]])

    def commands(offsets, settings):
        follower = PlanFollower([path], [model], [(0, 0, 0)], goal, 20.0, None, settings)
        for k in range(80):
            now = 0.05 * k
            follower.step(path.poses_at(np.array([now])), now, np.array([now]))
        return [
            np.abs(follower.step(goal + np.array([[x, 0.0, 0.0]]), 4.0 + 0.05 * k,
                                 np.array([4.0 + 0.05 * k]))).max()
            for k, x in enumerate(offsets)
        ]  # fmt: skip

    moves = np.array(commands([0.02, 0.008, 0.025, 0.035, 0.02, 0.005], FollowSettings())) > 0.0
    assert moves.tolist() == [False, False, False, True, True, False]
    assert min(commands([0.02, 0.008], EXACT)) > 0.0


def test_corrections_are_bounded(straight_way):
    path = straight_way((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    model = shipped("head-on")[1][0]
    follower = PlanFollower([path], [model], [(0, 0, 0)], [(1, 0, 0)], 20.0)
    command = follower.step(np.array([[-3.0, 4.0, 2.0]]), 0.0, np.zeros(1))[0]
    assert np.hypot(*command[:2]) <= 0.3 + 0.1
    assert abs(command[2]) <= 0.6
