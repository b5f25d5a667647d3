"""Speed and acceleration of recorded motion, from differences of poses alone.

A mean velocity over an interval, and a difference of two such velocities over the time between
their middles, never exceed what the true motion reached. So a robot that keeps its limits passes
whatever the sampling; the tolerance only covers rounding and the turning of the velocity ellipse
within one interval.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cavalcade.checking.report import Kind, Violation
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel

TOLERANCE = 0.02
"""Limits may be exceeded by this fraction."""

_YAWS = np.linspace(0.0, 1.0, 5)


@dataclass(frozen=True)
class Effort:
    """What a robot did, interval by interval.

    Attributes:
        time: `(T,)` s, when each interval begins.
        speed_ratio: `(T,)` speed over what the velocity ellipse allows in its direction.
        yaw_rate: `(T,)` rad/s, absolute.
        acceleration: `(T,)` m/s² from the interval before, map frame; 0 in the first.
        yaw_acceleration: `(T,)` rad/s² likewise.
    """

    time: Array
    speed_ratio: Array
    yaw_rate: Array
    acceleration: Array
    yaw_acceleration: Array


def measure(track: Track, model: RobotModel) -> Effort:
    """The effort of a track with increasing time stamps."""
    dt = np.diff(track.time)
    rate = np.diff(track.pose, axis=0) / dt[:, None]
    # The ellipse turns with the body: of the headings within the interval the kindest counts.
    yaw = track.pose[:-1, 2, None] + _YAWS * np.diff(track.pose[:, 2])[:, None]
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = rate[:, 0, None], rate[:, 1, None]
    ratio = np.hypot((c * x + s * y) / model.max_speed_x, (c * y - s * x) / model.max_speed_y)
    change = np.zeros_like(rate)
    change[1:] = np.diff(rate, axis=0) / ((dt[1:] + dt[:-1]) / 2.0)[:, None]
    return Effort(
        track.time[:-1],
        ratio.min(axis=1),
        np.abs(rate[:, 2]),
        np.hypot(change[:, 0], change[:, 1]),
        np.abs(change[:, 2]),
    )


def exceeded(
    effort: Effort, model: RobotModel, robot: int, speeding: float = TOLERANCE
) -> list[Violation]:
    """One violation per limit and uninterrupted stretch beyond it, at its first moment.

    Args:
        effort: What the robot did.
        model: With its limits; infinite ones don't hold.
        robot: Which.
        speeding: By this fraction speed and yaw rate may exceed theirs.
    """
    rules: tuple[tuple[Kind, Array, float, str], ...] = (
        ("speed", effort.speed_ratio, 1.0, "times the speed that its ellipse allows"),
        ("yaw-rate", effort.yaw_rate, model.max_yaw_rate, "rad/s of yaw rate"),
        ("acceleration", effort.acceleration, model.max_acceleration, "m/s² of acceleration"),
        (
            "yaw-acceleration",
            effort.yaw_acceleration,
            model.max_yaw_acceleration,
            "rad/s² of yaw acceleration",
        ),
    )
    return [
        violation
        for kind, values, limit, words in rules
        for violation in _stretches(
            kind,
            values,
            limit,
            words,
            effort.time,
            robot,
            speeding if kind in ("speed", "yaw-rate") else TOLERANCE,
        )
    ]


def _stretches(
    kind: Kind,
    values: Array,
    limit: float,
    words: str,
    time: Array,
    robot: int,
    tolerance: float,
) -> list[Violation]:
    beyond = np.concatenate(([False], values > limit * (1.0 + tolerance), [False]))
    edges = np.flatnonzero(np.diff(beyond.astype(np.int8)))
    result = []
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        worst = float(values[begin:end].max())
        text = f"robot {robot} reaches {worst:.3f} {words}; the limit is {limit:g}"
        result.append(Violation(kind, float(time[begin]), (robot,), text, worst, limit))
    return result
