"""A description out of published figures of the front left leg: the others are its mirror images.

Published descriptions list motors' rotors and feet as bodies of their own that are fixed to links;
here they are part of these links, so that the totals stay what they were. Shapes are primitive:
enough to look like the robot, few enough to be quick.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cavalcade.robots.description import (
    BodyShape,
    Inertial,
    JointDescription,
    LegDescription,
    PartName,
    QuadrupedDescription,
    Vector,
    combined,
)

_LEVEL = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
"""Turns a cylinder's z axis along x."""

_SIDEWAYS = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Turns a cylinder's z axis along y (pointing to -y)."""


@dataclass(frozen=True)
class LegParts:
    """Published figures of the front left leg.

    Attributes:
        joints: Hip, thigh, calf.
        links: Hip, thigh, calf without rotors and foot, each in its own frame.
        rotors: Of the hip's motor (carried by the trunk), the thigh's (by the hip) and the calf's
            (by the thigh), each in the frame of the link that carries it.
        foot: In its own frame, the centre of the ball.
        foot_place: Of that frame in the calf's, m.
        mirrored_calf: Whether right calves are the left ones' mirror images, or the same part.
        rear_thigh: Range of the rear legs' thigh joint where it is another one, rad.
    """

    joints: tuple[JointDescription, JointDescription, JointDescription]
    links: tuple[Inertial, Inertial, Inertial]
    rotors: tuple[Inertial, Inertial, Inertial]
    foot: Inertial
    foot_place: Vector
    mirrored_calf: bool = True
    rear_thigh: tuple[float, float] | None = None


@dataclass(frozen=True)
class Outline:
    """Sizes read off the published meshes, m.

    Attributes:
        trunk: Half lengths of the trunk's box.
        head: Half lengths of the box of the head.
        head_place: Its centre in the trunk's frame.
        hip_radius, hip_half: Of the drum around the hip's motor, which lies along y.
        thigh_motor: Radius and half length of the drum of the knee's motor.
        thigh_radius, calf_radius: Of their capsules.
        foot_radius: m.
        body, dark, accent: Colours of the shell, of joints and feet, and of the face.
    """

    trunk: Vector
    head: Vector
    head_place: Vector
    hip_radius: float
    hip_half: float
    thigh_motor: tuple[float, float]
    thigh_radius: float
    calf_radius: float
    foot_radius: float
    body: Vector
    dark: Vector
    accent: Vector


def described(
    name: str,
    parts: LegParts,
    trunk: tuple[Inertial, ...],
    outline: Outline,
    stand_height: float,
    source: str,
) -> QuadrupedDescription:
    """The robot whose trunk is made of these bodies and the rotors of the four hip motors."""
    rotors = [parts.rotors[0].mirrored(x, y) for x in (False, True) for y in (False, True)]
    return QuadrupedDescription(
        name=name,
        trunk=combined([*trunk, *rotors]),
        legs=tuple(_leg(parts, rear, right) for rear in (False, True) for right in (False, True)),
        foot_radius=outline.foot_radius,
        stand_height=stand_height,
        looks=look_shapes(outline, parts),
        solids=solid_shapes(outline, parts),
        source=source,
    )


def _leg(parts: LegParts, rear: bool, right: bool) -> LegDescription:
    hip, thigh, calf = parts.links
    # Only the hip has a front and a back; thighs and calves are the same in front and behind.
    hip = combined([hip.mirrored(x=rear), parts.rotors[1]])
    thigh = combined([thigh, parts.rotors[2]])
    calf = combined([calf, parts.foot.moved(parts.foot_place)])
    links = (
        hip.mirrored(y=right),
        thigh.mirrored(y=right),
        calf.mirrored(y=right and parts.mirrored_calf),
    )
    first, second, third = (
        replace(joint, offset=_flipped(joint.offset, rear and number == 0, right))
        for number, joint in enumerate(parts.joints)
    )
    if rear and parts.rear_thigh is not None:
        second = replace(second, lower=parts.rear_thigh[0], upper=parts.rear_thigh[1])
    return LegDescription((first, second, third), links, _flipped(parts.foot_place, False, right))


def _flipped(vector: Vector, x: bool, y: bool) -> Vector:
    sx, sy = (-1.0 if x else 1.0), (-1.0 if y else 1.0)
    return (sx * vector[0] + 0.0, sy * vector[1] + 0.0, vector[2])  # no -0.0


def _lengths(parts: LegParts) -> tuple[float, float, float]:
    """Of hip (to the thigh's joint, along y), thigh and calf (to the foot's centre), m."""
    return parts.joints[1].offset[1], -parts.joints[2].offset[2], -parts.foot_place[2]


def solid_shapes(outline: Outline, parts: LegParts) -> tuple[BodyShape, ...]:
    """What touches: trunk, head, and per leg hip, thigh, calf and foot."""
    o, (hip, thigh, calf) = outline, _lengths(parts)
    shapes = [
        BodyShape("trunk", -1, "box", o.trunk, (0.0, 0.0, 0.0), color=o.body),
        BodyShape("trunk", -1, "box", o.head, o.head_place, color=o.dark),
    ]
    for leg in range(4):
        side = hip if leg % 2 == 0 else -hip
        shapes += [
            # A ball around the hip's motor: the cheapest shape there is.
            BodyShape("hip", leg, "sphere", (o.hip_radius, 0.0, 0.0), (0.0, side / 2, 0.0)),
            _bone("thigh", leg, thigh, o.thigh_radius, o.body),
            _bone("calf", leg, calf, o.calf_radius, o.dark),
            _foot(leg, calf, o),
        ]
    return tuple(shapes)


def look_shapes(outline: Outline, parts: LegParts) -> tuple[BodyShape, ...]:
    """What the robot looks like."""
    o, (hip, thigh, calf) = outline, _lengths(parts)
    length, width, height = o.trunk
    nose = (o.head_place[0] + o.head[0], 0.0, o.head_place[2])
    spine = (height * 0.55, length * 0.92, 0.0)
    shapes = [
        BodyShape("trunk", -1, "box", (length, width * 0.82, height * 0.86), (0.0, 0.0, 0.0),
                  color=o.body),
        # Rounded edges: two capsules along the back.
        *(BodyShape("trunk", -1, "capsule", spine, (0.0, s * (width - spine[0]), height - spine[0]),
                    _LEVEL, o.body) for s in (1.0, -1.0)),
        BodyShape("trunk", -1, "box", o.head, o.head_place, color=o.body),
        BodyShape("trunk", -1, "cylinder", (o.head[2] * 1.05, o.head[1], 0.0), nose, _SIDEWAYS,
                  o.body),
        BodyShape("trunk", -1, "box", (0.006, o.head[1] * 0.75, o.head[2] * 0.5),
                  (nose[0] + o.head[2], 0.0, nose[2]), color=o.accent),
    ]  # fmt: skip
    for leg in range(4):
        sign = 1.0 if leg % 2 == 0 else -1.0
        side, inner = sign * hip, sign * (hip - 0.045)
        shapes += [
            BodyShape("hip", leg, "cylinder", (o.hip_radius, o.hip_half, 0.0), (0.0, 0.0, 0.0),
                      _LEVEL, o.dark),
            BodyShape("hip", leg, "cylinder", (o.hip_radius * 0.9, abs(inner) / 2 + 0.01, 0.0),
                      (0.0, side / 2, 0.0), _SIDEWAYS, o.body),
            BodyShape("thigh", leg, "cylinder", (*o.thigh_motor, 0.0),
                      (0.0, -sign * o.thigh_motor[1] * 0.6, 0.0), _SIDEWAYS, o.dark),
            _bone("thigh", leg, thigh, o.thigh_radius * 1.15, o.body),
            _bone("calf", leg, calf, o.calf_radius, o.dark),
            _foot(leg, calf, o),
        ]  # fmt: skip
    return tuple(shapes)


def _bone(part: PartName, leg: int, length: float, radius: float, color: Vector) -> BodyShape:
    """A capsule straight down from the link's joint."""
    half = length / 2 - radius * 0.5
    return BodyShape(
        part, leg, "capsule", (radius, half, 0.0), (0.0, 0.0, -length / 2), color=color
    )


def _foot(leg: int, calf: float, outline: Outline) -> BodyShape:
    place = (0.0, 0.0, -calf)
    return BodyShape(
        "foot", leg, "sphere", (outline.foot_radius, 0.0, 0.0), place, color=outline.dark
    )
