"""A description out of published figures of the front left leg: the others are its mirror images.

Published descriptions list motors' rotors and feet as bodies of their own that are fixed to links;
here they are part of these links, so that the totals stay what they were.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from cavalcade.robots.description import JointDescription, LegDescription, QuadrupedDescription
from cavalcade.robots.inertial import Inertial, Vector, combined
from cavalcade.robots.looks import Outline, look_shapes, solid_shapes


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
        legs=(
            _leg(parts, rear=False, right=False),
            _leg(parts, rear=False, right=True),
            _leg(parts, rear=True, right=False),
            _leg(parts, rear=True, right=True),
        ),
        foot_radius=outline.foot_radius,
        stand_height=stand_height,
        looks=look_shapes(outline),
        solids=solid_shapes(outline),
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
