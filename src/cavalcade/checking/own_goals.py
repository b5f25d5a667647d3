"""Recorded motion of robots that have goals of their own: their limits, and arrival."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cavalcade.checking.arrival import IDEAL, Criterion, standing
from cavalcade.checking.report import Violation
from cavalcade.checking.tracks import Track
from cavalcade.geometry import wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.scenario import Scenario

SIDEWAYS = 0.1
"""Of its speed a unicycle may show sideways: means over samples, and how they are followed."""

_GRAVITY = 9.81


def with_own_limits(model: RobotModel, leaps: bool) -> RobotModel:
    """The model with the limits that hold on the way to a goal of its own, of all directions.

    Args:
        model: Any robot.
        leaps: Whether it may leap: then friction holds under up to the largest force of its legs.
    """
    if model.legs is not None and model.drive == "legged":
        force = model.legs.grf_max if leaps else 1.0
        return replace(
            model,
            max_speed_x=model.legs.v_max,
            max_speed_y=model.legs.v_max,
            max_yaw_rate=model.legs.yaw_rate,
            max_acceleration=model.legs.mu * _GRAVITY * force,
            max_yaw_acceleration=math.inf,
        )
    turning, second = model.drive.startswith("unicycle"), model.drive.endswith("-2")
    free = model.round and not turning
    return replace(
        model,
        max_speed_y=model.max_speed_x * (SIDEWAYS if turning else 1.0),
        max_yaw_rate=math.inf if free else model.max_yaw_rate,
        max_acceleration=model.max_acceleration if second else math.inf,
        max_yaw_acceleration=model.max_yaw_acceleration if second and turning else math.inf,
    )


def check_own_arrival(
    scenario: Scenario, tracks: tuple[Track, ...], criterion: Criterion = IDEAL
) -> list[Violation]:
    """What contradicts the claim that every robot stands at its goal."""
    end = max(float(track.time[-1]) for track in tracks)
    everyone = tuple(range(len(tracks)))
    final = np.array([track.pose[-1] for track in tracks])
    goals = np.array(scenario.goals)
    errors = np.hypot(*(final[:, :2] - goals[:, :2]).T)
    turns = np.abs(wrap_angle(final[:, 2] - goals[:, 2]))
    # Where a robot that goes in all directions looks is of no interest.
    turns[[model.drive.startswith("integrator") for model in scenario.models]] = 0.0
    return standing(scenario, tracks, everyone, errors, turns, end, "its goal", criterion)
