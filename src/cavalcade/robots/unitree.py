"""Unitree's quadrupeds Go1 and Go2: figures of the maker's URDFs; one motor for all joints."""

from __future__ import annotations

from dataclasses import replace

from cavalcade.robots.building import LegParts, Outline, described
from cavalcade.robots.description import Inertial, JointDescription, Vector

TORQUE, SPEED = 23.7, 30.1
"""Largest torque and speed of the motor behind its gear (GO-M8010-6): N m, rad/s."""

GEAR = 6.33
"""Of that gear, from its data sheet."""

ROTOR_MASS, ROTOR_AXIAL, ROTOR_ACROSS = 0.089, 0.000111842, 5.9647e-05
"""Of the motor's rotor: kg, kg m² about its axis and across it."""

_X, _Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)

_SOURCE = (
    "masses, offsets, ranges, torques, speeds and rotors from the URDF; gear 6.33 from the data "
    "sheet of the motor GO-M8010-6, times what the knee's linkage adds; torque taken to fall in a "
    "straight line from the largest torque at rest to none at the largest speed"
)


def _joint(
    offset: Vector,
    axis: Vector,
    lower: float,
    upper: float,
    torque: float = TORQUE,
    speed: float = SPEED,
) -> JointDescription:
    """A joint with this motor; a larger torque than the motor's means a linkage in between.

    Damping and dry friction are those of Go1's URDF; no other description publishes any. The
    rotor turns faster than the joint, so the joint feels its inertia times the gear squared. Its
    inertia at rest in the link that carries it is part of that link's.
    """
    return JointDescription(
        offset,
        axis,
        lower,
        upper,
        torque,
        speed,
        damping=0.01,
        friction=0.2,
        armature=ROTOR_AXIAL * (GEAR * torque / TORQUE) ** 2,
        stall_torque=torque,
        no_load_speed=speed,
    )


def _rotor(place: Vector, axis: Vector) -> Inertial:
    """The motor's rotor at a place of the link that carries it."""
    xx, yy = (ROTOR_AXIAL, ROTOR_ACROSS) if axis == _X else (ROTOR_ACROSS, ROTOR_AXIAL)
    return Inertial(ROTOR_MASS, place, (xx, yy, ROTOR_ACROSS, 0.0, 0.0, 0.0))


_ROTORS = (
    _rotor((0.11215, 0.04675, 0.0), _X),
    _rotor((0.0, -0.00015, 0.0), _Y),
    _rotor((0.0, -0.03235, 0.0), _Y),
)

_GO1_LEG = LegParts(
    joints=(
        _joint((0.1881, 0.04675, 0.0), _X, -0.863, 0.863),
        _joint((0.0, 0.08, 0.0), _Y, -0.686, 4.501),
        _joint((0.0, 0.0, -0.213), _Y, -2.818, -0.888, torque=35.55, speed=20.06),
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
    rotors=_ROTORS,
    foot=Inertial(0.06, (0.0, 0.0, 0.0), (9.6e-06, 9.6e-06, 9.6e-06, 0.0, 0.0, 0.0)),
    foot_place=(0.0, 0.0, -0.213),
    mirrored_calf=False,
)  # fmt: skip

# The trunk and its IMU. The cameras' and other sensors' placeholders, 0.01 g each, are left out.
_GO1_TRUNK = (
    Inertial(
        5.204,
        (0.0223, 0.002, -0.0005),
        (0.0168128557, 0.063009565, 0.0716547275, -0.0002296769, -0.0002945293, -4.18731e-05),
    ),
    Inertial(0.001, (-0.01592, -0.06659, -0.00617), (0.0001, 0.0001, 0.0001, 0.0, 0.0, 0.0)),
)

_GO1_OUTLINE = Outline(
    trunk=(0.1881, 0.0935, 0.057),
    head=(0.05, 0.044, 0.042),
    head_place=(0.23, 0.0, 0.008),
    hip_radius=0.046,
    hip_half=0.045,
    thigh_motor=(0.045, 0.03),
    thigh_radius=0.017,
    calf_radius=0.012,
    foot_radius=0.02,
    body=(0.70, 0.75, 0.80),
    dark=(0.16, 0.16, 0.18),
    accent=(0.05, 0.35, 0.65),
)

GO1_BODY = described(
    "go1",
    _GO1_LEG,
    _GO1_TRUNK,
    _GO1_OUTLINE,
    stand_height=0.28,
    source=f"Unitree's go1_description (unitree_ros): {_SOURCE}",
)
"""Rigid-body figures and shapes of Go1."""

_GO2_LEG = LegParts(
    joints=(
        _joint((0.1934, 0.0465, 0.0), _X, -1.0472, 1.0472),
        _joint((0.0, 0.0955, 0.0), _Y, -1.5708, 3.4907),
        _joint((0.0, 0.0, -0.213), _Y, -2.7227, -0.83776, torque=45.43, speed=15.70),
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
    rotors=_ROTORS,
    foot=replace(_GO1_LEG.foot, mass=0.04),
    foot_place=(0.0, 0.0, -0.213),
    rear_thigh=(-0.5236, 4.5379),
)

_GO2_TRUNK = (
    Inertial(
        6.921,
        (0.021112, 0.0, -0.005366),
        (0.02448, 0.098077, 0.107, 0.00012166, 0.0014849, -3.12e-05),
    ),
)

_GO2_OUTLINE = replace(
    _GO1_OUTLINE,
    trunk=(0.1934, 0.0935, 0.06),
    head=(0.06, 0.045, 0.05),
    head_place=(0.25, 0.0, 0.005),
    thigh_motor=(0.046, 0.03),
    calf_radius=0.013,
    foot_radius=0.022,
    body=(0.80, 0.81, 0.82),
    dark=(0.13, 0.13, 0.14),
    accent=(0.85, 0.90, 0.95),
)

GO2_BODY = described(
    "go2",
    _GO2_LEG,
    _GO2_TRUNK,
    _GO2_OUTLINE,
    stand_height=0.28,
    source=f"Unitree's go2_description (unitree_ros): {_SOURCE}; damping and friction as Go1's; "
    "the foot a ball as large as its mesh",
)
"""Rigid-body figures and shapes of Go2."""
