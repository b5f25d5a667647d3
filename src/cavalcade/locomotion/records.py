"""What the compiled controller works on: one row per robot, as structured arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Row = NDArray[np.void]
"""Rows of the arrays below, or one of them `()`."""

STEPS = 10
"""Steps of the predictive control's horizon."""

CHANGES = 30
"""Of the set of held limits for every foot, at most; see `solve_mpc`."""

LYING, RISING, STANDING, TROTTING, LEAPING, SINKING, FALLEN = range(7)
"""What a robot is doing."""

ROBOT = np.dtype(
    [
        ("mass", np.float64),  # kg
        ("centre", np.float64, (3,)),  # of mass, standing, trunk frame, m
        ("inertia", np.float64, (3, 3)),  # of the whole robot about it, standing, kg m²
        ("trunk_mass", np.float64),  # without the legs, kg
        ("trunk_centre", np.float64, (3,)),  # of it, trunk frame, m
        ("hip", np.float64, (4, 3)),  # hip joints, trunk frame, m
        ("side", np.float64, (4,)),  # from hip joint to thigh joint along y, m
        ("thigh", np.float64),  # m
        ("calf", np.float64),  # to the foot's centre, m
        ("foot_radius", np.float64),  # m
        ("link_mass", np.float64, (4, 3)),  # hip, thigh, calf with foot, kg
        ("link_centre", np.float64, (4, 3, 3)),  # in the links' frames, m
        ("lowest", np.float64, (12,)),  # joint angles, rad
        ("highest", np.float64, (12,)),
        ("torque", np.float64, (12,)),  # largest, N m
        ("damping", np.float64, (12,)),  # N m s
        ("friction", np.float64, (12,)),  # N m
    ],
    align=True,
)
"""A robot's figures."""

GAIT = np.dtype(
    [
        ("period", np.float64),  # of a whole cycle, s
        ("duty", np.float64),  # share of it that a foot stands
        ("offset", np.float64, (4,)),  # of each leg in the cycle
        ("height", np.float64),  # of the trunk over the ground, m
        ("clearance", np.float64),  # of a swinging foot, m
        ("capture", np.float64),  # foothold's gain on errors of the velocity, s
        ("acceleration", np.float64),  # m/s²
        ("turning", np.float64),  # rad/s²
        ("silence", np.float64),  # without commands for so long it stops, s
        ("weights", np.float64, (12,)),
        ("force_weight", np.float64),
        ("mu", np.float64),
        ("max_force", np.float64),  # N
        ("step", np.float64),  # of the horizon, s
        ("interval", np.float64),  # between solutions, s
        ("stiffness", np.float64),  # of swinging legs' joints, N m/rad
        ("joint_damping", np.float64),  # N m s/rad
        ("touch", np.float64),  # force from which a foot stands, N
        ("leash", np.float64),  # the reference is at most so far from the robot, m
        ("turn_leash", np.float64),  # rad
    ],
    align=True,
)
"""How robots walk."""

STATE = np.dtype(
    [
        ("time", np.float64),  # s
        ("mode", np.int64),
        ("began", np.float64),  # the mode or the trot's clock, s
        ("wanted", np.float64, (3,)),  # commanded velocity, body frame
        ("heard", np.float64),  # when it was commanded, s
        ("velocity", np.float64, (3,)),  # followed now, body frame, m/s, rad/s
        ("idle", np.float64),  # since when it has wanted to stand, s
        ("place", np.float64, (2,)),  # reference of the centre of mass, m
        ("yaw", np.float64),  # reference, unwrapped, rad
        ("ground", np.float64),  # height of the ground below, m
        ("slope", np.float64, (2,)),  # along world x and y
        ("swinging", np.int64, (4,)),  # by the gait's clock
        ("contact", np.int64, (4,)),  # stands and carries
        ("stood", np.float64, (4, 3)),  # where the foot stood last, world, m
        ("lifted", np.float64, (4, 3)),  # where its swing began
        ("landing", np.float64, (4, 3)),  # where its swing is to end
        ("apex", np.float64, (4,)),  # highest point of the swing, m
        ("late", np.float64, (4,)),  # since when it has missed the ground, s
        ("forces", np.float64, (4, 3)),  # of the ground on the feet, world, N
        ("solved", np.float64),  # when forces were computed last, s
        ("fold", np.float64, (12,)),  # joints at the begin of rising or sinking
    ],
    align=True,
)
"""What a robot is doing, and what its controller remembers."""
