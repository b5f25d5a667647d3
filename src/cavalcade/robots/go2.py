"""Unitree Go2: figures of the maker's URDF."""

from __future__ import annotations

from cavalcade.robots.building import LegParts, four_legs, trunk_with
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.robots.inertial import Inertial
from cavalcade.robots.looks import Outline, look_shapes, solid_shapes
from cavalcade.robots.unitree import SOURCE, SPEED, TORQUE, X, Y, joint, rotor

_LEG = LegParts(
    joints=(
        joint((0.1934, 0.0465, 0.0), X, -1.0472, 1.0472, TORQUE, SPEED),
        joint((0.0, 0.0955, 0.0), Y, -1.5708, 3.4907, TORQUE, SPEED),
        joint((0.0, 0.0, -0.213), Y, -2.7227, -0.83776, torque=45.43, speed=15.70),
    ),
    links=(
        Inertial(
            0.678,
            (-0.0054, 0.00194, -0.000105),
            (0.00048, 0.000884, 0.000596, -3.01e-06, 1.11e-06, -1.42e-06),
        ),
        Inertial(
            1.152,
            (-0.00374, -0.0223, -0.0327),
            (0.00584, 0.0058, 0.00103, 8.72e-05, -0.000289, 0.000808),
        ),
        Inertial(
            0.154,
            (0.00548, -0.000975, -0.115),
            (0.00108, 0.0011, 3.29e-05, 3.4e-07, 1.72e-05, 8.28e-06),
        ),
    ),
    rotors=(
        rotor((0.11215, 0.04675, 0.0), 0),
        rotor((0.0, -0.00015, 0.0), 1),
        rotor((0.0, -0.03235, 0.0), 1),
    ),
    foot=Inertial(0.04, (0.0, 0.0, 0.0), (9.6e-06, 9.6e-06, 9.6e-06, 0.0, 0.0, 0.0)),
    foot_place=(0.0, 0.0, -0.213),
    rear_thigh=(-0.5236, 4.5379),
)

_TRUNK = (
    Inertial(
        6.921,
        (0.021112, 0.0, -0.005366),
        (0.02448, 0.098077, 0.107, 0.00012166, 0.0014849, -3.12e-05),
    ),
)

_OUTLINE = Outline(
    trunk=(0.1934, 0.0935, 0.06),
    head=(0.06, 0.045, 0.05),
    head_place=(0.25, 0.0, 0.005),
    hip_radius=0.046,
    hip_half=0.045,
    thigh_motor=(0.046, 0.03),
    thigh_length=0.213,
    calf_length=0.213,
    thigh_side=0.0955,
    thigh_radius=0.017,
    calf_radius=0.013,
    foot_radius=0.022,
    body=(0.80, 0.81, 0.82),
    dark=(0.13, 0.13, 0.14),
    accent=(0.85, 0.90, 0.95),
)

GO2 = QuadrupedDescription(
    name="go2",
    trunk=trunk_with(_LEG, _TRUNK),
    legs=four_legs(_LEG),
    foot_radius=0.022,
    stand_height=0.28,
    looks=look_shapes(_OUTLINE),
    solids=solid_shapes(_OUTLINE),
    source=f"Unitree's go2_description (unitree_ros): {SOURCE}; damping and friction as Go1's; "
    "the foot a ball as large as its mesh",
)
"""Rigid-body figures and shapes of Go2."""
