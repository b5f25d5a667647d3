"""What the compiled controller works on: structured arrays of one row per robot, and tuples.

World frame with z up, trunk frame with x ahead, y left; SI. Legs are FL, FR, RL, RR; joints hip,
thigh, calf.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.lattice.ground import Ground, read_only
from cavalcade.locomotion.settings import GAIT

Row = NDArray[np.void]
"""Rows of the arrays below, or one of them `()`."""

STEPS = 10
"""Steps of the predictive control's horizon."""

CHANGES = 30
"""Of the solver's active set for every standing foot, at most: enough for the wildest problems."""

LYING, RISING, STANDING, TROTTING, LEAPING, SINKING, FALLEN = range(7)
"""Modes: what a robot is doing."""

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
"""Parameters of a robot's body and legs; `parameters.robot_parameters` makes them."""

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

BODY = np.dtype(
    [
        ("matrix", np.float64, (3, 3)),  # trunk to world
        ("angles", np.float64, (3,)),  # roll, pitch, yaw, rad
        ("trunk", np.float64, (3,)),  # origin of the trunk frame, m
        ("centre", np.float64, (3,)),  # of mass as if the robot stood, world, m
        ("velocity", np.float64, (3,)),  # of that, world, m/s
        ("spin", np.float64, (3,)),  # angular velocity, world, rad/s
        ("foot", np.float64, (4, 3)),  # feet's centres, world, m
        ("carried", np.float64, (4, 3)),  # feet's velocities if joints stood still, world, m/s
        ("jacobian", np.float64, (4, 3, 3)),  # of the feet by the joints, trunk frame
    ],
    align=True,
)
"""A body as measured now; `_kinematics.measure_body` fills it."""

CROUCH, PUSH, FLIGHT, LANDING = range(4)
"""Phases of a leap."""

LEAP = np.dtype(
    [
        ("phase", np.int64),
        ("began", np.float64),  # the phase, s
        ("lasts", np.float64, (4,)),  # each phase, s
        ("absorb", np.float64),  # the fall, from touch-down, s
        ("start", np.float64, (3,)),  # of the centre of mass when crouching begins, world, m
        ("squat", np.float64, (3,)),  # where the push begins
        ("lift", np.float64, (3,)),  # where it ends
        ("lift_velocity", np.float64, (3,)),  # m/s
        ("down", np.float64, (3,)),  # where the flight ends
        ("down_velocity", np.float64, (3,)),
        ("rest", np.float64, (3,)),  # where the landing ends
        ("yaws", np.float64, (2,)),  # before and after, unwrapped, rad
        ("pitches", np.float64, (3,)),  # at the ends of crouch, push and flight, rad
        ("foothold", np.float64, (4, 3)),  # where feet are to land, centres, world, m
        ("along", np.float64, (2,)),  # direction of the leap
        ("bound", np.float64),  # no foot lands at a smaller coordinate along it, m
        ("shift", np.float64, (2,)),  # footholds are moved so far to meet the body, m
        ("left", np.float64, (4, 3)),  # feet at lift-off, world, m
        ("tuck", np.float64),  # feet below the centre of mass in flight, m
        ("weights", np.float64, (12,)),
        ("land_weights", np.float64, (12,)),
        ("force_weight", np.float64),
        ("mu", np.float64),
        ("max_force", np.float64),  # N
        ("step", np.float64),  # of the horizon, s
        ("interval", np.float64),  # between solutions, s
        ("stiffness", np.float64),  # of flying legs' joints, N m/rad
        ("joint_damping", np.float64),  # N m s/rad
        ("touch", np.float64),  # force from which a foot stands, N
        ("failed", np.int64),
    ],
    align=True,
)
"""A leap that is under way, and the last one's outcome."""

TEAM = np.dtype(
    [("robot", ROBOT), ("gait", GAIT), ("state", STATE), ("leap", LEAP), ("body", BODY)],
    align=True,
)
"""A robot of a team: all that its controller knows, in one row.

Bodies are kept although every step overwrites them: a row of an array made in a kernel would be
freed while it is in use, as rows do not keep their array alive.
"""


class Measured(NamedTuple):
    """What is measured of one robot at one moment.

    Attributes:
        time: Now, s.
        qpos: `(19,)` position of the trunk (m), quaternion w, x, y, z, joint angles (rad).
        qvel: `(18,)` velocity of the trunk (world, m/s), its angular velocity (trunk frame,
            rad/s), joint rates (rad/s).
        feet: `(4,)` normal forces on the feet, N.
    """

    time: float
    qpos: Array
    qvel: Array
    feet: Array


class Footing(NamedTuple):
    """What feet stand on: the part of a `Ground` that matters to them, and where its grid lies.

    Attributes:
        cell, solid, flat, height, traversability: As of `Ground`.
        frame: `(3,)` pose x, y, yaw of the grid in the world, m and rad.
    """

    cell: float
    solid: NDArray[np.bool_]
    flat: bool
    height: Array
    traversability: Array
    frame: Array

    @classmethod
    def of(cls, ground: Ground, frame: Sequence[float]) -> Footing:
        """The footing of a ground; its arrays are of one type for all, so kernels compile once."""
        own = read_only(ground)
        pose = np.array(frame, dtype=float)
        return cls(own.cell, own.solid, own.flat, own.height, own.traversability, pose)


class Centroid(NamedTuple):
    """Centre of mass, its velocity and the mean angular velocity, each `(3,)` in the world."""

    centre: Array
    velocity: Array
    spin: Array


class FootTarget(NamedTuple):
    """Where a foot is to be and how fast to move, `(3,)` in the world, and its joints' gains.

    Attributes:
        place, velocity: m and m/s.
        stiffness, damping: Of the joints, N m/rad and N m s/rad.
    """

    place: Array
    velocity: Array
    stiffness: float
    damping: float
