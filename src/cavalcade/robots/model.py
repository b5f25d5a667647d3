"""What planners, fleets and the checker need to know of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cavalcade.errors import InputError
from cavalcade.robots.legs import GO1, GO2, SPIRIT, LegModel

Drive = Literal["legged", "unicycle", "unicycle-2", "integrator", "integrator-2"]


@dataclass(frozen=True)
class RobotModel:
    """A robot seen from above.

    Under a formation planner robots are holonomic: the reachable velocities form an ellipse in
    the body frame with the semi-axes `max_speed_x` and `max_speed_y` (Norén et al., eq. 8).
    With goals of their own they move as `drive` says: `legged` as `legs` says; `unicycle`
    forwards, backwards and turning, `unicycle-2` the same with limited accelerations;
    `integrator` and `integrator-2` in all directions up to `max_speed_x`, the latter with
    limited acceleration.

    Attributes:
        name: The name scenario files use.
        length, width, height: Body in m; `length` lies along x. `length` and `width` are the
            oriented footprint that the checker sweeps; of a round robot both are its diameter.
        max_speed_x, max_speed_y: m/s, along and across the body.
        max_yaw_rate: rad/s.
        max_acceleration: m/s², of the velocity seen in the map frame.
        max_yaw_acceleration: rad/s².
        source: Where the figures come from.
        drive: How it moves towards a goal of its own.
        round: Whether the footprint is a disc.
        legs: Of a legged robot.
    """

    name: str
    length: float
    width: float
    height: float
    max_speed_x: float
    max_speed_y: float
    max_yaw_rate: float
    max_acceleration: float
    max_yaw_acceleration: float
    source: str
    drive: Drive = "legged"
    round: bool = False
    legs: LegModel | None = None


_WALKING = {
    "max_speed_x": 0.50,
    "max_speed_y": 0.20,
    "max_yaw_rate": 1.2,
    "max_acceleration": 1.0,
    "max_yaw_acceleration": 2.0,
}

MODELS: dict[str, RobotModel] = {
    model.name: model
    for model in (
        RobotModel(
            "go1",
            length=0.65,
            width=0.28,
            height=0.40,
            **_WALKING,
            source="Norén et al., Role-Adaptive Collaborative Formation Planning: body and speeds",
            legs=GO1,
        ),
        RobotModel(
            "go2",
            length=0.70,
            width=0.31,
            height=0.40,
            **_WALKING,
            source="Unitree's data sheet of Go2: body; speeds as for go1",
            legs=GO2,
        ),
        RobotModel(
            "spirit",
            length=0.70,
            width=0.35,
            height=0.35,
            **_WALKING,
            source="Ghost Robotics Spirit 40: body; speeds as for go1",
            legs=SPIRIT,
        ),
    )
}


def robot_model(name: str) -> RobotModel:
    """The model of that name.

    Raises:
        InputError: There is none; the message lists those there are.
    """
    try:
        return MODELS[name]
    except KeyError:
        raise InputError(f"unknown robot model {name!r}", choices=MODELS) from None
