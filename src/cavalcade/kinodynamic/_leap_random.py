"""Leaps drawn at random, as the published planner draws them."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import subroutine
from cavalcade.kernels.copying import copy_to
from cavalcade.kinodynamic._leap import (
    close_leap,
    flight_state,
    leap_problem,
    peak_force,
    reverse_leap,
    stance_state,
)
from cavalcade.kinodynamic._leap_over_barrier import (
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
"""How often the forces of a stance are corrected."""

_LONGEST_FLIGHT = 1.0
"""Duration, s."""


@subroutine
def random_leap(space, state, backwards, rng, leap, scratch):
    """Sample a leap from a state (`backwards`: to it); whether it is valid in forward time.

    The counter-movement sets the vertical speed to 1-2 m/s below that of the smoothed ground. A
    leap that ends in the state is sampled in reversed time; `leap` `(SIZE,)` is in forward time.
    """
    own = np.empty(SIZE) if backwards else leap
    own[KIND] = LEAP
    copy_to(own[START:], state)
    if backwards:
        for k in range(3, 6):
            own[START + k] = -state[k]
    _, along_x, along_y = surface(space.ground, state[0], state[1])
    tangent = along_x * own[START + 3] + along_y * own[START + 4]
    own[START + 5] = tangent - between(rng, 1.0, 2.0)
    span = between(rng, SHORTEST, LONGEST)
    begin, now = own[START : START + 6], scratch[:6]

    # The take-off, the flight, and the landing from where the flight comes down.
    if not _sample_stance(space, begin, span, True, rng, own, now):
        return False
    stance_state(begin, own[FORCE : FORCE + 3], own[TIME], own[TIME], now)
    flight = _flight_time(space, now, scratch[6:])
    if not flight > 0.0:
        return False
    own[FLIGHT] = flight
    flight_state(now, flight, now)
    begin = scratch[6:]
    copy_to(begin, now)
    if not _sample_stance(space, begin, span, False, rng, own, now):
        return False
    close_leap(own)
    if backwards:
        reverse_leap(own, leap)
    return leap_problem(space, leap, scratch) == OK


@subroutine
def _sample_stance(space, begin, span, first, rng, leap, end):
    """Sample the horizontal force of a stance and correct it until all forces are within limits.

    The stance, of `span` s at first, is stretched if the legs push too hard, and quicker if they
    push too little. The take-off, `first`, ends as high as the rear legs reach; the landing ends
    at nominal height. Force and duration are written to `leap`, the last state to `end`.
    """
    ground, body = space.ground, space.body
    share, angle = uniform(rng), between(rng, 0.0, 2.0 * math.pi)
    force, time = (FORCE, TIME) if first else (BRAKE, LAND)
    nominal = 2.0
    for _ in range(_REFINEMENTS):
        # Where the horizontal force leads, and the height wanted there.
        side = share * body.mu * nominal
        leap[force], leap[force + 1] = side * math.cos(angle), side * math.sin(angle)
        leap[force + 2] = 1.0
        stance_state(begin, leap[force : force + 3], span, span, end)
        speed = math.hypot(end[3], end[4])
        wanted = surface(ground, end[0], end[1])[0] + body.h_nom
        if first:
            wanted = surface(ground, end[0], end[1])[0] + body.h_max - REACH_LEFT
            if speed > 1e-3 and not ground.flat:
                cos, sin = end[3] / speed, end[4] / speed
                wanted = reach_height(space, end[0], end[1], cos, sin, True) - REACH_LEFT
        # The vertical force that leads there.
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


@subroutine
def _flight_time(space, state, scratch):
    """Until the last time that a flight comes down to the landing's clearance, s; nan if never."""
    ground, dt = space.ground, space.body.dt
    limit = space.body.h_nom + LAND_ABOVE
    last, above = math.nan, False
    steps = int(_LONGEST_FLIGHT / dt)
    for k in range(steps + 1):
        t = k * dt
        flight_state(state, t, scratch)
        clearance = scratch[2] - surface(ground, scratch[0], scratch[1])[0]
        if clearance > limit:
            above = True
        elif above:
            # It comes down within this dt: bisect.
            low, high = t - dt, t
            for _ in range(20):
                mid = 0.5 * (low + high)
                flight_state(state, mid, scratch)
                if scratch[2] - surface(ground, scratch[0], scratch[1])[0] > limit:
                    low = mid
                else:
                    high = mid
            last, above = low, False
    return last
