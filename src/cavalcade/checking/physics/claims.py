"""What a run says of itself, and what its recording says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.rotations import roll_pitch_yaw
from cavalcade.checking.report import Violation
from cavalcade.checking.stretches import excesses
from cavalcade.checking.tracks import Track
from cavalcade.geometry import wrap_angle

SAME = (1e-3, 1e-3)
"""The planar pose is the body's within m and rad at a common stamp."""

SWAY = (20.0, 100.0)
"""Accelerations in m/s² and rad/s² between stamps of the planar pose, if bodies have others."""

DISTANCE = 0.01
"""Smallest distances may be claimed this much too large, m: between samples robots sway."""


def check_poses(record: RobotRecord, track: Track) -> list[Violation]:
    """The planar pose is the trunk's place and heading."""
    expected = track.at(record.time)
    # Between stamps a straight line is off by half the acceleration times what is left and right.
    after = np.searchsorted(track.time, record.time).clip(1, len(track.time) - 1)
    left = np.maximum(record.time - track.time[after - 1], 0.0)
    right = np.maximum(track.time[after] - record.time, 0.0)
    between = np.where(np.minimum(left, right) > 1e-6, 0.5 * left * right, 0.0)
    away = np.hypot(*(record.base[:, :2] - expected[:, :2]).T)
    turned = np.abs(wrap_angle(roll_pitch_yaw(record.turn)[:, 2] - expected[:, 2]))
    robot, time = record.robot, record.time
    words = "has its pose {value:.3f} m from its body"
    slack = SAME[0] + SWAY[0] * between
    result = excesses("pose", robot, time, away, 0.0, words, slack)
    # Of a trunk that stands upright, heading is not defined.
    turned = np.where(np.abs(record.turn[:, 2, 0]) < 0.95, turned, 0.0)
    words = "has its pose turned by {value:.3f} rad from its body"
    slack = SAME[1] + SWAY[1] * between
    return result + excesses("pose", robot, time, turned, 0.0, words, slack)


def check_counts(
    summary: Mapping[str, Any], found: Mapping[str, int], end: float, robots: int
) -> list[Violation]:
    """Falls and contacts that the summary does not admit.

    Args:
        summary: With `falls` and `collisions`.
        found: How many there are of `falls`, `robot_robot` and `robot_obstacle`.
        end: Of the recording, s.
        robots: How many.
    """
    collisions = summary.get("collisions")
    told = dict(collisions) if isinstance(collisions, Mapping) else {}
    told["falls"] = summary.get("falls")
    result = []
    for key, count in found.items():
        claim = told.get(key)
        if count > 0 and not (isinstance(claim, int) and claim > 0):
            words = key.replace("_", "-") + (" contacts" if key != "falls" else "")
            text = f"the summary says {claim} {words}; the recording shows {count}"
            result.append(
                Violation("summary", end, tuple(range(robots)), text, float(claim or 0), count)
            )
    if summary.get("success") and found.get("falls"):
        text = "the summary claims success; a robot has fallen"
        result.append(Violation("summary", end, tuple(range(robots)), text, 1.0, 0.0))
    return result


def check_distances(
    summary: Mapping[str, Any], found: Mapping[str, float], end: float, robots: int
) -> list[Violation]:
    """Smallest distances that the summary says are larger than they were.

    Args:
        summary: With the keys of `found`.
        found: Smallest distances in m; inf where nothing was near.
        end: Of the recording, s.
        robots: How many.
    """
    result = []
    for key, distance in found.items():
        claim = summary.get(key)
        if isinstance(claim, bool) or not isinstance(claim, int | float):
            claim = math.inf
        if math.isfinite(distance) and claim > distance + DISTANCE:
            text = f"the summary says {key} {claim:.3f}; the recording shows {distance:.3f}"
            result.append(
                Violation("summary", end, tuple(range(robots)), text, float(claim), distance)
            )
    return result
