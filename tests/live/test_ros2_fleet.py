"""A fleet on a real graph, with robots that nobody here wrote in other processes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import FleetError, InputError
from cavalcade.fleet import LiveFleet
from cavalcade.fleet.ros2 import Ros2Fleet, Ros2Robot, scenario_robots

Wait = Callable[[Callable[[], Any]], Any]


def test_robots_are_located_driven_and_stopped_at_the_end(
    graph: Callable[..., Any], until: Wait
) -> None:
    robots = [graph("robot.py", f"robot_{k}") for k in range(2)]
    fleet = Ros2Fleet(scenario_robots(2))
    try:
        assert isinstance(fleet, LiveFleet)
        fleet.start(60.0)
        seen = fleet.observe()
        assert seen.poses == pytest.approx(np.array([[1.0, 2.0, 0.5]] * 2), abs=1e-6)
        assert (seen.time - seen.stamps < 0.5).all()
        assert seen.faults == ()

        def moved() -> bool:
            fleet.send([(0.5, 0.0, 0.0), (0.0, 0.0, 0.0)])
            fleet.advance(0.05)
            return bool(fleet.true_velocities()[0, 0] > 0.3)

        until(moved)
        assert fleet.observe().poses[1] == pytest.approx((1.0, 2.0, 0.5), abs=1e-6)
    finally:
        fleet.close()
    fleet.close()
    fleet.send([(0.5, 0.0, 0.0)] * 2)
    until(lambda: robots[0].heard and robots[0].heard[-1]["command"] == [0.0, 0.0, 0.0])


def test_who_is_not_heard_or_in_another_frame_is_named(graph: Callable[..., Any]) -> None:
    graph("robot.py", "robot_0", "odom")
    fleet = Ros2Fleet(scenario_robots(2))
    try:
        with pytest.raises(FleetError) as caught:
            fleet.start(15.0)
    finally:
        fleet.close()
    assert "robot_0: poses on /robot_0/pose are in 'odom', not in 'map'" in str(caught.value)
    assert "robot_1: nothing was heard on /robot_1/pose (PoseStamped)" in str(caught.value)


def test_a_second_commander_is_a_fault_as_long_as_it_is_there(
    graph: Callable[..., Any], until: Wait
) -> None:
    graph("robot.py", "robot_0")
    fleet = Ros2Fleet(scenario_robots(1))
    try:
        fleet.start(60.0)
        rival = graph("driver.py", "1.0", "0.2")
        (fault,) = until(lambda: fleet.observe().faults)
        assert (fault.robot, fault.kind) == (0, "second-commander")
        named = "/driver publishes on /robot_0/cmd_vel"
        until(lambda: any(named in fault.detail for fault in fleet.observe().faults))
        rival.process.terminate()
        until(lambda: not fleet.observe().faults)
    finally:
        fleet.close()


def test_what_is_missing_of_ros_is_said(graph: Callable[..., Any]) -> None:
    try:
        import tf2_ros  # noqa: F401
    except ImportError:
        with pytest.raises(InputError, match="tf2_ros"):
            Ros2Fleet([Ros2Robot("a", pose_type="tf")])
    with pytest.raises(InputError, match="share /x"):
        Ros2Fleet([Ros2Robot(name, velocity_topic="/x") for name in "ab"])
