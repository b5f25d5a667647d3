"""A robot's description as the row of parameters that the compiled controller takes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.locomotion.records import ROBOT, Row
from cavalcade.robots.description import (
    JOINTS,
    LEGS,
    Inertial,
    LegDescription,
    QuadrupedDescription,
    combined,
)

_STRAIGHT = 5e-3  # m

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0))
"""Axes of the joints of hip, thigh and calf when all angles are zero."""


def robot_parameters(description: QuadrupedDescription) -> Row:
    """A row `()` of `ROBOT`.

    Raises:
        InputError: Legs of another kind than leg control can move: hip about x, beside it the
            thigh about y, straight below that at zero the calf about y and the foot; links of the
            same lengths in all legs.
    """
    _check_legs(description)
    row = np.zeros((), ROBOT)
    offsets = description.joint_offsets
    whole = composite(description, description.standing)
    row["mass"], row["centre"], row["inertia"] = whole.mass, whole.center, whole.matrix
    trunk = description.trunk
    row["trunk_mass"], row["trunk_centre"] = trunk.mass, trunk.center
    row["hip"] = offsets[:, 0]
    row["side"] = offsets[:, 1:, 1].sum(axis=1)
    row["thigh"], row["calf"] = -offsets[0, 2:, 2]
    row["foot_radius"] = description.foot_radius
    row["link_mass"] = [[link.mass for link in leg.links] for leg in description.legs]
    row["link_centre"] = [[link.center for link in leg.links] for leg in description.legs]
    row["lowest"], row["highest"] = description.joint_range.T
    row["torque"] = description.torque_limits
    row["damping"] = [joint.damping for joint in description.joints]
    row["friction"] = [joint.friction for joint in description.joints]
    return row


def composite(description: QuadrupedDescription, joints: ArrayLike) -> Inertial:
    """All of a robot as one body, trunk frame, its joints locked at angles `(12,)`, rad."""
    bodies = [description.trunk]
    for leg, angles in zip(description.legs, np.reshape(joints, (4, 3)), strict=True):
        place, turned = np.zeros(3), np.eye(3)
        for joint, link, angle in zip(leg.joints, leg.links, angles, strict=True):
            place = place + turned @ np.array(joint.offset)
            turned = turned @ _about(joint.axis, float(angle))
            x, y, z = (float(value) for value in place)
            bodies.append(link.turned(turned).moved((x, y, z)))
    return combined(bodies)


def _check_legs(description: QuadrupedDescription) -> None:
    """Refuse legs whose places `_kinematics` would get wrong."""
    offsets = description.joint_offsets
    for number, (name, leg) in enumerate(zip(LEGS, description.legs, strict=True)):
        problem = _problem_of_leg(name, leg, offsets[number])
        if problem is None and np.abs(offsets[number, 2:, 2] - offsets[0, 2:, 2]).max() > _STRAIGHT:
            problem = f"expected leg {name} to be as long as {LEGS[0]}"
        if problem is not None:
            raise InputError(problem, file=description.file or None, key=description.name)


def _problem_of_leg(name: str, leg: LegDescription, offsets: Array) -> str | None:
    """What is wrong with a leg whose joints and foot lie at `offsets` `(4, 3)` of the last, m."""
    for joint, axis, part in zip(leg.joints, AXES, JOINTS, strict=True):
        if np.abs(np.array(joint.axis) - axis).max() > _STRAIGHT:
            letter = "xy"[int(np.argmax(axis))]
            return f"expected the {part} joint of leg {name} to turn about {letter}"
    thigh, calf, foot = offsets[1:]
    if np.abs(thigh[[0, 2]]).max() > _STRAIGHT:
        return f"expected the thigh of leg {name} beside its hip, along y"
    if max(abs(calf[0]), abs(foot[0])) > _STRAIGHT or max(calf[2], foot[2]) >= 0.0:
        return f"expected leg {name} to hang straight down when its angles are zero"
    return None


def _about(axis: tuple[float, float, float], angle: float) -> Array:
    """The rotation by an angle about a unit vector (Rodrigues)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew)
