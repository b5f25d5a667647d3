"""Leaps drawn for the gap or the step that is in the way.

All along one straight line: where the body may still push off, where it may land, and the forces
that bring it from one to the other.
"""

from __future__ import annotations

import math

from numba import njit

from cavalcade.geometry.trajectory import LANDING, TAKE_OFF, WALK
from cavalcade.kinodynamic._leap import close_leap, leap_problem
from cavalcade.kinodynamic._validity import carried
from cavalcade.kinodynamic.parameters import (
    BRAKE,
    END,
    FLIGHT,
    FORCE,
    GRAVITY,
    KIND,
    LAND,
    LEAP,
    OK,
    START,
    TIME,
)
from cavalcade.kinodynamic.random import between, uniform
from cavalcade.lattice.surface import bilinear, surface

SHORTEST, LONGEST = 0.12, 0.25
"""Durations of a stance before or after a flight, s."""

REACH_LEFT = 0.03
"""The take-off ends this far below the rear legs' reach, m."""

LAND_ABOVE = 0.05
"""Highest clearance at which a flight ends, above the nominal one, m."""

_STEP = 0.02
_FARTHEST = 1.6
_SLOWEST = 0.3
_LEAST_FLIGHT = 0.3
_LOW = 12


@njit(cache=True)
def find_barrier(ground, body, x, y, cos, sin, at, backwards):
    """The flight over what a straight walk cannot cross.

    Args:
        x, y: The line's origin, m.
        cos, sin: Its direction, in which the body travels.
        at: Where a walk along it fails, m from the origin; where it comes from the far side (if
            `backwards`), where that fails.

    Returns:
        The last place up to which the body walks, the last one to push off from and the first
        one to land on, m from the origin; nan where there is none within a flight.
    """
    take_off, landing = math.nan, math.nan
    s = at
    if backwards:
        for phase in (LANDING, TAKE_OFF):
            stop = s - _FARTHEST
            # Landing places are left while they are good, those to push off from are searched.
            while s > stop:
                if phase == LANDING:
                    if not _stands(ground, body, x, y, cos, sin, s, phase):
                        break
                    landing = s
                elif _way_stands(ground, body, x, y, cos, sin, s, phase):
                    take_off = s
                    break
                s -= _STEP
    else:
        for phase in (TAKE_OFF, LANDING):
            stop = s + _FARTHEST
            while s < stop:
                if phase == TAKE_OFF:
                    if not _stands(ground, body, x, y, cos, sin, s, phase):
                        break
                    take_off = s
                elif _way_stands(ground, body, x, y, cos, sin, s, phase):
                    landing = s
                    break
                s += _STEP
    s = min(take_off, at)
    stop = s - _FARTHEST
    while s > stop:
        if _stands(ground, body, x, y, cos, sin, s, WALK):
            return s, take_off, landing
        s -= 0.5 * _STEP
    return math.nan, take_off, landing


@njit(cache=True)
def _stands(ground, body, x, y, cos, sin, s, phase):
    x, y = x + s * cos, y + s * sin
    z = surface(ground, x, y)[0] + body.h_nom
    return carried(ground, body, x, y, z, cos, sin, phase)


@njit(cache=True)
def _way_stands(ground, body, x, y, cos, sin, s, phase):
    """Whether the legs stand there and on the way of a stance."""
    way = -0.1 if phase == TAKE_OFF else 0.1
    there = _stands(ground, body, x, y, cos, sin, s, phase)
    there = there and _stands(ground, body, x, y, cos, sin, s + way, phase)
    return there and _stands(ground, body, x, y, cos, sin, s + 2.0 * way, phase)


@njit(cache=True)
def reach_height(ground, body, x, y, cos, sin, rear_only):
    """The highest place of the body's centre from which the hips' legs reach the ground, m."""
    cell = ground.cell
    slope = cos * bilinear(ground.slope_x, cell, x, y) + sin * bilinear(ground.slope_y, cell, x, y)
    cp = 1.0 / math.sqrt(1.0 + slope * slope)
    along, rise = body.hip_x * cp, body.hip_x * slope * cp
    highest = math.inf
    for k in range(2 if rear_only else 4):
        e = -1.0 if k < 2 else 1.0
        f = 1.0 if k % 2 == 0 else -1.0
        px = x + e * along * cos - f * body.hip_y * sin
        py = y + e * along * sin + f * body.hip_y * cos
        highest = min(highest, body.h_max + bilinear(ground.height, cell, px, py) - e * rise)
    return highest


@njit(cache=True)
def _stance_span(body, change, stroke, share, part):
    """Duration of a stance that changes the vertical speed by `change` m/s; nan if none can.

    Args:
        change: m/s, positive.
        stroke: 2 x the room to move in over the sum of both vertical speeds, s.
        share: Of the friction cone that the horizontal force uses.
        part: Where between the shortest and the longest one, 0 to 1.
    """
    most = 0.98 * body.grf_max / math.sqrt(1.0 + (share * body.mu) ** 2)
    if most <= 1.5:
        return math.nan
    low = max(SHORTEST, change / (GRAVITY * (most / 1.5 - 1.0)))
    high = min(LONGEST, stroke)
    if low > high:
        return math.nan
    return low + part * (high - low)


@njit(cache=True)
def shape_leap(ground, body, x, y, cos, sin, take_off, landing, draw, leap):
    """Lay a straight leap out in `leap`; whether there is one within all forces.

    Args:
        x, y, cos, sin: The line.
        take_off, landing: Where on it the flight begins and ends, m.
        draw: `(6,)` horizontal speed in flight, m/s; shares of the friction cone used to gain
            speed before it and to lose speed after it; where between their shortest and longest
            both stances are (0 to 1); clearance at which the flight ends, m.
    """
    speed, gain, lose = draw[0], draw[1], draw[2]
    flight = (landing - take_off) / speed
    tx, ty = x + take_off * cos, y + take_off * sin
    lx, ly = x + landing * cos, y + landing * sin
    floor = body.h_min + body.belly + 0.01
    if ground.flat:
        zt, zl = body.h_max - REACH_LEFT, draw[5]
    else:
        zt = reach_height(ground, body, tx, ty, cos, sin, True) - REACH_LEFT
        zl = surface(ground, lx, ly)[0] + draw[5]
        zl = min(zl, reach_height(ground, body, lx, ly, cos, sin, False) - 0.005)
    up = (zl - zt) / flight + 0.5 * GRAVITY * flight
    down = up - GRAVITY * flight
    if up < 0.2:
        return False
    leap[KIND] = LEAP
    leap[FLIGHT] = flight

    # The take-off, backwards from its end: its start has the slope's vertical speed.
    height, along_x, along_y = surface(ground, tx, ty)
    tangent = speed * (along_x * cos + along_y * sin)
    px, py, pz, v = tx, ty, zt, speed
    for _ in range(3):
        total = max(up + tangent, 1e-3)
        span = _stance_span(body, up - tangent, 2.0 * (zt - height - floor) / total, gain, draw[3])
        if not span > 0.0:
            return False
        fz = 1.5 * (1.0 + (up - tangent) / (GRAVITY * span))
        fh = gain * body.mu * fz
        v = speed - 2.0 / 3.0 * GRAVITY * fh * span
        if v < _SLOWEST:
            return False
        way = v * span + GRAVITY * fh * span * span / 3.0
        px, py = tx - way * cos, ty - way * sin
        pz = zt - 0.5 * (tangent + up) * span
        height, along_x, along_y = surface(ground, px, py)
        tangent = v * (along_x * cos + along_y * sin)
    leap[TIME] = span
    leap[START], leap[START + 1], leap[START + 2] = px, py, pz
    leap[START + 3], leap[START + 4] = v * cos, v * sin
    leap[START + 5] = 2.0 * (zt - pz) / span - up
    fz = 1.5 * (1.0 + (up - leap[START + 5]) / (GRAVITY * span))
    leap[FORCE], leap[FORCE + 1], leap[FORCE + 2] = fh * cos, fh * sin, fz

    # The landing, forwards from its start: it ends with the slope's vertical speed.
    height, along_x, along_y = surface(ground, lx, ly)
    tangent = speed * (along_x * cos + along_y * sin)
    for _ in range(4):
        total = min(down + tangent, -1e-3)
        span = _stance_span(
            body, tangent - down, 2.0 * (height + floor - zl) / total, lose, draw[4]
        )
        if not span > 0.0:
            return False
        fz = 1.5 * (1.0 + (tangent - down) / (GRAVITY * span))
        fh = lose * body.mu * fz
        v = speed - 2.0 / 3.0 * GRAVITY * fh * span
        if v < _SLOWEST:
            return False
        way = speed * span - GRAVITY * fh * span * span / 3.0
        height, along_x, along_y = surface(ground, lx + way * cos, ly + way * sin)
        tangent = v * (along_x * cos + along_y * sin)
    fz = 1.5 * (1.0 + (tangent - down) / (GRAVITY * span))
    leap[LAND] = span
    leap[BRAKE], leap[BRAKE + 1], leap[BRAKE + 2] = -fh * cos, -fh * sin, fz
    close_leap(leap)
    return (
        leap[END + 2] - height >= floor - 0.01 and pz - surface(ground, px, py)[0] >= floor - 0.01
    )


@njit(cache=True)
def aimed_leap(
    ground, body, discs, line, walk, take_off, landing, attempt, rng, draw, leap, scratch
):
    """Draw a leap over a barrier; whether it is valid.

    Args:
        line: `(4,)` x, y, cosine, sine.
        walk, take_off, landing: As `find_barrier` gives them.
        attempt: How many draws there have been for this barrier. The first ones are low and fast,
            which makes the way short.
        rng: State of the random numbers.
        draw, scratch: `(6,)` and `(12,)`.
    """
    fastest = 0.98 * body.v_max
    before, after = 0.01, 0.01
    if attempt < _LOW:
        draw[0] = fastest * (1.0 - 0.17 * (attempt // 3))
        draw[1] = draw[2] = 0.9 - 0.2 * (attempt // 3)
        draw[3] = draw[4] = 0.0
        draw[5] = body.h_nom + LAND_ABOVE * (-0.4 + 0.7 * (attempt % 3))
    else:
        draw[0] = between(rng, 0.4 * fastest, fastest)
        draw[1], draw[2] = between(rng, 0.0, 0.95), between(rng, 0.0, 0.95)
        draw[3], draw[4] = uniform(rng) ** 2, uniform(rng) ** 2
        draw[5] = body.h_nom + between(rng, -0.06, LAND_ABOVE)
        before, after = 0.2 * uniform(rng) ** 2, 0.2 * uniform(rng) ** 2
    start, end = take_off - before, landing + after
    short = _LEAST_FLIGHT - (end - start)
    if short > 0.0:
        start, end = start - 0.5 * short, end + 0.5 * short
    for _ in range(4):
        if not shape_leap(ground, body, line[0], line[1], line[2], line[3], start, end, draw, leap):
            return False
        # The stance before it begins where the body still walks.
        begin = (leap[START] - line[0]) * line[2] + (leap[START + 1] - line[1]) * line[3]
        if begin <= walk:
            return leap_problem(ground, body, discs, leap, scratch) == OK
        start -= begin - walk + 0.002
    return False
