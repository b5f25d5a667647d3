"""Leaps drawn at random, as the published planner draws them."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.kinodynamic._leap import (
    close_leap,
    fly,
    leap_problem,
    peak_force,
    push,
    reverse_leap,
)
from cavalcade.kinodynamic._leap_aimed import (
    LAND_ABOVE,
    LONGEST,
    REACH_LEFT,
    SHORTEST,
    reach_height,
)
from cavalcade.kinodynamic.parameters import (
    BRAKE,
    FLIGHT,
    FORCE,
    KIND,
    LAND,
    LEAP,
    OK,
    SIZE,
    START,
    TIME,
)
from cavalcade.kinodynamic.random import between, uniform
from cavalcade.lattice.surface import surface

_REFINEMENTS = 10
_LONGEST_FLIGHT = 1.0


@njit(cache=True)
def random_leap(ground, body, discs, rng, state, tree, leap, scratch):
    """Draw a leap from a state (tree 1: that ends in it); whether it is valid in forward time.

    The counter-movement sets the vertical speed to 1-2 m/s below that of the smoothed ground.

    Args:
        state: `(6,)` of the node.
        leap: Written, in forward time.
    """
    own = leap if tree == 0 else np.empty(SIZE)
    own[KIND] = LEAP
    for k in range(6):
        own[START + k] = state[k]
    if tree == 1:
        for k in range(3, 6):
            own[START + k] = -state[k]
    _, along_x, along_y = surface(ground, state[0], state[1])
    tangent = along_x * own[START + 3] + along_y * own[START + 4]
    own[START + 5] = tangent - between(rng, 1.0, 2.0)
    span = between(rng, SHORTEST, LONGEST)
    begin = own[START : START + 6]
    now = scratch[:6]

    share, angle = uniform(rng), between(rng, 0.0, 2.0 * math.pi)
    if not _stance(ground, body, begin, span, share, angle, True, own, FORCE, TIME, now):
        return False
    push(begin, own[FORCE : FORCE + 3], own[TIME], own[TIME], now)
    flight = _flight_time(ground, body, now, scratch[6:])
    if not flight > 0.0:
        return False
    own[FLIGHT] = flight
    fly(now, flight, now)
    share, angle = uniform(rng), between(rng, 0.0, 2.0 * math.pi)
    begin = scratch[6:]
    for k in range(6):
        begin[k] = now[k]
    if not _stance(ground, body, begin, span, share, angle, False, own, BRAKE, LAND, now):
        return False
    close_leap(own)
    if tree == 1:
        reverse_leap(own, leap)
    return leap_problem(ground, body, discs, leap, scratch) == OK


@njit(cache=True)
def _stance(ground, body, begin, span, share, angle, first, leap, force, time, end):
    """Draw forces until they are within limits: stretched if too strong, quicker if too weak."""
    nominal = 2.0
    for _ in range(_REFINEMENTS):
        side = share * body.mu * nominal
        leap[force], leap[force + 1] = side * math.cos(angle), side * math.sin(angle)
        leap[force + 2] = 1.0
        push(begin, leap[force : force + 3], span, span, end)
        speed = math.hypot(end[3], end[4])
        wanted = surface(ground, end[0], end[1])[0] + body.h_nom
        if first:
            wanted = surface(ground, end[0], end[1])[0] + body.h_max - REACH_LEFT
            if speed > 1e-3 and not ground.flat:
                wanted = (
                    reach_height(ground, body, end[0], end[1], end[3] / speed, end[4] / speed, True)
                    - REACH_LEFT
                )
        fz = peak_force(wanted - begin[2], begin[5], span)
        leap[force + 2], leap[time] = fz, span
        if fz < 1.0:
            span *= 0.9
        elif math.hypot(side, fz) > body.grf_max:
            span *= 1.1
        elif side > body.mu * fz:
            share *= 0.9 * body.mu * fz / side
        else:
            return True
    return False


@njit(cache=True)
def _flight_time(ground, body, state, scratch):
    """Until the last time that a flight comes down to the landing's clearance, s; nan if never."""
    last, above = math.nan, False
    steps = int(_LONGEST_FLIGHT / body.dt)
    for k in range(steps + 1):
        t = k * body.dt
        fly(state, t, scratch)
        clearance = scratch[2] - surface(ground, scratch[0], scratch[1])[0]
        if clearance > body.h_nom + LAND_ABOVE:
            above = True
        elif above:
            low, high = t - body.dt, t
            for _ in range(20):
                mid = 0.5 * (low + high)
                fly(state, mid, scratch)
                height = surface(ground, scratch[0], scratch[1])[0]
                if scratch[2] - height > body.h_nom + LAND_ABOVE:
                    low = mid
                else:
                    high = mid
            last, above = low, False
    return last
