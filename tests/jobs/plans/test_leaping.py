"""Leaps are handed over to fleets that leap by themselves, and taken back where they ended."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.execution.fleets import tracking_model
from cavalcade.execution.leaping import edges_of, leaps_of, request_of
from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.time_scaling import FollowSettings
from cavalcade.fleet import IdealFleet, LeapingFleet, Observation
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF
from cavalcade.jobs import tasks
from cavalcade.jobs.planning import make_plan
from cavalcade.scenario import build_world, load_scenario, parse_scenario, resolve_scenario


class Leapers(IdealFleet):
    """Robots that glide to where they land when they are to leap."""

    approach = 0.4

    def __init__(self, models, poses, takes=2.0, off=(0.05, 0.02, 0.03), fails=False):
        super().__init__([tracking_model(model, True) for model in models], poses)
        self.takes, self.off, self.fails = takes, np.array(off), fails
        self.requests = []
        self.back = np.full(len(models), -1.0)
        self.landing = np.zeros((len(models), 3))
        self.failed = np.zeros(len(models), dtype=bool)

    def leap(self, robot, request):
        assert not self.leaping[robot]
        self.requests.append((robot, self.time, self.true_poses(), request))
        self.back[robot] = self.time + self.takes
        self.landing[robot] = request.landed[[0, 1, 3]] + self.off
        self._velocities[robot] = 0.0

    @property
    def leaping(self):
        return self.back > self.time + 1e-9

    @property
    def leap_failed(self):
        return self.failed

    def send(self, commands):
        super().send(np.where(self.leaping[:, None], 0.0, commands))

    def advance(self, dt):
        before = self.leaping
        super().advance(dt)
        for robot in np.flatnonzero(before & ~self.leaping):
            self.failed[robot] = self.fails
        for robot in np.flatnonzero(before & (not self.fails)):
            left = max(self.back[robot] - self.time, 0.0)
            way = self.landing[robot] - self._poses[robot]
            self._poses[robot] += way * dt / (left + dt)

    def observe(self):
        return Observation(self.time, self.true_poses(), np.full(self.size, self.time))


@pytest.fixture
def planned(make_scenario, straight_team):
    """Paths and models of two robots that cross; the first leaps in mid-way, over the crossing."""
    scenario = make_scenario()
    world = build_world(scenario)
    plan = straight_team(waits=(0.0, 5.5), leaping=(0,))(scenario, world)
    return plan.trajectories, scenario


def follow(paths, scenario, fleet, seconds, settings=None):
    follower = PlanFollower(
        paths, scenario.models, scenario.starts, scenario.goals, 20.0, None,
        settings or FollowSettings(), fleet if isinstance(fleet, LeapingFleet) else None,
    )  # fmt: skip
    seen = []
    while fleet.time < seconds:
        now = fleet.observe()
        fleet.send(follower.step(now.poses, now.time, now.stamps))
        seen.append((fleet.time, follower.progress, fleet.true_poses()))
        fleet.advance(0.05)
    return follower, seen


def test_only_some_fleets_leap(planned):
    _, scenario = planned
    assert isinstance(Leapers(scenario.models, scenario.starts), LeapingFleet)
    assert not isinstance(IdealFleet(scenario.models, scenario.starts), LeapingFleet)


def test_the_request_is_the_plans_leap(planned):
    paths, _ = planned
    path = paths[0]
    (leap,) = leaps_of(path)
    assert leaps_of(paths[1]) == []
    request = request_of(path, leap, None)
    marks = [np.flatnonzero(path.phase == part)[0] for part in (TAKE_OFF, FLIGHT, LANDING)]
    marks.append(int(np.flatnonzero(path.phase == LANDING)[-1]) + 1)
    assert [leap.take_off, leap.lift_off, leap.touch_down, leap.landed] == marks
    for k, pose in zip((marks[0], marks[3]), (request.take_off, request.landed), strict=True):
        np.testing.assert_allclose(pose, [*path.position[k], path.yaw[k]])
    assert request.edges is None


def test_a_robot_is_handed_over_and_goes_on_where_it_landed(planned):
    paths, scenario = planned
    fleet = Leapers(scenario.models, scenario.starts)
    follower, seen = follow(paths, scenario, fleet, 25.0)
    ((robot, moment, poses, _),) = fleet.requests
    assert robot == 0
    # It is handed over at the pace of the plan: nobody has to pass before it.
    (leap,) = leaps_of(paths[0])
    begin, end = paths[0].time[leap.take_off] - 0.4, paths[0].time[leap.landed]
    np.testing.assert_allclose(poses[0, :2], paths[0].poses_at(np.array([begin]))[0, :2], atol=0.06)
    held = [progress[0] for time, progress, _ in seen if moment <= time < moment + 1.95]
    assert np.ptp(held) == 0.0
    assert held[0] == pytest.approx(begin, abs=0.06)
    first = next(progress[0] for time, progress, _ in seen if time > moment + 1.96)
    # 5 cm on at 0.75 m/s.
    assert end <= first <= end + 0.15
    assert first == pytest.approx(end + 0.05 / 0.75, abs=0.03)
    np.testing.assert_allclose(
        fleet.true_poses()[:, :2], np.array(scenario.goals)[:, :2], atol=0.03
    )
    assert follower.delays[0] > 0.5
    # The other one waited: it is in the crossing after the leap has ended.
    there = [time for time, _, pose in seen if abs(pose[1, 1] - 3.0) < 0.5]
    assert min(there) > moment + fleet.takes


def test_nobody_leaps_before_its_turn(make_scenario, straight_team):
    """The robot that leaps is the later one; the first one is held up for long."""
    scenario = make_scenario()
    world = build_world(scenario)
    paths = straight_team(waits=(1.0, 0.0), leaping=(0,))(scenario, world).trajectories

    class Late(Leapers):
        def send(self, commands):
            told = np.array(commands)
            if self.time < 15.0:
                told[1] = 0.0
            super().send(told)

    fleet = Late(scenario.models, scenario.starts)
    _, seen = follow(paths, scenario, fleet, 14.0)
    assert fleet.requests == []
    (leap,) = leaps_of(paths[0])
    begin = paths[0].time[leap.take_off] - 0.4
    _, progress, poses = seen[-1]
    assert progress[0] == pytest.approx(begin, abs=0.05)
    np.testing.assert_allclose(poses[0, :2], paths[0].poses_at(np.array([begin]))[0, :2], atol=0.05)
    fleet = Late(scenario.models, scenario.starts)
    _, seen = follow(paths, scenario, fleet, 45.0)
    ((_, moment, then, _),) = fleet.requests
    assert moment > 15.0
    assert then[1, 1] > 3.0 + 0.14
    np.testing.assert_allclose(seen[-1][2][:, :2], np.array(scenario.goals)[:, :2], atol=0.03)


def test_a_leap_that_fails_is_said(planned):
    paths, scenario = planned
    fleet = Leapers(scenario.models, scenario.starts, fails=True)
    follower, _ = follow(paths, scenario, fleet, 10.0)
    status = follower.status
    assert (status.state, status.involved) == ("stuck", (0,))
    assert status.message == "robot 0 failed to leap"


def side_by_side(make_scenario, straight_team, apart):
    """Two that leap at the same time and place, past each other."""
    ways = [
        ((1.0, 3.0, 0.0), (7.0, 3.0, 0.0)),
        ((7.0, 3.0 + apart, np.pi), (1.0, 3.0 + apart, np.pi)),
    ]
    scenario = make_scenario(robots=ways)
    plan = straight_team(waits=(0.0, 0.0), leaping=(0, 1))(scenario, build_world(scenario))
    return plan.trajectories, scenario, Leapers(scenario.models, scenario.starts)


def test_of_leaps_that_wait_for_each_other_one_begins(make_scenario, straight_team):
    """5 cm apart: nearer than the margin, but nobody touches anybody."""
    paths, scenario, fleet = side_by_side(make_scenario, straight_team, 0.40)
    follower, seen = follow(paths, scenario, fleet, 30.0)
    (_, first, *_), (_, second, *_) = fleet.requests
    assert second >= first + fleet.takes
    np.testing.assert_allclose(seen[-1][2][:, :2], np.array(scenario.goals)[:, :2], atol=0.03)
    assert follower.status.state == "final"


def test_leaps_that_cannot_be_told_apart_end_the_run(make_scenario, straight_team):
    """1 cm apart is less than the cells resolve: either might touch the other."""
    paths, scenario, fleet = side_by_side(make_scenario, straight_team, 0.36)
    follower, _ = follow(paths, scenario, fleet, 20.0)
    assert fleet.requests == []
    assert (follower.status.state, follower.status.involved) == ("stuck", (0, 1))
    assert follower.status.message == "the leap of robot 0 is never free to its end"


def test_an_ideal_fleet_follows_leaps_as_everything_else(planned):
    paths, scenario = planned
    fleet = IdealFleet([tracking_model(m, True) for m in scenario.models], scenario.starts)
    follower, seen = follow(paths, scenario, fleet, 20.0)
    np.testing.assert_allclose(seen[-1][2][:, :2], np.array(scenario.goals)[:, :2], atol=0.03)
    assert follower.status.state == "final"


@pytest.mark.parametrize(("kind", "key", "size"), [("gap", "width", 0.4), ("step", "height", 0.2)])
def test_where_the_ground_breaks(kind, key, size):
    scenario = parse_scenario(
        {
            "version": 1,
            "name": kind,
            "world": {"generate": {"kind": kind, "size": [9, 4], key: size}},
            "robots": [{"model": "spirit", "start": [2, 2, 0], "goal": [7, 2, 0]}],
            "task": {"goals": "individual"},
        }
    )
    terrain = build_world(scenario).terrain
    along = np.arange(3.0, 6.0, 0.01)
    heights = terrain.heights_at(np.column_stack([along, np.full(len(along), 2.0)]))
    near, far = edges_of(terrain, np.array([3.0, 2.0, 0.3, 0.0]), np.array([6.0, 2.0, 0.5, 0.0]))
    steep = along[:-1][np.abs(np.diff(heights)) > 0.01]
    assert 3.0 + near == pytest.approx(steep[0], abs=0.06)
    assert 3.0 + far == pytest.approx(steep[-1], abs=0.06)
    assert far - near == pytest.approx(size if kind == "gap" else 0.0, abs=0.06)
    assert edges_of(terrain, np.array([1.0, 2.0, 0.3, 0.0]), np.array([2.0, 2.0, 0.3, 0.0])) is None


@pytest.mark.slow
def test_a_shipped_leap_is_handed_over_in_a_run(monkeypatch):
    scenario = resolve_scenario(load_scenario("step"))
    world = build_world(scenario)
    made = make_plan(scenario, world)
    monkeypatch.setattr(tasks, "make_plan", lambda *_, **__: made)
    fleets = []

    def fleet(said):
        fleets.append(Leapers(said.models, said.starts, takes=3.0))
        return fleets[0]

    from cavalcade.jobs.running import run

    result = run(scenario, fleet=fleet)
    assert sorted(robot for robot, *_ in fleets[0].requests) == [0, 1]
    assert all(request.edges is not None for *_, request in fleets[0].requests)
    assert result.reason == "arrived"
    assert result.summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 0}
    assert min(result.summary["delay_s"]) > 0.0
