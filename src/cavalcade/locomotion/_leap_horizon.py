"""The problem of predictive control in a leap: reference, contacts and levers, compiled."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.geometry import GRAVITY
from cavalcade.kernels import subroutine
from cavalcade.locomotion._horizon import present_state
from cavalcade.locomotion._kinematics import wrapped
from cavalcade.locomotion.mpc import MpcProblem
from cavalcade.locomotion.records import CROUCH, FLIGHT, LANDING, PUSH, STEPS


@subroutine
def hermite(start, start_speed, end, end_speed, lasts, t):
    """Place and speed at `t` of the cubic with these values at 0 and `lasts`."""
    s = min(max(t / lasts, 0.0), 1.0)
    a, b = start_speed * lasts, end_speed * lasts
    c2, c3 = 3.0 * (end - start) - 2.0 * a - b, 2.0 * (start - end) + a + b
    return start + s * (a + s * (c2 + s * c3)), (a + s * (2.0 * c2 + 3.0 * s * c3)) / lasts


@subroutine
def leap_reference(leap, phase, t, out):
    """Set `out` `(12,)` to the state wanted at `t` s of a phase, as in `MpcProblem`."""
    lasts = leap.lasts[phase]
    share = min(t / lasts, 1.0)
    out[0] = out[6] = out[7] = out[8] = 0.0
    # Pitch: between the ends of phases, at the flight's rate into and out of it.
    first = 0.0 if phase == CROUCH else leap.pitches[phase - 1]
    last = 0.0 if phase == LANDING else leap.pitches[phase]
    if phase == FLIGHT:
        out[1], out[7] = first + share * (last - first), (last - first) / lasts
    else:
        rate = (leap.pitches[2] - leap.pitches[1]) / leap.lasts[FLIGHT]
        begin, end = rate if phase == LANDING else 0.0, rate if phase == PUSH else 0.0
        out[1], out[7] = hermite(first, begin, last, end, lasts, t)
    # Yaw: the push begins the turn, the flight goes on with it.
    before, after = leap.yaws[0], leap.yaws[1]
    rate = (after - before) / (0.5 * leap.lasts[PUSH] + leap.lasts[FLIGHT])
    lifted = before + 0.5 * rate * leap.lasts[PUSH]
    if phase == CROUCH:
        out[2] = before
    elif phase == PUSH:
        out[2], out[8] = hermite(before, 0.0, lifted, rate, lasts, t)
    elif phase == FLIGHT:
        out[2], out[8] = lifted + rate * t, rate
    else:
        out[2], out[8] = hermite(after, rate, after, 0.0, lasts, t)
    # The centre of mass: cubics on the ground, a ballistic flight.
    for a in range(3):
        if phase == CROUCH:
            place, speed = hermite(leap.start[a], 0.0, leap.squat[a], 0.0, 0.8 * lasts, t)
        elif phase == PUSH:
            place, speed = hermite(
                leap.squat[a], 0.0, leap.lift[a], leap.lift_velocity[a], lasts, t
            )
        elif phase == FLIGHT:
            fall = GRAVITY if a == 2 else 0.0
            speed = leap.lift_velocity[a] - fall * t
            place = leap.lift[a] + (leap.lift_velocity[a] - 0.5 * fall * t) * t
        else:
            if a == 2:
                lasts = leap.absorb
            place, speed = hermite(leap.down[a], leap.down_velocity[a], leap.rest[a], 0.0, lasts, t)
        out[3 + a], out[9 + a] = place, speed


@subroutine
def foothold(leap, leg):
    """Where a foot is to land: where the body comes down, but not back over the edge."""
    x = leap.foothold[leg, 0] + leap.shift[0]
    y = leap.foothold[leg, 1] + leap.shift[1]
    short = max(leap.bound - (x * leap.along[0] + y * leap.along[1]), 0.0)
    return x + short * leap.along[0], y + short * leap.along[1]


@subroutine
def leap_problem(robot, leap, state, body, centroid):
    """The `MpcProblem` of a robot that leaps: one programme over push, flight, landing.

    Steps end where phases do. A flight is two steps, whatever it lasts. `centroid` is the robot's
    `Centroid`.
    """
    reference = np.zeros((STEPS, 12))
    contacts = np.zeros((STEPS, 4), np.int64)
    levers = np.zeros((STEPS, 4, 3))
    yaws, dts = np.empty(STEPS), np.empty(STEPS)
    middle, now, place = np.empty(12), np.empty(12), np.empty(3)
    phase, t = leap.phase, state.time - leap.began
    measured = leap.yaws[0] + wrapped(body.angles[2] - leap.yaws[0])
    leap_reference(leap, phase, t, now)
    for k in range(STEPS):
        # The step's length: whole steps up to the end of each phase.
        if phase < LANDING and t >= leap.lasts[phase] - 1e-4:
            phase, t = phase + 1, 0.0
        if phase == LANDING:
            dt = leap.step
        else:
            left = leap.lasts[phase] - t
            most = max(0.5 * leap.lasts[FLIGHT], 0.05) if phase == FLIGHT else leap.step
            dt = left / math.ceil(left / most - 1e-6)
        dts[k] = dt
        leap_reference(leap, phase, t + 0.5 * dt, middle)
        t += dt
        leap_reference(leap, phase, t, reference[k])
        yaws[k] = measured + middle[2] - now[2]
        # Feet stand where they do until the flight, and where they have landed or will after it.
        for leg in range(4):
            stands = phase != FLIGHT
            if phase == LANDING and leap.phase == LANDING and k == 0:
                stands = state.contact[leg] == 1
            contacts[k, leg] = 1 if stands else 0
            landed = phase == LANDING and not (leap.phase == LANDING and state.contact[leg] == 1)
            for a in range(3):
                place[a] = state.stood[leg, a]
            if landed:
                place[0], place[1] = foothold(leap, leg)
                place[2] = leap.foothold[leg, 2]
            for a in range(3):
                # From where the centre of mass will be, seen from where it is.
                levers[k, leg, a] = place[a] - (centroid.centre[a] + middle[3 + a] - now[3 + a])
            levers[k, leg, 2] -= robot.foot_radius
    return MpcProblem(
        present_state(body.angles, centroid.centre, centroid.spin, centroid.velocity, measured),
        reference,
        contacts,
        levers,
        yaws,
        dts,
        robot.inertia,
        robot.mass,
        leap.land_weights if leap.phase == LANDING else leap.weights,
        leap.force_weight,
        leap.mu,
        leap.max_force,
    )
