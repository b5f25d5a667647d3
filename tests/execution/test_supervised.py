"""Own loops under a supervisor: nothing moves by poses that nobody can rely on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cavalcade as cv
from cavalcade.fleet import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import robot_model

GO1 = robot_model("go1")
ROOM = cv.OccupancyMap.empty((8.0, 5.0), 0.05)
SQUARE = cv.Formation.square()
STARTS = np.column_stack([SQUARE.placed((1.5, 2.5, 0.0)), np.zeros(4)])


class Loop:
    """A loop over ideal robots, of which one can be lost to the localisation or fail."""

    def __init__(self, expected: cv.Imperfections | None = None, **allowed: Any) -> None:
        expected = expected or cv.Imperfections()
        planner = cv.FormationPlanner(ROOM, SQUARE, expected=expected)
        planner.set_goal((5.2, 2.5, 0.0))
        self.team = cv.SupervisedPlanner(planner, cv.Supervision(**allowed))
        self.planner = planner
        noise = LocalisationNoise(expected.position, expected.heading)
        self.fleet = IdealFleet((GO1,) * 4, STARTS, noise=noise, delay=CommandDelay(expected.delay))
        self.stamped = True
        self.spoil: Any = lambda poses, stamps: None
        self.lost: tuple[int, ...] = ()

    def run(self, seconds: float) -> np.ndarray:
        """Until the team says that it has arrived, but no longer; the last commands."""
        commands = np.zeros((4, 3))
        for _ in range(round(seconds / 0.05)):
            seen = self.fleet.observe()
            self.spoil(seen.poses, seen.stamps)
            commands = self.team.step(seen.poses, seen.time, seen.stamps if self.stamped else None)
            self.lost += self.team.report.unresponsive
            self.fleet.send(commands)
            if self.team.status.arrived:
                break
            self.fleet.advance(0.05)
        return commands


def frozen(robot: int, fleet: IdealFleet) -> Any:
    """A body of which motion capture reports the last pose, with its stamp, for ever."""
    known = fleet.observe()

    def spoil(poses: np.ndarray, stamps: np.ndarray) -> None:
        poses[robot], stamps[robot] = known.poses[robot], known.stamps[robot]

    return spoil


@pytest.mark.parametrize("expected", [None, cv.Imperfections(0.01, 0.01, delay=0.15)])
@pytest.mark.parametrize("stamped", [True, False])
def test_a_team_arrives_under_a_supervisor(stamped, expected):
    loop = Loop(expected)
    loop.stamped = stamped
    loop.run(40.0)
    assert loop.team.status.arrived
    assert loop.team.report.ok
    assert loop.lost == ()


@pytest.mark.parametrize("expected", [None, cv.Imperfections(0.01, 0.01, delay=0.15)])
@pytest.mark.parametrize("stamped", [True, False])
@pytest.mark.parametrize("since", [0.0, 3.0, 7.0])
def test_a_body_that_is_no_longer_located_never_arrives(since, stamped, expected):
    """The own loop said "arrived" by a pose that was frozen 12 s before."""
    loop = Loop(expected)
    loop.stamped = stamped
    loop.run(since)
    assert not loop.team.status.arrived
    loop.spoil = frozen(1, loop.fleet)
    commands = loop.run(30.0)
    assert not commands.any()
    status = loop.team.status
    assert (status.state, status.involved) == ("stopped", (1,))
    assert not status.arrived
    assert "stale: robot 1" in status.message
    assert np.abs(loop.fleet.true_velocities()).max() < 1e-6
    # Nobody moves by itself, also when the body is found again.
    loop.spoil = lambda poses, stamps: None
    assert not loop.run(2.0).any()
    loop.fleet.send(np.tile([0.1, 0.0, 0.0], (4, 1)))
    loop.fleet.advance(0.1)  # carried a little: exactly the same pose would be in doubt again
    loop.team.resume()
    loop.run(40.0)
    assert loop.team.status.arrived


@pytest.mark.parametrize("stamped", [True, False])
@pytest.mark.parametrize("what", [np.nan, np.inf, -np.inf, 1e9])
def test_nonsense_in_poses_is_a_fault_and_not_an_error(what, stamped):
    loop = Loop()
    loop.stamped = stamped
    loop.run(2.0)

    def spoil(poses: np.ndarray, stamps: np.ndarray) -> None:
        poses[2, 1] = what

    loop.spoil = spoil
    assert not loop.run(0.05).any()
    assert [(f.robot, f.kind) for f in loop.team.report.faults] == [(2, "nan")]
    loop.spoil = lambda poses, stamps: None
    assert not loop.run(1.0).any()
    loop.team.resume()
    assert loop.run(0.05).any()


def test_nonsense_in_stamps_time_and_what_is_masked_is_a_fault_too():
    loop = Loop()
    loop.run(0.5)
    seen = loop.fleet.observe()
    masked = np.ma.masked_array(seen.poses, np.eye(4, 3, dtype=bool))
    for poses, time, stamps in (
        (seen.poses, seen.time, np.array([seen.time] * 3 + [np.nan])),
        (seen.poses, np.nan, seen.stamps),
        (masked, seen.time, seen.stamps),
    ):
        assert not loop.team.step(poses, time, stamps).any()
        assert {fault.kind for fault in loop.team.report.faults} == {"nan"}


@pytest.mark.parametrize("poses", [STARTS[:3], STARTS[:, :2], "here", None])
def test_poses_of_another_shape_are_an_error(poses):
    with pytest.raises(cv.InputError, match="poses"):
        Loop().team.step(poses, 0.0)


def test_the_others_go_on_without_a_robot_that_does_not_follow():
    loop = Loop()
    loop.run(2.0)
    loop.fleet.disable(2)
    failed = loop.fleet.time
    while not loop.lost:
        loop.run(0.05)
        assert loop.fleet.time - failed <= 3.0
    assert loop.lost == (2,)
    loop.run(40.0)
    status = loop.team.status
    assert status.arrived
    assert status.involved == (2,)
    assert "robot 2: no motion as commanded" in status.message
    loop.fleet.enable(2)
    loop.team.rejoin(2)
    loop.run(40.0)
    assert loop.team.status.message == ""


def test_or_all_stop():
    loop = Loop(unresponsive="stop")
    loop.run(2.0)
    loop.fleet.disable(2)
    assert not loop.run(4.0).any()
    assert "unresponsive: robot 2" in loop.team.status.message


def test_robots_that_are_slowed_down_are_not_said_not_to_follow():
    """The planner told of all four, as they did a fifth of what it had asked for."""
    loop = Loop(max_speed=0.08)
    for _ in range(20):
        loop.run(0.5)
        assert loop.team.status.message == ""
    assert np.hypot(*loop.fleet.true_velocities()[:, :2].T).max() <= 0.08 + 1e-9
    assert loop.lost == ()


def test_there_is_one_age_limit():
    loop = Loop(max_age=1.5)
    loop.run(1.0)
    loop.spoil = frozen(1, loop.fleet)
    assert loop.run(1.5).any()
    assert loop.planner.status.state != "stale"
    assert not loop.run(0.1).any()
    assert [fault.kind for fault in loop.team.report.cause] == ["stale"]


def test_the_area_is_the_planners_map_also_when_it_changes():
    loop = Loop()
    loop.run(0.5)
    loop.planner.update_map(cv.OccupancyMap.empty((1.6, 5.0), 0.05))
    loop.run(0.05)
    assert {fault.kind for fault in loop.team.report.faults} == {"out-of-map"}


def test_a_pause_stands_and_a_resume_goes_on():
    loop = Loop()
    loop.run(1.0)
    loop.team.pause()
    assert not loop.run(1.0).any()
    assert loop.team.status.state == "paused"
    loop.team.resume()
    assert loop.run(0.05).any()


class Scripted:
    """A policy that always wants to move, or fails."""

    def __init__(self) -> None:
        self.fails = False
        self.steps = 0
        self.paused = False

    @property
    def status(self) -> PlannerStatus:
        paths = (np.zeros((0, 2)),) * 2
        return PlannerStatus(
            state="final", roles=np.arange(2), goals=np.zeros((2, 2)), paths=paths,
            eta=np.zeros(2), arrived=True,
        )  # fmt: skip

    def step(self, poses: Any, time: float, stamps: Any) -> np.ndarray:
        assert np.isfinite(poses).all()
        assert np.isfinite(stamps).all()
        self.steps += 1
        if self.fails:
            raise ZeroDivisionError
        return np.full((2, 3), 0.05)

    def pause(self) -> None:
        self.paused = True

    def resume(self) -> None:
        self.paused = False


def test_a_policy_that_fails_stops_the_team_and_says_so():
    policy = Scripted()
    team = cv.SupervisedPlanner(policy, models=["go1"] * 2, rate=20.0)
    poses = np.array([(1.0, 1.0, 0.0), (2.0, 2.0, 0.0)])
    policy.fails = True
    with pytest.raises(ZeroDivisionError):
        team.step(poses, 0.0, np.zeros(2))
    policy.fails = False
    assert not team.step(poses, 0.05, np.full(2, 0.05)).any()
    assert str(team.report.cause[0]) == "planner (ZeroDivisionError)"
    assert not team.status.arrived


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        ({}, "models"),
        ({"models": ["go1"] * 2}, "rate"),
        ({"models": ["go1"] * 2, "rate": 0.0}, "rate"),
        ({"models": ["go1"] * 2, "rate": 20.0, "supervision": "strict"}, "supervision"),
    ],
)
def test_what_nobody_says_is_asked_for(arguments, key):
    with pytest.raises(cv.InputError) as caught:
        cv.SupervisedPlanner(Scripted(), **arguments)
    assert caught.value.key == key


NUMBERS = st.sampled_from([0.0, 0.0, 0.0, 0.02, 3.0, np.nan, np.inf, 1e9, -9.0])
ACTIONS = st.sampled_from(
    ["step"] * 6 + ["stop", "reset_stop", "resume", "resume", "pause", "lose", "rejoin", "fail"]
    + ["close"]
)  # fmt: skip


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.tuples(ACTIONS, NUMBERS, NUMBERS, st.sampled_from([0.05] * 8 + [0.0, -1.0, 0.6, 100.0])),
        max_size=40,
    ),
    st.booleans(),
)
def test_whatever_comes_nobody_moves_while_a_cause_is_latched(script, stamped):
    policy = Scripted()
    team = cv.SupervisedPlanner(policy, models=["go1"] * 2, rate=20.0, area=ROOM)
    time, closed, lost = 10.0, False, False
    resumed, held = True, False  # since the last cause; by the e-stop
    for action, off, age, dt in script:
        policy.fails = action == "fail"
        if action in ("stop", "reset_stop", "resume", "pause", "close"):
            getattr(team, action)()
            closed |= action == "close"
            held = action == "stop" or (held and action != "reset_stop")
            resumed = action == "resume" or (resumed and action not in ("stop", "pause"))
        elif action in ("lose", "rejoin"):
            getattr(team, action)(1)
            lost = action == "lose"
        time += dt
        poses = np.array([(1.0, 1.0, 0.0), (2.0 + off, 2.0, 0.0)])
        stamps = np.array([time, time - age])
        before = team.report.cause
        try:
            sent = team.step(poses, time, stamps if stamped else None)
        except ZeroDivisionError:
            sent = np.zeros((2, 3))
        assert np.isfinite(sent).all()
        if sent.any():
            assert not closed
            assert not held
            assert resumed
            assert lost or (abs(off) <= 3.0 and (not stamped or abs(age) <= 0.5))
            assert team.report.ok
            assert not before or action == "resume"
        if team.report.cause:
            assert not sent.any()
            assert not team.status.arrived
            resumed = False
        if lost:
            assert not sent[1].any()


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.sampled_from([0.0, 0.05, 0.05, 0.2]), min_size=1, max_size=15),
    st.sampled_from(["nan", "stop", "planner"]),
)
def test_resuming_without_fresh_data_never_moves_anybody(steps, cause):
    """The stamps stay what they were at the stop; some are still young enough to be used."""
    policy = Scripted()
    team = cv.SupervisedPlanner(policy, models=["go1"] * 2, rate=20.0)
    poses = np.array([(1.0, 1.0, 0.0), (2.0, 2.0, 0.0)])
    assert team.step(poses, 10.0, np.full(2, 10.0)).any()
    if cause == "nan":
        team.step(poses * np.nan, 10.0, np.full(2, 10.0))
    elif cause == "stop":
        team.stop()
        team.reset_stop()
    else:
        policy.fails = True
        with pytest.raises(ZeroDivisionError):
            team.step(poses, 10.0, np.full(2, 10.0))
        policy.fails = False
    time = 10.0
    for dt in steps:
        time += dt
        team.resume()
        assert not team.step(poses, time, np.array([time, 10.0])).any()
    team.resume()
    assert not team.report.ok
    assert team.step(poses, time + 0.05, np.full(2, time + 0.05)).any()
