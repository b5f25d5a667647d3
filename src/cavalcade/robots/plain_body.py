"""A plain mechanism for legged robots that have figures for planning but none for physics."""

from __future__ import annotations

import math
from dataclasses import replace

from cavalcade.geometry import GRAVITY
from cavalcade.robots.description import (
    LEGS,
    BodyShape,
    Inertial,
    JointDescription,
    LegDescription,
    QuadrupedDescription,
    Vector,
)
from cavalcade.robots.model import LegModel, RobotModel

_SHARES = (0.05, 0.06, 0.015)
"""Of the whole mass in each hip, thigh and calf, about as Go1 and Go2 have them; the trunk has the
rest."""

_RADIUS = 0.02
"""Of thighs, calves and feet, m."""

_TORQUE, _SPEED = 0.3, 25.0
"""Joint limits: torque in units of body weight times leg length, and rad/s."""

_DARK = (0.2, 0.2, 0.2)


def body_of(model: RobotModel) -> QuadrupedDescription | None:
    """The mechanism by which a robot is drawn and described: its own, or a plain one.

    The plain one is made of `model.legs`: a box as the trunk, hips where planners have them, legs
    that reach as far as theirs. It is for drawing, not for physics. None for robots without legs.
    """
    if model.description is not None or model.legs is None:
        return model.description
    legs = model.legs
    trunk = (model.length / 2.0, max(legs.hip_y, 0.05), max(legs.trunk_height, 0.1) / 2.0)
    mass = legs.mass * (1.0 - len(LEGS) * sum(_SHARES))
    side = max(model.width / 2.0 - legs.hip_y - _RADIUS, 0.02)
    bone = legs.h_max / 2.0
    return QuadrupedDescription(
        name=model.name,
        trunk=_box(mass, trunk, (0.0, 0.0, 0.0)),
        legs=tuple(
            _leg(legs, front, left, side, bone) for front in (1.0, -1.0) for left in (1.0, -1.0)
        ),
        foot_radius=_RADIUS,
        stand_height=legs.h_nom,
        looks=(shapes := _shapes(trunk, side, bone)),
        solids=shapes,
        source=f"a plain mechanism with the figures for planning of {model.name}",
    )


def _leg(legs: LegModel, front: float, left: float, side: float, bone: float) -> LegDescription:
    hip, thigh, calf = (share * legs.mass for share in _SHARES)
    down = (0.0, 0.0, -bone / 2.0)
    slim = (_RADIUS, _RADIUS, bone / 2.0)
    torque = _TORQUE * legs.mass * GRAVITY * legs.h_max
    joint = JointDescription(
        offset=(front * legs.hip_x, left * legs.hip_y, 0.0),
        axis=(1.0, 0.0, 0.0),
        lower=-0.9,
        upper=0.9,
        torque=torque,
        speed=_SPEED,
        damping=0.0,
        friction=0.0,
        armature=0.0,
        stall_torque=torque,
        no_load_speed=_SPEED,
    )
    about_y = replace(joint, axis=(0.0, 1.0, 0.0))
    return LegDescription(
        joints=(
            joint,
            replace(about_y, offset=(0.0, left * side, 0.0), lower=-math.pi / 2.0, upper=math.pi),
            replace(about_y, offset=(0.0, 0.0, -bone), lower=-2.8, upper=0.0),
        ),
        links=(
            _box(hip, (0.04, side / 2.0, 0.04), (0.0, left * side / 2.0, 0.0)),
            _box(thigh, slim, down),
            _box(calf, slim, down),
        ),
        foot=(0.0, 0.0, _RADIUS - bone),
    )


def _box(mass: float, half: Vector, center: Vector) -> Inertial:
    """A solid box with these half lengths."""
    x, y, z = (size * size for size in half)
    return Inertial(
        mass, center, (mass * (y + z) / 3, mass * (x + z) / 3, mass * (x + y) / 3, 0.0, 0.0, 0.0)
    )


def _shapes(trunk: Vector, side: float, bone: float) -> tuple[BodyShape, ...]:
    shapes = [BodyShape("trunk", -1, "box", trunk, (0.0, 0.0, 0.0), color=(0.6, 0.6, 0.65))]
    rod = (_RADIUS, bone / 2.0 - _RADIUS, 0.0)
    for leg in range(len(LEGS)):
        middle = side / 2.0 if leg % 2 == 0 else -side / 2.0
        shapes += [
            BodyShape("hip", leg, "sphere", (0.045, 0.0, 0.0), (0.0, middle, 0.0), color=_DARK),
            BodyShape("thigh", leg, "capsule", rod, (0.0, 0.0, -bone / 2.0)),
            BodyShape("calf", leg, "capsule", rod, (0.0, 0.0, -bone / 2.0), color=_DARK),
            BodyShape("foot", leg, "sphere", (_RADIUS, 0.0, 0.0), (0.0, 0.0, _RADIUS - bone)),
        ]
    return tuple(shapes)
