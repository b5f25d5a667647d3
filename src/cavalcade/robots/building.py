"""A description out of published figures of the front left leg: the others are its mirror images.

Published descriptions list motors' rotors and feet as bodies of their own that are fixed to links;
here they are part of these links, so that the totals stay what they were.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from cavalcade.robots.description import JointDescription, LegDescription
from cavalcade.robots.inertial import Inertial, Vector, combined


@dataclass(frozen=True)
class Rotor:
    """A motor's rotor.

    Attributes:
        place: In the frame of the link that carries it, m.
        along: Its axis, 0 for x and 1 for y.
        mass: kg.
        axial, across: Moments of inertia about its axis and across it, kg m².
    """

    place: Vector
    along: int
    mass: float
    axial: float
    across: float

    @property
    def body(self) -> Inertial:
        """The rotor in its link's frame."""
        xx, yy = (self.axial, self.across) if self.along == 0 else (self.across, self.axial)
        return Inertial(self.mass, self.place, (xx, yy, self.across, 0.0, 0.0, 0.0))


@dataclass(frozen=True)
class LegParts:
    """Published figures of the front left leg.

    Attributes:
        joints: Hip, thigh, calf.
        links: Hip, thigh, calf without rotors and foot, each in its own frame.
        rotors: Of the hip's motor (carried by the trunk), the thigh's (by the hip) and the calf's
            (by the thigh).
        foot: In its own frame, the centre of the ball.
        foot_place: Of that frame in the calf's, m.
        mirrored_calf: Whether right calves are the left ones' mirror images, or the same part.
        rear_thigh: Range of the rear legs' thigh joint where it is another one, rad.
    """

    joints: tuple[JointDescription, JointDescription, JointDescription]
    links: tuple[Inertial, Inertial, Inertial]
    rotors: tuple[Rotor, Rotor, Rotor]
    foot: Inertial
    foot_place: Vector
    mirrored_calf: bool = True
    rear_thigh: tuple[float, float] | None = None


def four_legs(
    parts: LegParts,
) -> tuple[LegDescription, LegDescription, LegDescription, LegDescription]:
    """Front left, front right, rear left, rear right."""
    front_left, front_right = _leg(parts, False, False), _leg(parts, False, True)
    return front_left, front_right, _leg(parts, True, False), _leg(parts, True, True)


def trunk_with(parts: LegParts, trunk: Iterable[Inertial]) -> Inertial:
    """The trunk's own bodies and the rotors of the four hip motors as one body."""
    rotor = parts.rotors[0].body
    corners = [rotor.mirrored(x, y) for x in (False, True) for y in (False, True)]
    return combined([*trunk, *corners])


def _leg(parts: LegParts, rear: bool, right: bool) -> LegDescription:
    hip, thigh, calf = parts.links
    # Only the hip has a front and a back; thighs and calves are the same in front and behind.
    hip = combined([hip.mirrored(x=rear), parts.rotors[1].body])
    thigh = combined([thigh, parts.rotors[2].body])
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
