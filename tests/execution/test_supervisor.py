from __future__ import annotations

import time as wall
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.execution import Supervision, Supervisor
from cavalcade.execution import supervisor as supervising
from cavalcade.fleet import Fault, IdealFleet, Observation
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

GO1 = robot_model("go1")
AREA = OccupancyMap.empty((10.0, 10.0), 0.5)
SOUND = np.array([(1.0, 1.0, 0.0), (2.0, 2.0, 1.0), (3.0, 3.0, -1.0)])


def seen(time: float, poses: np.ndarray = SOUND, stamps: np.ndarray | None = None) -> Observation:
    return Observation(time, poses.copy(), np.full(3, time) if stamps is None else stamps)


def supervisor(**allowed: Any) -> Supervisor:
    watch = Supervisor([GO1] * 3, 0.05, Supervision(**allowed), AREA)
    assert watch.check(seen(0.0)).ok
    return watch


def changed(robot: int, **values: float) -> np.ndarray:
    poses = SOUND.copy()
    for name, value in values.items():
        poses[robot, "xyw".index(name)] = value
    return poses


@pytest.mark.parametrize(
    ("poses", "kind"),
    [
        (changed(1, x=np.nan), "nan"),
        (changed(1, w=np.inf), "nan"),
        (changed(1, x=-0.1), "out-of-map"),
        (changed(1, y=11.0), "out-of-map"),
        (changed(1, x=2.7), "jump"),
        (changed(1, w=2.5), "jump"),
    ],
)
def test_a_bad_pose_is_a_fault_of_its_robot(poses: np.ndarray, kind: str) -> None:
    report = supervisor().check(seen(0.05, poses))
    assert not report.ok
    assert [(fault.robot, fault.kind) for fault in report.faults] == [(1, kind)]
    assert report.cause == report.faults
    assert str(report.faults[0]) == f"{kind}: robot 1"


def test_reports_may_be_half_a_second_old_and_no_older() -> None:
    watch = supervisor()
    stamps = np.array([0.5, 0.0, 0.5])
    assert watch.check(seen(0.5, stamps=stamps)).ok
    report = watch.check(seen(0.55, stamps=stamps))
    assert [str(fault) for fault in report.faults] == ["stale: robot 1 (0.55 s old)"]


@pytest.fixture
def still(monkeypatch: pytest.MonkeyPatch) -> None:
    """The wall's clock, which shows what it showed first."""
    now = wall.monotonic()
    monkeypatch.setattr(supervising, "wall", SimpleNamespace(monotonic=lambda: now))


@pytest.mark.parametrize(
    ("step", "kinds"),
    [
        (0.5, []),
        (0.54, ["stale"] * 3),
        (0.56, ["clock-forward"]),
        (5.0, ["clock-forward"]),
    ],
)
def test_a_clock_that_is_set_forward_is_named_and_not_every_robot(
    still: None, step: float, kinds: list[str]
) -> None:
    watch = supervisor()
    report = watch.check(seen(step, stamps=np.zeros(3)))
    assert [fault.kind for fault in report.faults] == kinds
    if step == 5.0:
        assert str(report.cause[0]) == "clock-forward (by 4.95 s)"


def test_a_robot_that_was_silent_before_the_clock_was_set_is_named_besides(still: None) -> None:
    watch = supervisor()
    for cycle in range(1, 11):
        watch.check(seen(0.05 * cycle, stamps=np.array([0.05 * cycle, 0.0, 0.05 * cycle])))
    report = watch.check(seen(1.5, stamps=np.array([0.5, -0.1, 0.5])))
    assert {(f.robot, f.kind) for f in report.faults} == {(None, "clock-forward"), (1, "stale")}


def test_a_clock_that_is_set_forward_while_reports_are_fresh_is_no_fault() -> None:
    assert supervisor().check(seen(5.0)).ok


def test_a_cycle_that_took_as_long_as_the_clock_went_on_is_no_leap(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    watch = supervisor()
    later = wall.monotonic() + 5.0
    monkeypatch.setattr(supervising, "wall", SimpleNamespace(monotonic=lambda: later))
    report = watch.check(seen(5.0, stamps=np.zeros(3)))
    assert [(fault.robot, fault.kind) for fault in report.faults] == [
        (robot, "stale") for robot in range(3)
    ]


@settings(max_examples=50, deadline=None)
@given(st.floats(0.0, 0.5), st.floats(-np.pi, np.pi), st.floats(0.05, 2.0))
def test_nothing_a_robot_can_do_is_a_jump(speed: float, heading: float, dt: float) -> None:
    watch = Supervisor([GO1], 0.05, Supervision(max_age=10.0), AREA)
    pose = np.array([(5.0, 5.0, 3.0)])
    assert watch.check(Observation(0.0, pose, np.zeros(1))).ok
    step = speed * dt * np.array([np.cos(heading), np.sin(heading)])
    turned = (3.0 + 1.2 * dt + np.pi) % (2 * np.pi) - np.pi
    moved = np.array([(*(pose[0, :2] + step), turned)])
    assert watch.check(Observation(dt, moved, np.array([dt]))).ok


def test_a_fault_holds_until_data_are_sound_and_someone_says_resume() -> None:
    watch = supervisor()
    assert not watch.check(seen(0.05, changed(0, x=np.nan))).ok
    report = watch.check(seen(0.10))
    assert not report.ok
    assert report.faults == ()
    assert report.cause[0].kind == "nan"
    watch.resume()
    assert watch.check(seen(0.15)).ok
    assert watch.check(seen(0.20)).ok


def test_resume_on_bad_data_is_dropped() -> None:
    watch = supervisor()
    bad = changed(0, x=np.nan)
    assert not watch.check(seen(0.05, bad)).ok
    watch.resume()
    assert not watch.check(seen(0.10, bad)).ok
    assert not watch.check(seen(0.15)).ok
    watch.resume()
    assert watch.check(seen(0.20)).ok


def test_resume_without_a_fault_does_not_excuse_the_next_one() -> None:
    watch = supervisor()
    watch.resume()
    assert not watch.check(seen(0.05, changed(0, x=np.nan))).ok
    assert not watch.check(seen(0.10)).ok


def test_coming_back_elsewhere_after_nonsense_is_a_jump() -> None:
    watch = supervisor()
    watch.check(seen(0.05, changed(0, x=np.nan)))
    report = watch.check(seen(0.10, changed(0, x=5.0)))
    assert [(fault.robot, fault.kind) for fault in report.faults] == [(0, "jump")]


def test_after_a_jump_the_new_place_is_taken_for_granted() -> None:
    watch = supervisor()
    there = changed(0, x=5.0)
    assert not watch.check(seen(0.05, there)).ok
    watch.resume()
    assert watch.check(seen(0.10, there)).ok


def test_a_lost_robot_is_no_fault_until_it_rejoins() -> None:
    watch = supervisor()
    watch.lose(2)
    assert watch.check(seen(5.0, changed(2, x=np.nan), np.array([5.0, 5.0, 0.0]))).ok
    watch.rejoin(2)
    assert watch.check(seen(5.05, changed(2, x=9.0, y=9.0))).ok
    assert not watch.check(seen(5.10, changed(2, x=np.nan))).ok


def test_every_faulty_robot_is_named() -> None:
    poses = changed(0, x=np.nan)
    poses[2, 0] = -3.0
    report = supervisor().check(seen(0.05, poses))
    assert [fault.robot for fault in report.faults] == [0, 2]


def test_without_an_area_there_is_no_outside() -> None:
    assert Supervisor([GO1] * 3, 0.05).check(seen(0.0, SOUND + 9e5)).ok


@pytest.mark.parametrize(("beyond", "ok"), [(-0.01, True), (0.0, True), (0.01, False)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("limit", [0.2, 0.5, 2.0])
def test_the_limit_of_the_age_holds_for_stamps_of_the_future_too(limit, sign, beyond, ok):
    watch = Supervisor([GO1] * 3, 0.05, Supervision(max_age=limit), AREA)
    stamps = np.array([10.0, 10.0 - sign * (limit + beyond), 10.0])
    report = watch.check(seen(10.0, stamps=stamps))
    assert report.ok == ok
    if not ok:
        assert [(fault.robot, fault.kind) for fault in report.faults] == [(1, "stale")]
        assert ("later than now" in report.message) == (sign < 0)


@pytest.mark.parametrize(("time", "kind"), [(-0.1, "clock-back"), (0.0, None), (np.nan, "nan")])
def test_a_clock_that_goes_back_or_is_none(time, kind):
    report = supervisor().check(seen(time, stamps=np.zeros(3)))
    assert [fault.kind for fault in report.faults] == ([kind] if kind else [])


def test_after_the_clock_was_set_back_the_team_can_be_resumed():
    watch = Supervisor([GO1] * 3, 0.05)
    assert watch.check(seen(1000.0)).ok
    assert watch.check(seen(3.0)).cause[0].kind == "clock-back"
    watch.resume()
    assert watch.check(seen(3.05)).ok


def test_the_clock_may_repeat_twice_as_slow_ones_do_and_not_thrice():
    watch = supervisor()
    assert [watch.check(seen(time)).ok for time in (0.05, 0.05, 0.05, 0.1, 0.1)] == [True] * 5
    watch.check(seen(0.1))
    report = watch.check(seen(0.1))
    assert [fault.kind for fault in report.faults] == ["clock-still"]


@pytest.mark.parametrize("value", [2e6, -2e6, 1e300])
def test_absurd_numbers_count_as_none(value):
    poses = SOUND.copy()
    poses[1, 0] = value
    report = Supervisor([GO1] * 3, 0.05).check(seen(0.0, poses))
    assert [(fault.robot, fault.kind) for fault in report.faults] == [(1, "nan")]


FENCE = ((0.5, 0.5), (4.0, 0.5), (4.0, 4.0), (2.0, 2.5), (0.5, 4.0))  # a notch between the arms


@pytest.mark.parametrize(
    ("x", "y", "ok"),
    [(0.5, 2.0, True), (0.499, 2.0, False), (4.0, 4.0, True), (2.0, 2.5, True), (2.0, 2.51, False),
     (2.0, 3.9, False), (1.0, 3.4, True), (3.8, 3.7, True), (2.0, 0.5, True), (2.0, 0.49, False),
     (4.001, 1.0, False), (0.0, 4.0, False), (3.0, 2.5, True)],
)  # fmt: skip
def test_the_geofence_is_a_polygon_whose_edges_belong_to_it(x, y, ok):
    watch = Supervisor([GO1], 0.05, Supervision(geofence=FENCE), AREA)
    report = watch.check(Observation(0.0, np.array([(x, y, 0.0)]), np.zeros(1)))
    assert report.ok == ok
    assert [fault.kind for fault in report.faults] == ([] if ok else ["geofence"])


def test_what_the_fleet_itself_knows_stops_the_team_unless_it_is_of_a_lost_robot():
    watch = supervisor()
    frame = Fault(1, "frame", "odom instead of map")
    known = Observation(0.05, SOUND, np.full(3, 0.05), (frame,))
    report = watch.check(known)
    assert report.cause == (frame,)
    assert report.message == "frame: robot 1 (odom instead of map)"
    watch = supervisor()
    watch.lose(1)
    assert watch.check(known).ok


def test_the_e_stop_is_held_until_it_is_reset_and_the_team_until_it_is_resumed():
    watch = supervisor()
    assert watch.admit(np.full((3, 3), 0.1)).all()
    watch.stop(detail="button")
    assert not watch.admit(np.full((3, 3), 0.1)).any()
    assert watch.check(seen(0.05)).message == "e-stop (button)"
    watch.resume()
    assert not watch.check(seen(0.10)).ok
    watch.reset_stop()
    assert not watch.check(seen(0.15)).ok
    watch.resume()
    assert watch.check(seen(0.20)).ok
    assert watch.admit(np.full((3, 3), 0.1)).all()


def test_the_e_stop_is_named_besides_what_stopped_the_team_before():
    watch = supervisor()
    watch.check(seen(0.05, changed(1, x=np.nan)))
    watch.stop()
    assert [fault.kind for fault in watch.cause] == ["nan", "e-stop"]


def test_a_stop_after_the_request_to_resume_drops_it():
    watch = supervisor()
    watch.check(seen(0.05, changed(1, x=np.nan)))
    watch.resume()
    watch.stop("deadline")
    assert not watch.check(seen(0.10)).ok


def test_resuming_takes_a_report_of_everybody_that_is_newer_than_the_stop():
    watch = supervisor()
    stamps = np.full(3, 0.05)
    assert watch.check(seen(0.05, stamps=stamps)).ok
    watch.stop("deadline")
    for time, newer, ok in ((0.10, [0, 1], False), (0.15, [0, 1, 2], True)):
        stamps = stamps.copy()
        stamps[newer] = time
        watch.resume()
        assert watch.check(seen(time, stamps=stamps)).ok == ok


@pytest.mark.parametrize(
    ("took", "missed", "stopped"),
    [(0.0, 0, False), (0.05, 0, False), (0.051, 1, False), (0.1, 1, False), (0.101, 1, True),
     (np.inf, 1, True)],
)  # fmt: skip
def test_a_cycle_may_be_late_once_over_and_no_more(took, missed, stopped):
    watch = supervisor(deadline=0.05)
    sent = watch.admit(np.full((3, 3), 0.1), took)
    assert watch.missed == missed
    assert sent.any() != stopped
    assert watch.stopped == stopped
    assert [fault.kind for fault in watch.cause] == (["deadline"] if stopped else [])


def test_simulated_time_waits_for_the_planner():
    assert supervisor().admit(np.full((3, 3), 0.1), 60.0).any()


@pytest.mark.parametrize(
    ("command", "caps", "sent"),
    [
        ((0.3, 0.4, 0.2), {"max_speed": 0.5}, (0.3, 0.4, 0.2)),
        ((0.3, 0.4, 0.2), {"max_speed": 0.25}, (0.15, 0.2, 0.1)),
        ((0.3, 0.4, -0.2), {"max_yaw_rate": 0.1}, (0.15, 0.2, -0.1)),
        ((0.3, 0.4, 0.2), {"max_speed": 0.25, "max_yaw_rate": 0.05}, (0.075, 0.1, 0.05)),
        ((0.0, 0.0, 0.2), {"max_speed": 0.1}, (0.0, 0.0, 0.2)),
    ],
)
def test_caps_scale_a_command_and_keep_its_path(command, caps, sent):
    commands = np.array([command, (0.0, 0.0, 0.0), (0.05, 0.0, 0.0)])
    expected = np.array([sent, (0.0, 0.0, 0.0), (0.05, 0.0, 0.0)])
    assert supervisor(**caps).admit(commands) == pytest.approx(expected)


def test_a_dry_run_commands_nobody_and_accuses_nobody():
    watch = supervisor(dry_run=True)
    for cycle in range(1, 100):
        report = watch.check(seen(0.05 * cycle))
        assert report.ok
        assert report.unresponsive == ()
        assert not watch.admit(np.full((3, 3), 0.3)).any()


def test_nothing_is_admitted_before_anything_was_checked_nor_after_the_end():
    watch = Supervisor([GO1] * 3, 0.05)
    assert not watch.admit(np.full((3, 3), 0.1)).any()
    assert watch.check(seen(0.0)).ok
    assert watch.admit(np.full((3, 3), 0.1)).all()
    watch.close()
    watch.resume()
    assert not watch.check(seen(0.05)).ok
    assert not watch.admit(np.full((3, 3), 0.1)).any()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_commands_that_are_no_numbers_stop_the_team(value):
    watch = supervisor()
    commands = np.full((3, 3), 0.1)
    commands[1, 2] = value
    assert not watch.admit(commands).any()
    assert watch.cause[0].kind == "nan"


def driven(speed: float, share: float, seconds: float = 6.0, **allowed: Any):
    """Supervisor and when robot 1, told to go at `speed` m/s, covering a share, is named, s."""
    watch = Supervisor([GO1] * 3, 0.05, Supervision(**allowed), AREA)
    poses = SOUND.copy()
    for cycle in range(round(seconds / 0.05)):
        report = watch.check(seen(0.05 * cycle, poses))
        if report.unresponsive or not report.ok:
            return watch, 0.05 * cycle, report
        commands = np.zeros((3, 3))
        commands[:2, 0] = speed
        sent = watch.admit(commands)
        poses[0, :2] += 0.05 * sent[0, 0] * np.array([np.cos(0.0), np.sin(0.0)])
        poses[1, :2] += 0.05 * share * sent[1, 0] * np.array([np.cos(1.0), np.sin(1.0)])
    return watch, None, report


@pytest.mark.parametrize(
    ("speed", "share", "accused"),
    [(0.1, 0.0, True), (0.5, 0.0, True), (0.3, 0.18, True), (0.3, -1.0, True), (0.1, 0.17, True),
     (0.3, 0.22, False), (0.1, 0.3, False), (0.09, 0.0, False), (0.0, 0.0, False),
     (0.4, 1.0, False)],
)  # fmt: skip
def test_who_does_not_follow_is_lost_after_two_seconds(speed, share, accused):
    watch, at, report = driven(speed, share)
    assert (at is not None) == accused
    if at is not None:
        assert 2.0 <= at <= 3.0
        assert report.ok
        assert report.unresponsive == watch.lost == (1,)
        sent = watch.admit(np.full((3, 3), 0.2))
        assert not sent[1].any()
        assert sent[0].all()


def test_or_stops_the_team_if_that_is_to_be_so():
    _, at, report = driven(0.3, 0.0, unresponsive="stop")
    assert at is not None
    assert [(fault.robot, fault.kind) for fault in report.cause] == [(1, "unresponsive")]


def test_the_last_robot_that_does_not_follow_stops_the_team():
    watch = Supervisor([GO1], 0.05)
    for cycle in range(60):
        report = watch.check(Observation(0.05 * cycle, SOUND[:1], np.full(1, 0.05 * cycle)))
        watch.admit(np.array([(0.3, 0.0, 0.0)]))
        if not report.ok:
            break
    assert [(fault.robot, fault.kind) for fault in report.cause] == [(0, "unresponsive")]


@pytest.mark.parametrize("half", [0.4, 1.0, 1.3, 2.5])
def test_a_robot_that_goes_there_and_back_is_not_accused(half):
    """One that evaded and came back, 1 s each, was lost by the team: its way led nowhere."""
    watch = Supervisor([GO1], 0.05)
    fleet = IdealFleet([GO1], [(2.0, 2.0, 0.0)])
    for cycle in range(400):
        assert watch.check(fleet.observe()).ok
        sign = 1.0 if int(cycle * 0.05 / half) % 2 else -1.0
        fleet.send(watch.admit(np.array([(0.4 * sign, 0.13, 1.2)])))
        fleet.advance(0.05)
    assert not watch.lost


def test_a_robot_that_was_handed_over_is_not_accused():
    watch = Supervisor([GO1] * 3, 0.05)
    for cycle in range(100):
        report = watch.check(seen(0.05 * cycle), busy=[0, 1, 2] if cycle < 90 else [])
        assert report.ok
        assert report.unresponsive == ()
        watch.admit(np.full((3, 3), 0.3))


def test_nor_one_that_is_told_more_than_it_can_do():
    """A policy that asks for 12 m/s gets 0.5 m/s, and that is following."""
    watch = Supervisor([GO1], 0.05)
    for cycle in range(100):
        pose = np.array([(0.05 * cycle * 0.5, 0.0, 0.0)])
        assert watch.check(Observation(0.05 * cycle, pose, np.full(1, 0.05 * cycle))).ok
        watch.admit(np.array([(12.0, 0.0, 0.0)]))


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"max_age": 0.0}, "max_age"),
        ({"max_age": np.nan}, "max_age"),
        ({"max_age": None}, "max_age"),
        ({"max_speed": -0.1}, "max_speed"),
        ({"max_yaw_rate": "fast"}, "max_yaw_rate"),
        ({"deadline": 0.0}, "deadline"),
        ({"geofence": ((0.0, 0.0), (1.0, 0.0))}, "geofence"),
        ({"geofence": ((0, 0), (1, 1), (1, 0), (0, 1))}, "geofence"),
        ({"unresponsive": "panic"}, "unresponsive"),
        ({"dry_run": "no"}, "dry_run"),
    ],
)
def test_what_is_allowed_is_checked(values, key):
    with pytest.raises(InputError) as caught:
        Supervision(**values)
    assert caught.value.key == key
