"""What kernels take: a robot's parameters, the space it moves in, and the layout of primitives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import STEP
from cavalcade.lattice.ground import Ground, read_only
from cavalcade.robots import RobotModel

KIND, START, END, TIME = 0, 1, 7, 13
FORCE, FLIGHT, LAND, BRAKE = 14, 17, 18, 19
"""Where a primitive `(SIZE,)` has its kind, its states at both ends (position and velocity, 6
each) and its duration in s; of a leap that is the take-off's, and there follow the take-off's
peak force (3, in body weights), the durations of flight and landing, and the landing's force."""

SIZE = 22

CONNECT, LEAP = 0.0, 1.0
"""Kinds of primitives."""

OK, SOLID, GROUND, MOTION = 0, 1, 2, 3
"""What is wrong with a state or a primitive: nothing; it collides with something solid or leaves
the map; the ground does not carry it; speeds, forces or yaw rate are beyond the limits."""


LEAST_TRAVERSABILITY = 0.3
"""Below this no foot may stand."""


class Body(NamedTuple):
    """Parameters of one robot and of one way of planning for it; lengths in m, rates in SI units.

    Attributes:
        half_length, half_width: Of the footprint that keeps clear of solids.
        trunk_half_length, trunk_half_width, belly: Of the trunk, and from its centre to its belly.
        hip_x, hip_y: Of the hips, from the centre.
        h_min, h_nom, h_max: Least height of the belly, nominal height of the centre, and how far
            the legs reach below a hip.
        v_nom, v_max, yaw_rate: Walking speed and limits.
        mu, grf_max: Friction coefficient, and the largest ground force in body weights.
        margin: Kept between the footprint and solids.
        dt: Between the states of a primitive that are checked.
        leaps: Whether the robot may leap.
        published: Whether it plans as the published planner does.
    """

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
    leaps: bool
    published: bool


class StateSpace(NamedTuple):
    """What tells valid states from others, as all kernels of this package take it.

    Attributes:
        ground: Its arrays are read-only.
        body: The robot's parameters.
        discs: `(K, 3)` x, y, radius in m where the body's centre may not be.
    """

    ground: Ground
    body: Body
    discs: Array


def make_body(
    model: RobotModel, published: bool = False, margin: float = 0.0, leaps: bool = True
) -> Body:
    """Parameters of a model.

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
        leaps=bool(leaps),
        published=bool(published),
    )


def make_space(ground: Ground, body: Body, discs: Array | None = None) -> StateSpace:
    """The space of a body on a ground; its arrays are of one type, so that kernels compile once."""
    keep_out = np.zeros((0, 3)) if discs is None else np.ascontiguousarray(discs)
    return StateSpace(read_only(ground), body, keep_out)
