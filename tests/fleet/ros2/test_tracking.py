"""What is made of reports; none of it needs ROS."""

from __future__ import annotations

import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.ros2.messages import PoseReport
from cavalcade.fleet.ros2.robot import Ros2Robot
from cavalcade.fleet.ros2.tracking import AHEAD_OF_TOPIC, PoseTrack


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


@pytest.mark.parametrize(("lag", "fault"), [(0.24, False), (0.5, False), (0.51, True), (1e9, True)])
def test_a_pose_may_come_before_the_message_of_the_clock(lag: float, fault: bool) -> None:
    track = PoseTrack(Ros2Robot("a"))
    track.hear(PoseReport(10.0 + lag, "map", (1.0, 0.0, 0.0)), 10.0, AHEAD_OF_TOPIC)
    assert (track.fault(10.0) is not None) == fault


def test_reports_that_lose_their_stamp_are_not_taken_for_overtaken_ones() -> None:
    track = track_of((9.0, 1.0, "map"), (0.0, 2.0, "map"))
    assert (track.fault(10.0) or ("",))[0] == "stamp"
    track.hear(PoseReport(9.1, "map", (2.0, 0.0, 0.0)), 10.0)
    assert track.fault(10.0) is None


def test_a_stamp_from_the_future_does_not_silence_those_that_follow() -> None:
    assert track_of((99.0, 5.0, "map"), (9.9, 1.0, "map")).pose[0] == 1.0


def test_robots_say_what_is_wrong_with_them() -> None:
    with pytest.raises(InputError, match="pose_type"):
        Ros2Robot("a", pose_type="Pose")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="name"):
        Ros2Robot("/")
