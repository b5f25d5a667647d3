"""A robot's figures as kernels take them, and the layout of primitives."""

from __future__ import annotations

from typing import NamedTuple

from cavalcade.errors import InputError
from cavalcade.geometry.trajectory import STEP
from cavalcade.robots import RobotModel

GRAVITY = 9.81

KIND, START, END, TIME = 0, 1, 7, 13
FORCE, FLIGHT, LAND, BRAKE = 14, 17, 18, 19
"""Where a primitive `(SIZE,)` has its kind, its states at both ends (position and velocity, 6
each) and its duration in s; of a leap that is the take-off's, and there follow the take-off's
peak force (3, in body weights), the durations of flight and landing, and the landing's force."""

SIZE = 22

CONNECT, LEAP = 0.0, 1.0
"""Kinds of primitives."""

OK, SOLID, GROUND, MOTION = 0, 1, 2, 3
"""What is wrong with a state or a primitive: nothing; it meets something solid or leaves the map;
the ground does not carry it; speeds, forces or yaw rate are beyond the limits."""


class Body(NamedTuple):
    """Figures of one robot and one way of planning for it; lengths in m, rates in SI units."""

    half_length: float
    half_width: float
    trunk_half_length: float
    trunk_half_width: float
    belly: float
    hip_x: float
    hip_y: float
    h_min: float
    h_nom: float
    h_max: float
    v_nom: float
    v_max: float
    yaw_rate: float
    mu: float
    grf_max: float
    margin: float
    dt: float
    published: bool


def make_body(model: RobotModel, published: bool = False, margin: float = 0.0) -> Body:
    """Figures of a model.

    Raises:
        InputError: It has no legs.
    """
    legs = model.legs
    if legs is None:
        raise InputError(f"{model.name} has no legs to plan for", key="model")
    return Body(
        half_length=0.5 * model.length,
        half_width=0.5 * model.width,
        trunk_half_length=0.5 * legs.trunk_length,
        trunk_half_width=0.5 * legs.trunk_width,
        belly=0.5 * legs.trunk_height,
        hip_x=legs.hip_x,
        hip_y=legs.hip_y,
        h_min=legs.h_min,
        h_nom=legs.h_nom,
        h_max=legs.h_max,
        v_nom=legs.v_nom,
        v_max=legs.v_max,
        yaw_rate=legs.yaw_rate,
        mu=legs.mu,
        grf_max=legs.grf_max,
        margin=float(margin),
        dt=STEP,
        published=bool(published),
    )
