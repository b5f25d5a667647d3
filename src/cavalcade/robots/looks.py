"""Primitive shapes of a quadruped: enough to look like the robot, few enough to be quick."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cavalcade.robots.description import BodyShape, PartName
from cavalcade.robots.inertial import Vector

_LEVEL = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
"""Turns a cylinder's z axis along x."""

_SIDEWAYS = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Turns a cylinder's z axis along y (pointing to -y)."""


@dataclass(frozen=True)
class Outline:
    """Sizes read off the published meshes, m.

    Attributes:
        trunk: Half lengths of the trunk's box.
        head: Half lengths of the box of the head.
        head_place: Its centre in the trunk's frame.
        hip_radius, hip_half: Of the drum around the hip's motor, which lies along y.
        thigh_motor: Radius and half length of the drum of the knee's motor.
        thigh_length, calf_length: Between joints, and from the knee to the foot's centre.
        thigh_side: y of the left thighs' joint in the hip's frame.
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
    thigh_length: float
    calf_length: float
    thigh_side: float
    thigh_radius: float
    calf_radius: float
    foot_radius: float
    body: Vector
    dark: Vector
    accent: Vector


def solid_shapes(outline: Outline) -> tuple[BodyShape, ...]:
    """What touches: trunk, head, and per leg hip, thigh, calf and foot."""
    o = outline
    shapes = [
        BodyShape("trunk", -1, "box", o.trunk, (0.0, 0.0, 0.0), color=o.body),
        BodyShape("trunk", -1, "box", o.head, o.head_place, color=o.dark),
    ]
    for leg in range(4):
        side = o.thigh_side if leg % 2 == 0 else -o.thigh_side
        shapes += [
            # A ball around the hip's motor: the cheapest shape there is.
            BodyShape("hip", leg, "sphere", (o.hip_radius, 0.0, 0.0), (0.0, side / 2, 0.0)),
            _bone("thigh", leg, o.thigh_length, o.thigh_radius, o.body),
            _bone("calf", leg, o.calf_length, o.calf_radius, o.dark),
            _foot(leg, o),
        ]
    return tuple(shapes)


def look_shapes(outline: Outline) -> tuple[BodyShape, ...]:
    """What the robot looks like."""
    o = outline
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
        side, inner = sign * o.thigh_side, sign * (o.thigh_side - 0.045)
        shapes += [
            BodyShape("hip", leg, "cylinder", (o.hip_radius, o.hip_half, 0.0), (0.0, 0.0, 0.0),
                      _LEVEL, o.dark),
            BodyShape("hip", leg, "cylinder", (o.hip_radius * 0.9, abs(inner) / 2 + 0.01, 0.0),
                      (0.0, side / 2, 0.0), _SIDEWAYS, o.body),
            BodyShape("thigh", leg, "cylinder", (*o.thigh_motor, 0.0),
                      (0.0, -sign * o.thigh_motor[1] * 0.6, 0.0), _SIDEWAYS, o.dark),
            _bone("thigh", leg, o.thigh_length, o.thigh_radius * 1.15, o.body),
            _bone("calf", leg, o.calf_length, o.calf_radius, o.dark),
            _foot(leg, o),
        ]  # fmt: skip
    return tuple(shapes)


def _bone(part: PartName, leg: int, length: float, radius: float, color: Vector) -> BodyShape:
    """A capsule straight down from the link's joint."""
    half = length / 2 - radius * 0.5
    return BodyShape(
        part, leg, "capsule", (radius, half, 0.0), (0.0, 0.0, -length / 2), color=color
    )


def _foot(leg: int, outline: Outline) -> BodyShape:
    place = (0.0, 0.0, -outline.calf_length)
    return BodyShape(
        "foot", leg, "sphere", (outline.foot_radius, 0.0, 0.0), place, color=outline.dark
    )
