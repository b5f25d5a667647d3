from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.execution import Supervision, Supervisor
from cavalcade.fleet import Observation
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
    assert [(fault.robot, fault.kind) for fault in report.faults] == [(1, "stale")]


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
