"""Turning on the spot."""

from __future__ import annotations

import math

from numba import njit

from cavalcade.geometry.trajectory import WALK
from cavalcade.kinodynamic._validity import carried, solid_free, solid_slack

_STEP = 0.1
"""Between looks, rad."""


@njit(cache=True)
def wrapped(angle):
    """The same angle in (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


@njit(cache=True)
def turn_on_spot(ground, body, discs, x, y, z, yaw, wanted):
    """Angle to turn by from one yaw to another, the short way if there is room; nan without room.

    The states at both ends are taken to be valid.
    """
    short = wrapped(wanted - yaw)
    if abs(short) < 1e-9:
        return 0.0
    if ground.flat and solid_slack(ground, body, discs, x, y) > 0.0:
        return short
    if _free(ground, body, discs, x, y, z, yaw, short):
        return short
    other = short - math.copysign(2.0 * math.pi, short)
    if _free(ground, body, discs, x, y, z, yaw, other):
        return other
    return math.nan


@njit(cache=True)
def _free(ground, body, discs, x, y, z, yaw, turn):
    count = int(math.ceil(abs(turn) / _STEP))
    for k in range(1, count):
        cos, sin = math.cos(yaw + turn * k / count), math.sin(yaw + turn * k / count)
        if not solid_free(ground, body, discs, x, y, cos, sin):
            return False
        if not ground.flat and not carried(ground, body, x, y, z, cos, sin, WALK):
            return False
    return True
