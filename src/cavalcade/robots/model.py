"""What planners, fleets and the checker need to know of a robot."""

from __future__ import annotations

from dataclasses import dataclass

from cavalcade.errors import InputError


@dataclass(frozen=True)
class RobotModel:
    """A holonomic walking robot seen from above.

    The reachable velocities form an ellipse in the body frame with the semi-axes
    `max_speed_x` and `max_speed_y` (Norén et al., eq. 8).

    Attributes:
        name: The name scenario files use.
        length, width, height: Body in m; `length` lies along x. `length` and `width` are the
            oriented footprint that the checker sweeps.
        max_speed_x, max_speed_y: m/s, along and across the body.
        max_yaw_rate: rad/s.
        max_acceleration: m/s², of the velocity seen in the map frame.
        max_yaw_acceleration: rad/s².
        source: Where the figures come from.
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
        ),
        RobotModel(
            "spirit",
            length=0.70,
            width=0.35,
            height=0.35,
            **_WALKING,
            source="Ghost Robotics Spirit 40: body; speeds as for go1",
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
