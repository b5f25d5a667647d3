"""Unitree Go1: figures of the maker's URDF."""

from __future__ import annotations

from cavalcade.robots.building import LegParts, four_legs, trunk_with
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.robots.inertial import Inertial
from cavalcade.robots.looks import Outline, look_shapes, solid_shapes
from cavalcade.robots.unitree import SOURCE, SPEED, TORQUE, X, Y, joint, rotor

_LEG = LegParts(
    joints=(
        joint((0.1881, 0.04675, 0.0), X, -0.863, 0.863, TORQUE, SPEED),
        joint((0.0, 0.08, 0.0), Y, -0.686, 4.501, TORQUE, SPEED),
        joint((0.0, 0.0, -0.213), Y, -2.818, -0.888, torque=35.55, speed=20.06),
    ),
    links=(
        Inertial(
            0.591,
            (-0.005657, -0.008752, -0.000102),
            (0.000334008405, 0.000619101213, 0.00040057614, -1.0826066e-05, 1.290732e-06,
             1.643194e-06),
        ),
        Inertial(
            0.92,
            (-0.003342, -0.018054, -0.033451),
            (0.004431760472, 0.004485671726, 0.000740309489, 5.7496807e-05, -0.000218457134,
             0.000572001265),
        ),
        Inertial(
            0.135862,
            (0.006197, 0.001408, -0.116695),
            (0.001088793059, 0.001100428748, 2.4787446e-05, -2.55679e-07, 7.117814e-06,
             2.077264e-06),
        ),
    ),
    rotors=(
        rotor((0.11215, 0.04675, 0.0), 0),
        rotor((0.0, -0.00015, 0.0), 1),
        rotor((0.0, -0.03235, 0.0), 1),
    ),
    foot=Inertial(0.06, (0.0, 0.0, 0.0), (9.6e-06, 9.6e-06, 9.6e-06, 0.0, 0.0, 0.0)),
    foot_place=(0.0, 0.0, -0.213),
    mirrored_calf=False,
)  # fmt: skip

# The trunk and its IMU. The cameras' and other sensors' placeholders, 0.01 g each, are left out.
_TRUNK = (
    Inertial(
        5.204,
        (0.0223, 0.002, -0.0005),
        (0.0168128557, 0.063009565, 0.0716547275, -0.0002296769, -0.0002945293, -4.18731e-05),
    ),
    Inertial(0.001, (-0.01592, -0.06659, -0.00617), (0.0001, 0.0001, 0.0001, 0.0, 0.0, 0.0)),
)

_OUTLINE = Outline(
    trunk=(0.1881, 0.0935, 0.057),
    head=(0.05, 0.044, 0.042),
    head_place=(0.23, 0.0, 0.008),
    hip_radius=0.046,
    hip_half=0.045,
    thigh_motor=(0.045, 0.03),
    thigh_length=0.213,
    calf_length=0.213,
    thigh_side=0.08,
    thigh_radius=0.017,
    calf_radius=0.012,
    foot_radius=0.02,
    body=(0.70, 0.75, 0.80),
    dark=(0.16, 0.16, 0.18),
    accent=(0.05, 0.35, 0.65),
)

GO1 = QuadrupedDescription(
    name="go1",
    trunk=trunk_with(_LEG, _TRUNK),
    legs=four_legs(_LEG),
    foot_radius=0.02,
    stand_height=0.28,
    looks=look_shapes(_OUTLINE),
    solids=solid_shapes(_OUTLINE),
    source=f"Unitree's go1_description (unitree_ros): {SOURCE}",
)
"""Rigid-body figures and shapes of Go1."""
