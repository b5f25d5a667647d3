"""What planners, fleets and the checker need to know of a robot."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, fields
from typing import Any, Literal, Self, get_args

from cavalcade.errors import InputError
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.values import instance_of, number_in, plain_number

Drive = Literal["legged", "unicycle", "unicycle-2", "integrator", "integrator-2"]


@dataclass(frozen=True)
class LegModel:
    """Figures of a quadruped for planning its body's motion over terrain.

    Heights are clearances of the body's centre above the ground. The trunk that terrain is
    tested against is smaller than the footprint that keeps robots apart.

    Attributes:
        h_min, h_nom, h_max: Least clearance, that of walking, and the reach of the legs, m.
        v_nom, v_max: Walking speed and the largest speed of the body, m/s.
        yaw_rate: Largest when walking in a bend or turning on the spot, rad/s.
        acceleration: That walking robots speed up and slow down with, m/s².
        trunk_length, trunk_width, trunk_height: m.
        hip_x, hip_y: Hips stand at (±hip_x, ±hip_y) in the body frame, m.
        mass: kg.
        mu: Friction of the ground, which bounds horizontal accelerations by mu g.
        grf_max: Largest ground reaction force in body weights.
        gait_period, duty: Of the trot: s, and the share of it that a foot stands.
        swing_height: Of a foot over the ground between steps, m.
        source: Where the figures come from.
    """

    h_min: float
    h_nom: float
    h_max: float
    v_nom: float
    v_max: float
    yaw_rate: float
    acceleration: float
    trunk_length: float
    trunk_width: float
    trunk_height: float
    hip_x: float
    hip_y: float
    mass: float
    mu: float
    grf_max: float
    gait_period: float
    duty: float
    swing_height: float
    source: str

    def __post_init__(self) -> None:
        for figure in fields(self):
            if figure.name != "source":
                number_in(getattr(self, figure.name), f"legs.{figure.name}", 0.0)
        for low, high in (("h_min", "h_nom"), ("h_nom", "h_max"), ("v_nom", "v_max")):
            if not getattr(self, low) <= getattr(self, high):
                raise InputError(f"expected at most {high}", key=f"legs.{low}")
        for name in _POSITIVE:
            if getattr(self, name) == 0.0:
                raise InputError("expected a number above 0", key=f"legs.{name}")


_POSITIVE = ("h_nom", "v_nom", "yaw_rate", "acceleration", "mass", "mu", "grf_max", "gait_period")


@dataclass(frozen=True)
class RobotModel:
    """A robot seen from above.

    Under a formation planner robots are holonomic: the reachable velocities form an ellipse in
    the body frame with the semi-axes `max_speed_x` and `max_speed_y` (Norén et al., eq. 8).
    With goals of their own they move as `drive` says: `legged` as `legs` says; `unicycle`
    forwards, backwards and turning, `unicycle-2` the same with limited accelerations;
    `integrator` and `integrator-2` in all directions, the latter with limited acceleration. Their
    limits hold for the vector's length, whatever its direction.

    Attributes:
        name: The name scenario files use.
        length, width, height: Body in m; `length` lies along x. `length` and `width` are the
            oriented footprint that the checker sweeps; of a round robot both are its diameter.
        max_speed_x, max_speed_y: m/s, along and across the body.
        max_yaw_rate: rad/s.
        max_acceleration: m/s², of the velocity seen in the map frame; inf for drives without.
        max_yaw_acceleration: rad/s²; likewise.
        source: Where the figures come from.
        tracking_error: How far a walking robot may be, in physics, from where the motion model of
            `cavalcade.robots.motion` sees it come to a stop, m; see docs/how-to/physics.md.
        drive: How it moves towards a goal of its own.
        round: Whether the footprint is a disc.
        legs: Of a legged robot, for planners.
        description: Its mechanism, for physics; None where there is none.

    Raises:
        InputError: A value of another kind or out of range; the key is the attribute.
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
    tracking_error: float = 0.0
    drive: Drive = "legged"
    round: bool = False
    legs: LegModel | None = field(default=None, repr=False)
    description: QuadrupedDescription | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        _check_values(self)

    def with_limits(self, **values: Any) -> Self:
        """A copy with other limits or another outline, which need not be those of any robot.

        For those who carry out or judge motion of another kind; nothing is checked.
        """
        copy = object.__new__(type(self))
        copy.__dict__.update(self.__dict__ | values)
        return copy

    @property
    def body(self) -> tuple[float, float, float]:
        """The footprint as an inflated rectangle: length, width and inflation, m."""
        if self.round:
            return 0.0, 0.0, 0.5 * self.length
        return self.length, self.width, 0.0


_NAME = re.compile(r"[A-Za-z0-9][\w-]{0,59}")
_RANGES: dict[str, tuple[float, float]] = {
    "length": (0.01, 100.0),
    "width": (0.01, 100.0),
    "height": (0.01, 100.0),
    "max_speed_x": (0.01, 100.0),
    "max_speed_y": (0.0, 100.0),
    "max_yaw_rate": (0.01, 100.0),
    "max_acceleration": (0.01, math.inf),
    "max_yaw_acceleration": (0.01, math.inf),
    "tracking_error": (0.0, 10.0),
}
"""Least and largest values: m, m/s, rad/s, m/s², rad/s²."""


def check_model(model: RobotModel) -> None:
    """Refuse a model whose values do not fit together: nothing can plan for it.

    Each value by itself is checked when a model is made.

    Raises:
        InputError: One line with the attribute and what was expected.
    """
    _check_values(model)
    if model.round and model.length != model.width:
        raise InputError("expected the same length and width of a round robot", key="round")
    if model.drive in ("legged", "integrator", "integrator-2") and model.max_speed_y == 0.0:
        raise InputError(f"a robot with drive {model.drive} moves sideways, too", key="max_speed_y")
    turning = model.max_speed_x * model.max_yaw_rate
    if turning > model.max_acceleration:
        raise InputError(
            f"expected at least max_speed_x * max_yaw_rate, {turning:g}, which turning at full "
            f"speed takes; got {model.max_acceleration:g}",
            key="max_acceleration",
        )


def _check_values(model: RobotModel) -> None:
    if not isinstance(model.name, str) or not _NAME.fullmatch(model.name):
        raise InputError("expected a name of letters, digits, - and _", key="name")
    for key, (least, most) in _RANGES.items():
        value = plain_number(getattr(model, key), key)
        if not least <= value <= most:
            raise InputError(f"expected {least:g} to {most:g}, got {value:g}", key=key)
    if not isinstance(model.drive, str) or model.drive not in get_args(Drive):
        raise InputError("unknown drive", key="drive", choices=get_args(Drive))
    instance_of(model.source, str, "source", "text")
    instance_of(model.round, bool, "round", "True or False")
    if model.legs is not None:
        instance_of(model.legs, LegModel, "legs")
    if model.description is not None:
        instance_of(model.description, QuadrupedDescription, "description")
