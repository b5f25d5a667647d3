"""Torques, angles and rates of joints: their limits, and whether they say the same as the rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.physics.feet import standing
from cavalcade.checking.physics.kinematics import Posture, middles
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.report import Violation
from cavalcade.checking.stretches import excesses
from cavalcade.geometry import GRAVITY, Array
from cavalcade.robots.description import JOINTS, LEGS, QuadrupedDescription

TORQUE = 1e-3
"""Torques may exceed their limit by this, N m: they are recorded as they are applied."""

ANGLE = 0.05
"""Angles may exceed their range by this, rad: stops give way a little."""

RATE = (0.5, 0.25)
"""Root mean square difference in rad/s between recorded rates and those of the angles, and what of
their own root mean square is added: rates change within an interval."""

HOLDING = (0.5, 0.5)
"""Likewise of a leg's torques in N m, and those that hold its foot's forces: what is recorded are
the largest in an interval, and legs have some inertia of their own."""


def check_joints(
    record: RobotRecord,
    posture: Posture,
    description: QuadrupedDescription,
    unknown: NDArray[np.bool_],
) -> list[Violation]:
    """Joints beyond their limits, or with rates or torques that don't belong to the motion.

    In the intervals `unknown` `(T - 1,)` more than feet carries.
    """
    result: list[Violation] = []
    size = np.abs(record.torques)
    low, high = description.joint_range.T
    beyond = np.maximum(low - record.joints, record.joints - high)
    for j in range(12):
        name = f"{LEGS[j // 3]} {JOINTS[j % 3]}"
        words = f"puts {{value:.2f}} N m on its {name}; the limit is {{limit:.2f}}"
        limit = float(description.torque_limits[j])
        result += excesses("torque", record.robot, record.time, size[:, j], limit, words, TORQUE)
        words = f"turns its {name} {{value:.3f}} rad beyond its range"
        result += excesses("joint", record.robot, record.time, beyond[:, j], 0.0, words, ANGLE)
    if len(record.time) > 2:
        result += _check_rates(record)
        result += _check_holding(record, posture, unknown)
    return result


def _check_rates(record: RobotRecord) -> list[Violation]:
    found = np.diff(record.joints, axis=0) / record.steps[:, None]
    amiss = middles(record.rates) - found
    difference, limit = _rms(amiss), RATE[0] + RATE[1] * _rms(found)
    result = []
    for j in np.flatnonzero(difference > limit):
        when = float(record.time[int(np.abs(amiss)[:, j].argmax())])
        text = (
            f"the rates recorded of robot {record.robot}'s {LEGS[j // 3]} {JOINTS[j % 3]} differ "
            f"by {difference[j]:.2f} rad/s in the mean from those of its angle"
        )
        value, most = float(difference[j]), float(limit[j])
        result.append(Violation("joint", when, (record.robot,), text, value, most))
    return result


def _check_holding(
    record: RobotRecord, posture: Posture, unknown: NDArray[np.bool_]
) -> list[Violation]:
    """In stance, motors hold the feet's forces and the legs' weights; the rest is small."""
    held = holding_torques(record, posture)
    firm = standing(record, posture) & ~unknown[:, None]
    stands = np.repeat(firm, 3, axis=1)
    amiss = np.where(stands, record.torques[1:] - held, 0.0)
    result = []
    for leg, name in enumerate(LEGS):
        mine = slice(3 * leg, 3 * leg + 3)
        difference = float(_rms(amiss[:, mine].reshape(-1)))
        size = float(_rms(np.where(stands, held, 0.0)[:, mine].reshape(-1)))
        limit = HOLDING[0] + HOLDING[1] * size
        if difference > limit:
            when = float(record.time[int(np.abs(amiss[:, mine]).max(axis=1).argmax())])
            text = (
                f"the torques recorded of robot {record.robot}'s leg {name} differ by "
                f"{difference:.2f} N m in the mean from those that hold its foot's force"
            )
            result.append(Violation("torque", when, (record.robot,), text, difference, limit))
    return result


def holding_torques(record: RobotRecord, posture: Posture) -> Array:
    """Torques `(T - 1, 12)` in N m that hold the mean forces of each interval and the weights."""
    held = np.empty((len(record.time) - 1, 12))
    middle, centers = middles(posture.place), middles(posture.centers)
    soles, axes = middles(posture.soles), middles(posture.axes)
    for leg in range(4):
        for j in range(3):
            link = 1 + 3 * leg + j
            pivot = middle[:, link]
            moment = np.cross(soles[:, leg] - pivot, record.forces[1:, leg])
            for outer in range(link, 4 + 3 * leg):
                weight = (0.0, 0.0, -GRAVITY * posture.mass[outer])
                moment += np.cross(centers[:, outer] - pivot, weight)
            held[:, link - 1] = -(axes[:, link - 1] * moment).sum(axis=1)
    return held


def _rms(values: Array) -> Array:
    return np.sqrt(np.mean(values * values, axis=0))
