"""Torques, angles and rates of joints: their limits, and whether they say the same as the rest."""

from __future__ import annotations

import numpy as np

from cavalcade.checking.physics.kinematics import Posture
from cavalcade.checking.physics.momentum import GRAVITY
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.plans.stretches import excesses
from cavalcade.checking.report import Kind, Violation
from cavalcade.geometry import Array
from cavalcade.robots.description import JOINTS, LEGS, QuadrupedDescription

TORQUE = 1e-3
"""Torques may exceed their limit by this, N m: they are recorded as they are applied."""

ANGLE = 0.05
"""Angles may exceed their range by this, rad: stops give way a little."""

RATE = (0.5, 0.25)
"""Root mean square difference in rad/s between recorded rates and those of the angles, and what of
their own root mean square is added: rates change within an interval."""

HOLDING = (1.0, 0.35)
"""Likewise of torques in N m, and those that hold the feet's forces."""

LOADED = 0.1
"""A foot with more than this part of the weight carries."""


def check_joints(
    record: RobotRecord, posture: Posture, description: QuadrupedDescription
) -> list[Violation]:
    """Joints beyond their limits, or with rates or torques that don't belong to the motion."""
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
        result += _check_holding(record, posture)
    return result


def _check_rates(record: RobotRecord) -> list[Violation]:
    found = np.diff(record.joints, axis=0) / record.steps[:, None]
    told = 0.5 * (record.rates[1:] + record.rates[:-1])
    return _differing("joint", record, found, told, RATE, "rates", "rad/s", "the angles' change")


def _check_holding(record: RobotRecord, posture: Posture) -> list[Violation]:
    """In stance, motors hold the feet's forces and the legs' weights; the rest is small."""
    held = holding_torques(record, posture)
    normal = record.forces[1:, :, 2] > LOADED * posture.weight * GRAVITY
    firm = normal & np.roll(normal, 1, axis=0) & np.roll(normal, -1, axis=0)
    firm[[0, -1]] = False
    stands = np.repeat(firm, 3, axis=1)
    told = np.where(stands, record.torques[1:], 0.0)
    return _differing(
        "torque", record, np.where(stands, held, 0.0), told, HOLDING, "torques", "N m", "its feet"
    )


def holding_torques(record: RobotRecord, posture: Posture) -> Array:
    """Torques `(T - 1, 12)` in N m that hold the mean forces of each interval and the weights."""
    held = np.empty((len(record.time) - 1, 12))
    middle = 0.5 * (posture.place[1:] + posture.place[:-1])
    centers = 0.5 * (posture.centers[1:] + posture.centers[:-1])
    soles = 0.5 * (posture.soles[1:] + posture.soles[:-1])
    for leg in range(4):
        for j in range(3):
            link = 1 + 3 * leg + j
            pivot = middle[:, link]
            moment = np.cross(soles[:, leg] - pivot, record.forces[1:, leg])
            for outer in range(link, 4 + 3 * leg):
                weight = (0.0, 0.0, -GRAVITY * posture.mass[outer])
                moment += np.cross(centers[:, outer] - pivot, weight)
            axis = 0.5 * (posture.axes[1:, link - 1] + posture.axes[:-1, link - 1])
            held[:, link - 1] = -(axis * moment).sum(axis=1)
    return held


def _differing(
    kind: Kind,
    record: RobotRecord,
    found: Array,
    told: Array,
    allowed: tuple[float, float],
    what: str,
    unit: str,
    source: str,
) -> list[Violation]:
    """Joints whose recorded figures `(T - 1, 12)` are, all in all, not those found."""
    result = []
    difference, size = _rms(told - found), _rms(found)
    limit = allowed[0] + allowed[1] * size
    for j in np.flatnonzero(difference > limit):
        when = float(record.time[int(np.abs(told - found)[:, j].argmax())])
        text = (
            f"the {what} recorded of robot {record.robot}'s {LEGS[j // 3]} {JOINTS[j % 3]} differ "
            f"by {difference[j]:.2f} {unit} in the mean from those of {source}"
        )
        result.append(
            Violation(kind, when, (record.robot,), text, float(difference[j]), float(limit[j]))
        )
    return result


def _rms(values: Array) -> Array:
    return np.sqrt(np.mean(values * values, axis=0))
