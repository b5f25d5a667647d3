"""Speed and acceleration of recorded motion, from differences of poses alone.

A mean velocity over an interval, and a difference of two such velocities over the time between
their middles, never exceed what the true motion reached. So a robot that keeps its limits passes
whatever the sampling; the tolerance only covers rounding and the turning of the velocity ellipse
within one interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cavalcade.checking.report import Kind, Violation, excesses
from cavalcade.checking.tracks import Track
from cavalcade.geometry import GRAVITY, Array
from cavalcade.robots import RobotModel

TOLERANCE = 0.02
"""Limits may be exceeded by this fraction."""

SIDEWAYS = 0.1
"""Of its speed a unicycle may show sideways: means over samples, and how they are followed."""

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

    Infinite limits don't hold; speed and yaw rate may exceed theirs by the fraction `speeding`.
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
    result = []
    for kind, value, limit, unit in rules:
        tolerance = speeding if kind in ("speed", "yaw-rate") else TOLERANCE
        too_much = np.where(value > limit * (1.0 + tolerance), value, 0.0)
        words = f"reaches {{value:.3f}} {unit}; the limit is {{limit:g}}"
        result += excesses(kind, robot, effort.time, value, limit, words, excess=too_much)
    return result


def with_own_limits(model: RobotModel, leaps: bool) -> RobotModel:
    """The model with the limits that hold on the way to a goal of its own, of all directions.

    If legs may leap, friction holds under up to their largest force.
    """
    if model.legs is not None and model.drive == "legged":
        force = model.legs.grf_max if leaps else 1.0
        return model.with_limits(
            max_speed_x=model.legs.v_max,
            max_speed_y=model.legs.v_max,
            max_yaw_rate=model.legs.yaw_rate,
            max_acceleration=model.legs.mu * GRAVITY * force,
            max_yaw_acceleration=math.inf,
        )
    turning, second = model.drive.startswith("unicycle"), model.drive.endswith("-2")
    free = model.round and not turning
    return model.with_limits(
        max_speed_y=model.max_speed_x * (SIDEWAYS if turning else 1.0),
        max_yaw_rate=math.inf if free else model.max_yaw_rate,
        max_acceleration=model.max_acceleration if second else math.inf,
        max_yaw_acceleration=model.max_yaw_acceleration if second and turning else math.inf,
    )
