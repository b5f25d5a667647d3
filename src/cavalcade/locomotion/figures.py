"""A robot's description as the row of figures that the compiled controller takes."""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array
from cavalcade.locomotion.records import ROBOT
from cavalcade.robots.description import QuadrupedDescription


def robot_figures(description: QuadrupedDescription) -> Array:
    """A row `()` of `ROBOT`."""
    figures = np.zeros((), ROBOT)
    offsets = description.joint_offsets
    figures["mass"] = description.mass
    figures["centre"], figures["inertia"] = composite(description, description.standing)
    figures["trunk_mass"], figures["trunk_centre"] = (
        description.trunk.mass,
        description.trunk.center,
    )
    figures["hip"] = offsets[:, 0]
    figures["side"] = offsets[:, 1, 1]
    figures["thigh"] = np.linalg.norm(offsets[0, 2])
    figures["calf"] = np.linalg.norm(offsets[0, 3])
    figures["foot_radius"] = description.foot_radius
    figures["link_mass"] = [[link.mass for link in leg.links] for leg in description.legs]
    figures["link_centre"] = [[link.center for link in leg.links] for leg in description.legs]
    figures["lowest"], figures["highest"] = description.joint_range.T
    figures["torque"] = description.torque_limits
    figures["damping"] = [joint.damping for joint in description.joints]
    figures["friction"] = [joint.friction for joint in description.joints]
    return figures


def composite(description: QuadrupedDescription, joints: Array) -> tuple[Array, Array]:
    """Centre of mass `(3,)` and inertia about it `(3, 3)` of a robot with its joints locked.

    Args:
        description: The robot.
        joints: `(12,)` rad.
    """
    bodies = [(description.trunk, np.zeros(3), np.eye(3))]
    for leg, angles in zip(description.legs, np.reshape(joints, (4, 3)), strict=True):
        place, turned = np.zeros(3), np.eye(3)
        for joint, link, angle in zip(leg.joints, leg.links, angles, strict=True):
            place = place + turned @ np.array(joint.offset)
            turned = turned @ _about(joint.axis, float(angle))
            bodies.append((link, place, turned))
    masses = np.array([body.mass for body, _, _ in bodies])
    centres = np.array([place + turned @ np.array(body.center) for body, place, turned in bodies])
    centre = masses @ centres / masses.sum()
    total = np.zeros((3, 3))
    for (body, _, turned), mass, at in zip(bodies, masses, centres, strict=True):
        arm = at - centre
        total += turned @ body.matrix @ turned.T
        total += mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return centre, total


def _about(axis: tuple[float, float, float], angle: float) -> Array:
    """The rotation by an angle about a unit vector (Rodrigues)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew)
