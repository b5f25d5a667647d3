"""Leaps sampled for the gap or the step that is in the way.

All along one straight line: where the body may still push off, where it may land, and the forces
that bring it from one to the other. Places on the line are in m from its origin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cavalcade.geometry import GRAVITY
from cavalcade.geometry.trajectory import LANDING, TAKE_OFF, WALK
from cavalcade.kernels import subroutine
from cavalcade.kinodynamic._leap import close_leap, leap_problem
from cavalcade.kinodynamic._validity import carried
from cavalcade.kinodynamic.parameters import (
    BRAKE,
    END,
    FLIGHT,
    FORCE,
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
"""Between places that are tried, m."""

_FARTHEST = 1.6
"""Longest flight that is looked for, m."""

_SLOWEST = 0.3
"""Least horizontal speed at both ends of a leap, m/s."""

_SHORTEST_FLIGHT = 0.3
"""A shorter flight is lengthened to this, m."""

_LOW = 12
"""So many of the first tries are low and fast, which makes the path short."""


class Line(NamedTuple):
    """A straight line seen from above: its origin, m, and the direction in which a body travels."""

    x: float
    y: float
    cos: float
    sin: float


class Barrier(NamedTuple):
    """What a straight walk cannot cross, as places on a line; nan where there is none.

    Attributes:
        walk: The last place up to which the body walks.
        take_off: The last one to push off from.
        landing: The first one to land on.
    """

    walk: float
    take_off: float
    landing: float


class LeapSample(NamedTuple):
    """What is free to choose about a leap over a barrier.

    Attributes:
        speed: Horizontal, in flight, m/s.
        gain, lose: Shares of the friction cone used to gain speed before it and to lose it after.
        push, brake: Where both stances' durations are between the shortest and the longest one.
        height: Clearance at which the flight ends, m.
        start, end: Where the flight begins and ends, m.
    """

    speed: float
    gain: float
    lose: float
    push: float
    brake: float
    height: float
    start: float
    end: float


@subroutine
def find_barrier(space, line, at, backwards):
    """The barrier around the place `at` where a walk along a line fails (`backwards`: one back)."""
    sign = -1.0 if backwards else 1.0
    near_phase, far_phase = (LANDING, TAKE_OFF) if backwards else (TAKE_OFF, LANDING)
    near = far = math.nan
    s = at
    # On the near side, places are left while they are good; on the far side, one is searched.
    stop = s + sign * _FARTHEST
    while sign * (stop - s) > 0.0 and _stands(space, line, s, near_phase):
        near = s
        s += sign * _STEP
    stop = s + sign * _FARTHEST
    while sign * (stop - s) > 0.0:
        if _stands_during(space, line, s, far_phase):
            far = s
            break
        s += sign * _STEP
    take_off, landing = (far, near) if backwards else (near, far)
    # Before the take-off, the last place where all four legs stand.
    s = min(take_off, at)
    stop = s - _FARTHEST
    while s > stop:
        if _stands(space, line, s, WALK):
            return Barrier(s, take_off, landing)
        s -= 0.5 * _STEP
    return Barrier(math.nan, take_off, landing)


@subroutine
def _stands(space, line, s, phase):
    """Whether the ground carries the body at a place on a line, at nominal height."""
    x, y = line.x + s * line.cos, line.y + s * line.sin
    z = surface(space.ground, x, y)[0] + space.body.h_nom
    return carried(space, x, y, z, line.cos, line.sin, phase)


@subroutine
def _stands_during(space, line, s, phase):
    """Whether it does there and where the stance before or after leads."""
    step = -0.1 if phase == TAKE_OFF else 0.1
    there = _stands(space, line, s, phase)
    there = there and _stands(space, line, s + step, phase)
    return there and _stands(space, line, s + 2.0 * step, phase)


@subroutine
def reach_height(space, x, y, cos, sin, rear_only):
    """The highest place of the body's centre from which the hips' legs reach the ground, m."""
    ground, body = space.ground, space.body
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


@subroutine
def _stance_span(body, change, stroke, share, part):
    """Duration of a stance that changes the vertical speed by `change` m/s; nan if none can.

    Args:
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


@subroutine
def shape_leap(space, line, sample, leap):
    """Lay a sampled leap along a line out in `leap`; whether there is one within all forces."""
    ground, body, cos, sin = space.ground, space.body, line.cos, line.sin
    speed, gain, lose = sample.speed, sample.gain, sample.lose

    # The flight's ends: as high as the rear legs still reach, and as the sample says.
    flight = (sample.end - sample.start) / speed
    tx, ty = line.x + sample.start * cos, line.y + sample.start * sin
    lx, ly = line.x + sample.end * cos, line.y + sample.end * sin
    floor = body.h_min + body.belly + 0.01
    if ground.flat:
        zt, zl = body.h_max - REACH_LEFT, sample.height
    else:
        zt = reach_height(space, tx, ty, cos, sin, True) - REACH_LEFT
        zl = surface(ground, lx, ly)[0] + sample.height
        zl = min(zl, reach_height(space, lx, ly, cos, sin, False) - 0.005)
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
        stroke = 2.0 * (zt - height - floor) / total
        span = _stance_span(body, up - tangent, stroke, gain, sample.push)
        if not span > 0.0:
            return False
        fz = 1.5 * (1.0 + (up - tangent) / (GRAVITY * span))
        fh = gain * body.mu * fz
        v = speed - 2.0 / 3.0 * GRAVITY * fh * span
        if v < _SLOWEST:
            return False
        length = v * span + GRAVITY * fh * span * span / 3.0
        px, py = tx - length * cos, ty - length * sin
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
        stroke = 2.0 * (height + floor - zl) / total
        span = _stance_span(body, tangent - down, stroke, lose, sample.brake)
        if not span > 0.0:
            return False
        fz = 1.5 * (1.0 + (tangent - down) / (GRAVITY * span))
        fh = lose * body.mu * fz
        v = speed - 2.0 / 3.0 * GRAVITY * fh * span
        if v < _SLOWEST:
            return False
        length = speed * span - GRAVITY * fh * span * span / 3.0
        height, along_x, along_y = surface(ground, lx + length * cos, ly + length * sin)
        tangent = v * (along_x * cos + along_y * sin)
    fz = 1.5 * (1.0 + (tangent - down) / (GRAVITY * span))
    leap[LAND] = span
    leap[BRAKE], leap[BRAKE + 1], leap[BRAKE + 2] = -fh * cos, -fh * sin, fz
    close_leap(leap)
    return (
        leap[END + 2] - height >= floor - 0.01 and pz - surface(ground, px, py)[0] >= floor - 0.01
    )


@subroutine
def leap_over(space, line, barrier, attempt, rng, leap, scratch):
    """Sample a leap `(SIZE,)` over a barrier after so many attempts; whether it is valid."""
    body = space.body
    fastest = 0.98 * body.v_max
    before, after = 0.01, 0.01
    if attempt < _LOW:
        speed = fastest * (1.0 - 0.17 * (attempt // 3))
        gain = lose = 0.9 - 0.2 * (attempt // 3)
        push = brake = 0.0
        height = body.h_nom + LAND_ABOVE * (-0.4 + 0.7 * (attempt % 3))
    else:
        speed = between(rng, 0.4 * fastest, fastest)
        gain, lose = between(rng, 0.0, 0.95), between(rng, 0.0, 0.95)
        push, brake = uniform(rng) ** 2, uniform(rng) ** 2
        height = body.h_nom + between(rng, -0.06, LAND_ABOVE)
        before, after = 0.2 * uniform(rng) ** 2, 0.2 * uniform(rng) ** 2
    start, end = barrier.take_off - before, barrier.landing + after
    short = _SHORTEST_FLIGHT - (end - start)
    if short > 0.0:
        start, end = start - 0.5 * short, end + 0.5 * short
    for _ in range(4):
        sample = LeapSample(speed, gain, lose, push, brake, height, start, end)
        if not shape_leap(space, line, sample, leap):
            return False
        # The stance before the flight begins where the body still walks, else all starts earlier.
        begin = (leap[START] - line.x) * line.cos + (leap[START + 1] - line.y) * line.sin
        if begin <= barrier.walk:
            return leap_problem(space, leap, scratch) == OK
        start -= begin - barrier.walk + 0.002
    return False
