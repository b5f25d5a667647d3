"""`cavalcade ros2 simulate` with a driver that nobody here wrote."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

Wait = Callable[[Callable[[], Any]], Any]


def test_a_robot_goes_as_it_is_told_and_stops_when_nobody_speaks(
    graph: Callable[..., Any], until: Wait
) -> None:
    simulation = graph("cavalcade", "ros2", "simulate", "square-clutter")
    driver = graph("driver.py", "2.0", "0.4")
    until(lambda: "heard no command for 0.5 s" in simulation.text)
    heard = driver.heard
    poses = [one for one in heard if one["kind"] == "pose"]
    assert {one["frame"] for one in poses} == {"map"}
    assert poses[-1]["x"] - poses[0]["x"] > 0.3
    stamps = [one["stamp"] for one in poses]
    assert stamps == sorted(stamps)
    count = len(poses)
    until(lambda: sum(one["kind"] == "pose" for one in driver.heard) > count + 100)
    rest = [one["x"] for one in driver.heard if one["kind"] == "pose"][-20:]
    assert max(rest) - min(rest) < 1e-6
    others = {one["kind"]: one for one in driver.heard if one["kind"] != "pose"}
    assert others["scan"]["rays"] == 360
    assert others["scan"]["least"] > 0.1
    assert others["map"]["cells"] % others["map"]["width"] == 0
    assert "FL_hip_joint" in others["joints"]["names"]
    assert "clock" in others
    simulation.process.send_signal(signal.SIGTERM)
    assert simulation.process.wait(60.0) == 0


def test_ctrl_c_ends_it_with_its_own_code(graph: Callable[..., Any], until: Wait) -> None:
    simulation = graph("cavalcade", "ros2", "simulate", "square-clutter")
    until(lambda: "Ctrl-C ends" in simulation.text)
    simulation.process.send_signal(signal.SIGINT)
    assert simulation.process.wait(60.0) == 130
    assert "Traceback" not in simulation.text
