"""Ideal robots that are able to do what plans are made of, and nothing more."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cavalcade.fleet import IdealFleet
from cavalcade.geometry.constants import GRAVITY
from cavalcade.geometry.trajectory import FLIGHT, Trajectory
from cavalcade.robots import RobotModel
from cavalcade.scenario import Scenario

_SIDEWAYS = 1e-3
"""Of a robot that cannot move sideways, m/s."""


def tracking_model(model: RobotModel, leaps: bool) -> RobotModel:
    """The model with the limits that plans keep to, in the place of those under formations.

    Args:
        model: Any robot.
        leaps: Whether it will leap: legs then push with their largest force.
    """
    if model.drive == "legged" and model.legs is not None:
        legs = model.legs
        return replace(
            model,
            max_speed_x=legs.v_max,
            max_speed_y=legs.v_max,
            max_yaw_rate=legs.yaw_rate,
            max_acceleration=legs.mu * GRAVITY * (legs.grf_max if leaps else 1.0),
            max_yaw_acceleration=math.inf,
        )
    second = model.drive.endswith("-2")
    if model.drive.startswith("unicycle"):
        # The limit is that of the speed; in a bend the velocity turns besides.
        bend = model.max_speed_x * model.max_yaw_rate
        return replace(
            model,
            max_speed_y=_SIDEWAYS,
            max_acceleration=math.hypot(model.max_acceleration, bend) if second else math.inf,
            max_yaw_acceleration=model.max_yaw_acceleration if second else math.inf,
        )
    return replace(
        model,
        max_speed_y=model.max_speed_x,
        max_acceleration=model.max_acceleration if second else math.inf,
        max_yaw_acceleration=math.inf,
    )


def tracking_fleet(scenario: Scenario, paths: Sequence[Trajectory | None]) -> IdealFleet:
    """The robots of a scenario at their starts, able to follow these trajectories."""
    models = [
        tracking_model(model, path is not None and bool(np.any(path.phase == FLIGHT)))
        for model, path in zip(scenario.models, paths, strict=True)
    ]
    return IdealFleet(models, scenario.starts, seed=scenario.seed)
