"""What Unitree's small quadrupeds have in common: one motor for all joints."""

from __future__ import annotations

from cavalcade.robots.building import Rotor
from cavalcade.robots.description import JointDescription
from cavalcade.robots.inertial import Vector

TORQUE, SPEED = 23.7, 30.1
"""Largest torque and speed of the motor behind its gear (GO-M8010-6): N m, rad/s."""

GEAR = 6.33
"""Of that gear, from its data sheet."""

ROTOR_MASS, ROTOR_AXIAL, ROTOR_ACROSS = 0.089, 0.000111842, 5.9647e-05
"""Of the motor's rotor: kg, kg m² about its axis and across it."""

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)

SOURCE = (
    "masses, offsets, ranges, torques, speeds and rotors from the URDF; gear 6.33 from the data "
    "sheet of the motor GO-M8010-6, times what the knee's linkage adds; torque taken to fall in a "
    "straight line from the largest torque at rest to none at the largest speed"
)


def joint(
    offset: Vector, axis: Vector, lower: float, upper: float, torque: float, speed: float
) -> JointDescription:
    """A joint with this motor; a larger torque than the motor's means a linkage in between.

    Damping and dry friction are those of Go1's URDF; no other description publishes any. The
    rotor turns faster than the joint, so the joint feels its inertia times the gear squared. Its
    inertia at rest in the link that carries it is part of that link's.
    """
    gear = GEAR * torque / TORQUE
    return JointDescription(
        offset,
        axis,
        lower,
        upper,
        torque,
        speed,
        damping=0.01,
        friction=0.2,
        armature=ROTOR_AXIAL * gear**2,
        stall_torque=torque,
        no_load_speed=speed,
    )


def rotor(place: Vector, along: int) -> Rotor:
    """The motor's rotor at a place of the link that carries it; its axis 0 for x, 1 for y."""
    return Rotor(place, along, ROTOR_MASS, ROTOR_AXIAL, ROTOR_ACROSS)
