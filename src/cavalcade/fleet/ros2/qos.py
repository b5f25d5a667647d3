"""Qualities of service: which messages may be lost, and which wait for those who come later."""

from __future__ import annotations

from typing import Any

from cavalcade.fleet.ros2.availability import load_rclpy


def sensor_data(depth: int = 5) -> Any:
    """Of poses and scans: what is lost is not sent again, newer ones count."""
    return _profile("BEST_EFFORT", "VOLATILE", depth)


def reliable(depth: int = 10) -> Any:
    """Of commands, goals and plans."""
    return _profile("RELIABLE", "VOLATILE", depth)


def latched() -> Any:
    """Of maps, descriptions and states: the last one waits for everybody who comes later."""
    return _profile("RELIABLE", "TRANSIENT_LOCAL", 1)


def clock() -> Any:
    """Of `/clock`: only the newest counts."""
    return _profile("BEST_EFFORT", "VOLATILE", 1)


def _profile(reliability: str, durability: str, depth: int) -> Any:
    load_rclpy()
    from rclpy import qos

    return qos.QoSProfile(
        history=qos.HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=getattr(qos.ReliabilityPolicy, reliability),
        durability=getattr(qos.DurabilityPolicy, durability),
    )
