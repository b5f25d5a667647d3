"""LEAP: a push of the legs, a flight and a landing.

Force in stance, in body weights: F(t) = 4 f t (T - t) / T² with the peak f; flight is ballistic.
Primitives are laid out as `parameters` says.
"""

from __future__ import annotations

import math

from cavalcade.geometry import GRAVITY
from cavalcade.geometry.trajectory import FLIGHT as FLYING
from cavalcade.geometry.trajectory import LANDING, TAKE_OFF
from cavalcade.kernels import subroutine
from cavalcade.kernels.copying import copy_to
from cavalcade.kinodynamic._validity import state_problem
from cavalcade.kinodynamic.parameters import (
    BRAKE,
    END,
    FLIGHT,
    FORCE,
    LAND,
    MOTION,
    OK,
    START,
    TIME,
)


@subroutine
def stance_state(state, force, span, t, out):
    """State after `t` s of a stance of `span` s with the peak force `(3,)`, written to `out`.

    `out` may be `state`.
    """
    rate = GRAVITY * (2.0 * t * t / span - 4.0 * t * t * t / (3.0 * span * span))
    shift = GRAVITY * t * t * t * (2.0 / (3.0 * span) - t / (3.0 * span * span))
    for k in range(3):
        out[k] = state[k] + state[k + 3] * t + force[k] * shift
    for k in range(3):
        out[k + 3] = state[k + 3] + force[k] * rate
    out[2] -= 0.5 * GRAVITY * t * t
    out[5] -= GRAVITY * t


@subroutine
def flight_state(state, t, out):
    """State after `t` s of flight, written to `out`, which may be `state`."""
    for k in range(3):
        out[k] = state[k] + state[k + 3] * t
    for k in range(3):
        out[k + 3] = state[k + 3]
    out[2] -= 0.5 * GRAVITY * t * t
    out[5] -= GRAVITY * t


@subroutine
def peak_force(rise, start_speed, span):
    """Vertical peak force, body weights, that lifts a body by `rise` m in a stance.

    f = -(3 / (g T²)) (-rise + T (6 dz0 - 3 g T) / 6)
    """
    return 3.0 / (GRAVITY * span * span) * (rise - span * start_speed) + 1.5


@subroutine
def leap_duration(leap):
    """Duration of a leap's three phases together, s."""
    return leap[TIME] + leap[FLIGHT] + leap[LAND]


@subroutine
def leap_state(leap, t, out):
    """State `(6,)` at time `t` after the start of the leap, written to `out`; returns the phase."""
    if t < leap[TIME]:
        stance_state(leap[START : START + 6], leap[FORCE : FORCE + 3], leap[TIME], t, out)
        return TAKE_OFF
    stance_state(leap[START : START + 6], leap[FORCE : FORCE + 3], leap[TIME], leap[TIME], out)
    t -= leap[TIME]
    if t < leap[FLIGHT]:
        flight_state(out, t, out)
        return FLYING
    flight_state(out, leap[FLIGHT], out)
    stance_state(out, leap[BRAKE : BRAKE + 3], leap[LAND], min(t - leap[FLIGHT], leap[LAND]), out)
    return LANDING


@subroutine
def close_leap(leap):
    """Write the state in which a leap ends to its place."""
    leap_state(leap, leap_duration(leap), leap[END : END + 6])


@subroutine
def reverse_leap(leap, out):
    """The same leap in reversed time, to another array: ends exchanged, velocities negated."""
    copy_to(out, leap)
    for k in range(3):
        out[START + k], out[END + k] = leap[END + k], leap[START + k]
        out[START + 3 + k], out[END + 3 + k] = -leap[END + 3 + k], -leap[START + 3 + k]
        out[FORCE + k], out[BRAKE + k] = leap[BRAKE + k], leap[FORCE + k]
    out[TIME], out[LAND] = leap[LAND], leap[TIME]


@subroutine
def leap_forces_allowed(body, leap):
    """Whether both stances keep to the friction cone, the largest force and 1 <= f_z."""
    for first in (FORCE, BRAKE):
        fx, fy, fz = leap[first], leap[first + 1], leap[first + 2]
        side = fx * fx + fy * fy
        if fz < 1.0 or side > (body.mu * fz) ** 2 * (1.0 + 1e-9):
            return False
        if side + fz * fz > body.grf_max * body.grf_max * (1.0 + 1e-9):
            return False
    return True


@subroutine
def leap_problem(space, leap, scratch):
    """What is wrong with a leap in forward time: `OK`, `SOLID`, `GROUND` or `MOTION`.

    Its states are checked every dt and at both ends of all phases; `scratch (12,)` is written.
    """
    if not leap_forces_allowed(space.body, leap):
        return MOTION
    begin, state = scratch[:6], scratch[6:]
    copy_to(begin, leap[START : START + 6])
    phase = TAKE_OFF
    span = leap[TIME]
    for stage in range(3):
        if stage == 1:
            phase, span = FLYING, leap[FLIGHT]
        elif stage == 2:
            phase, span = LANDING, leap[LAND]
        count = max(int(math.ceil(span / space.body.dt - 1e-9)), 1)
        for k in range(count + 1):
            t = span * k / count
            if stage == 0:
                stance_state(begin, leap[FORCE : FORCE + 3], span, t, state)
            elif stage == 1:
                flight_state(begin, t, state)
            else:
                stance_state(begin, leap[BRAKE : BRAKE + 3], span, t, state)
            vx, vy = state[3], state[4]
            speed = math.sqrt(vx * vx + vy * vy)
            if speed < 0.05:
                return MOTION  # which way it looks would be arbitrary
            found = state_problem(space, state, vx / speed, vy / speed, phase)
            if found != OK:
                return found
        copy_to(begin, state)
    return OK
