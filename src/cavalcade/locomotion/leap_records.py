"""What the compiled controller knows of a leap: one row per robot, as a structured array."""

from __future__ import annotations

import numpy as np

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
