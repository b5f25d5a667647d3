"""What is made of reports, and when cycles are due; none of it needs ROS."""

from __future__ import annotations

import math

import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.ros2.messages import PoseReport
from cavalcade.fleet.ros2.robot import Ros2Robot
from cavalcade.fleet.ros2.schedule import Schedule
from cavalcade.fleet.ros2.tracking import PoseTrack


def track_of(*reports: tuple[float, float, str], now: float = 10.0) -> PoseTrack:
    track = PoseTrack(Ros2Robot("a"))
    for stamp, x, frame in reports:
        track.hear(PoseReport(stamp, frame, (x, 0.0, 0.0)), now)
    return track


def test_a_report_in_another_frame_is_a_fault_and_not_used() -> None:
    track = track_of((9.0, 1.0, "map"), (9.1, 5.0, "odom"))
    assert track.pose[0] == 1.0
    kind, detail = track.fault(10.0) or ("", "")
    assert kind == "frame"
    assert "/a/pose" in detail
    assert "'odom'" in detail
    track.hear(PoseReport(9.2, "map", (2.0, 0.0, 0.0)), 10.0)
    assert track.fault(10.0) is None


def test_an_overtaken_report_is_not_used() -> None:
    assert track_of((9.0, 1.0, "map"), (8.9, 5.0, "map")).pose[0] == 1.0


@pytest.mark.parametrize(("stamp", "fault"), [(10.1, False), (10.11, True), (0.0, True)])
def test_stamps_ahead_and_missing_stamps_are_faults(stamp: float, fault: bool) -> None:
    found = track_of((stamp, 1.0, "map")).fault(10.0)
    assert (found is not None and found[0] == "stamp") == fault


def test_reports_that_lose_their_stamp_are_not_taken_for_overtaken_ones() -> None:
    track = track_of((9.0, 1.0, "map"), (0.0, 2.0, "map"))
    assert (track.fault(10.0) or ("",))[0] == "stamp"
    track.hear(PoseReport(9.1, "map", (2.0, 0.0, 0.0)), 10.0)
    assert track.fault(10.0) is None


def test_a_stamp_from_the_future_does_not_silence_those_that_follow() -> None:
    assert track_of((99.0, 5.0, "map"), (9.9, 1.0, "map")).pose[0] == 1.0


def test_velocity_is_the_trend_of_the_last_second() -> None:
    track = PoseTrack(Ros2Robot("a"))
    assert track.velocity() == (0.0, 0.0, 0.0)
    for k in range(100):
        time, turn = 0.02 * k, math.remainder(3.0 + 0.01 * k, 2.0 * math.pi)
        noise = 0.01 * (-1) ** k
        track.hear(PoseReport(time, "map", (0.3 * time + noise, 1.0, turn)), time)
    assert track.velocity() == pytest.approx((0.3, 0.0, 0.5), abs=0.01)


def test_robots_say_what_is_wrong_with_them() -> None:
    with pytest.raises(InputError, match="pose_type"):
        Ros2Robot("a", pose_type="Pose")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="name"):
        Ros2Robot("/")


class Clock:
    """Goes on by `tick` whenever somebody looks."""

    def __init__(self, tick: float) -> None:
        self.now, self.tick = 100.0, tick

    def __call__(self) -> float:
        self.now += self.tick
        return self.now


def test_cycles_do_not_drift_and_missed_ones_are_skipped() -> None:
    clock, schedule = Clock(0.001), Schedule()
    schedule.wait(0.05, clock)
    first = clock.now
    for _ in range(20):
        schedule.wait(0.05, clock)
    assert clock.now == pytest.approx(first + 1.0, abs=0.003)
    clock.now += 0.12
    schedule.wait(0.05, clock)  # at once: two cycles were missed, one of them is skipped
    assert clock.now == pytest.approx(first + 1.12, abs=0.003)
    schedule.wait(0.05, clock)
    assert clock.now == pytest.approx(first + 1.15, abs=0.003)


def test_a_clock_that_stands_still_or_goes_back_is_not_waited_for_without_end() -> None:
    still, schedule = Clock(0.0), Schedule()
    schedule.wait(0.05, still)
    schedule.wait(0.05, still)
    back = Clock(0.001)
    schedule.wait(0.05, back)
    back.now = 10.0
    schedule.wait(0.05, back)
    assert back.now == pytest.approx(10.05, abs=0.003)
