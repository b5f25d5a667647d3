"""Whether contact forces account for a robot's motion: its weight, and its changes of momentum.

Forces are recorded as means over the intervals between samples, and mean velocities follow from
the places of all links at the samples. The difference of the mean velocities of two intervals is
the impulse between their middles, of which the two outer halves are only known by the interval's
mean force: if a force F sets in within an interval dt, that errs by F dt / 8 at most, and an
impact at one end of it by half of its impulse. How much sets in is seen from the forces of the
intervals before and after, of which a quarter is allowed for. So nothing of what is between
samples is needed, and a robot that is moved by anything but its feet is found out: carried,
dragged, or put elsewhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.physics.kinematics import Posture, middles
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.report import Kind, Violation, broken, excesses, stretches
from cavalcade.geometry import GRAVITY, Array

WEIGHT = 0.03
"""Mean vertical force may differ from the weight (and the change of momentum) by this fraction."""

LONG_ENOUGH = 2.0
"""Seconds over which forces are averaged for that."""

WINDOWS = (0.1, 0.5, 2.0)
"""Lengths in s over which changes of momentum are compared with impulses."""

SUDDEN = 0.5
"""Body weights by which forces may change within an interval unseen in the means beside it."""

DRIFT = 0.01
"""Of the weight: a steady error of the forces that is let pass."""

ARM = 0.25
"""Moment arm in m of a force that sets in within an interval."""

PLACE = 0.005
"""Where on a foot its force acts is known to this, m."""

SIMULATED, LEG = 0.002, 0.1
"""A usual step of a simulator, s, and how far a leg's mass is from what it turns about, m."""


def check_momentum(
    record: RobotRecord, posture: Posture, pushes: Array, unknown: NDArray[np.bool_]
) -> list[Violation]:
    """Changes of momentum, and of angular momentum, that no contact force accounts for.

    `pushes` `(T - 1, 3)` are the means of known forces on the trunk's centre in each interval, N;
    of the intervals `unknown` `(T - 1,)`, in which other forces act, nothing is said.
    """
    if len(record.time) < 3:
        return []
    linear, turning = _missing(record, posture, pushes)
    weight, middle = posture.weight * GRAVITY, middles(record.time)
    result = []
    # Over the whole recording the feet carry the robot's weight.
    part = _carried(middle, linear, weight, unknown)
    if part is not None and abs(part - 1.0) > WEIGHT:
        text = f"the feet of robot {record.robot} carry {100.0 * part:.1f} % of what moves it"
        result.append(broken("weight", record.time[0], record.robot, text, part, 1.0))
    edge = _grain(record, pushes, weight) + _steps(record, posture)
    rules: tuple[tuple[Kind, Array, Array, float], ...] = (
        ("momentum", linear, edge, DRIFT * weight),
        ("angular-momentum", turning, ARM * edge, PLACE * weight),
    )
    for kind, balance, end, drift in rules:
        found = [
            _window(record.robot, kind, middle, balance, span, end, drift, unknown)
            for span in WINDOWS
        ]
        # The shortest window that shows it says best when it was.
        result += next((violations for violations in found if violations), [])
    return result


def _missing(record: RobotRecord, posture: Posture, pushes: Array) -> tuple[Array, Array]:
    """Momentum and angular momentum `(T - 1, 3)` at intervals' middles less all impulses so far.

    Both stay what they are if the forces are what moves the robot.
    """
    step = record.steps[:, None]
    gravity = np.array([0.0, 0.0, -GRAVITY * posture.weight])
    force = record.forces[1:].sum(axis=1) + pushes + gravity
    center, soles = middles(posture.center), middles(posture.soles)
    moment = np.cross(soles - center[:, None], record.forces[1:]).sum(axis=1)
    moment += np.cross(middles(posture.centers[:, 0]) - center, pushes)
    linear = posture.weight * posture.velocity - _until_middle(force * step)
    return linear, posture.spin - _until_middle(moment * step)


def _grain(record: RobotRecord, pushes: Array, weight: float) -> Array:
    """By how much the impulse of half an interval may be off, `(T - 1,)` N s."""
    forces = np.concatenate((record.forces[1:], pushes[:, None]), axis=1)
    change = np.linalg.norm(np.diff(forces, axis=0), axis=2).sum(axis=1)
    sudden = np.full(len(forces), SUDDEN * weight / 8.0)
    sudden[1:] += change / 4.0
    sudden[:-1] += change / 4.0
    return sudden * record.steps


def _steps(record: RobotRecord, posture: Posture) -> Array:
    """What a simulator's own steps err by while legs turn fast, `(T - 1,)` N s.

    It keeps momentum to first order in its step: half a step of the force that holds a leg's mass
    on its circle.
    """
    rate = np.abs(np.diff(record.joints, axis=0)) / record.steps[:, None]
    fastest = rate.reshape(-1, 4, 3).max(axis=2)
    mass = posture.mass[1:].reshape(4, 3).sum(axis=1)
    return 0.5 * SIMULATED * LEG * (mass * fastest**2).sum(axis=1)


def _until_middle(impulse: Array) -> Array:
    return np.cumsum(impulse, axis=0) - 0.5 * impulse


def carried_part(
    record: RobotRecord, posture: Posture, pushes: Array, unknown: NDArray[np.bool_]
) -> float | None:
    """Mean vertical force over what the robot's weight and motion take; None if too short."""
    if len(record.time) < 3:
        return None
    linear, _ = _missing(record, posture, pushes)
    return _carried(middles(record.time), linear, posture.weight * GRAVITY, unknown)


def _carried(
    middle: Array, balance: Array, weight: float, unknown: NDArray[np.bool_]
) -> float | None:
    missing, span = 0.0, 0.0
    for begin, end in stretches(~unknown):
        missing += float(balance[begin, 2] - balance[end - 1, 2])
        span += float(middle[end - 1] - middle[begin])
    return None if span < LONG_ENOUGH else 1.0 + missing / (weight * span)


def _window(
    robot: int,
    kind: Kind,
    middle: Array,
    balance: Array,
    span: float,
    edge: Array,
    drift: float,
    unknown: NDArray[np.bool_],
) -> list[Violation]:
    """Windows of about `span` s in which more is missing than the recording's grain explains."""
    ahead = np.searchsorted(middle, middle + span - 1e-9)
    first = np.flatnonzero(ahead < len(middle))
    last = ahead[first]
    count = np.concatenate(([0], np.cumsum(unknown)))
    known = count[last + 1] == count[first]
    first, last = first[known], last[known]
    gap = np.linalg.norm(balance[last] - balance[first], axis=1)
    limit = edge[first] + edge[last] + drift * (middle[last] - middle[first])
    unit, cause = ("N s", "force") if kind == "momentum" else ("N m s", "moment")
    words = (
        f"changes its {kind.replace('-', ' ')} within {span:g} s by {{value:.2f}} {unit} that no "
        f"{cause} on its feet accounts for; {{limit:.2f}} could be the recording's grain"
    )
    return excesses(kind, robot, middle[first], gap, limit, words)
