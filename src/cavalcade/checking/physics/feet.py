"""Feet: they push only where there is ground, do not sink into it, and do not slide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.physics.floor import Floor
from cavalcade.checking.physics.kinematics import CALVES, Posture, middles
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.rotations import turns
from cavalcade.checking.report import Violation
from cavalcade.checking.stretches import excesses, stretches
from cavalcade.geometry import GRAVITY, Array
from cavalcade.robots.description import LEGS

TOUCHING = 2.0
"""N; a smaller mean force is none."""

ABOVE = 0.01
"""A foot that pushes is no further from the ground than this, m, at one end of the interval."""

BELOW, IMPACT, BRIEF = 0.015, 0.03, 0.05
"""No foot is further below the ground than the first, m: contacts give way a little; in impacts,
that is for less than the last, s, not further than the second."""

FRICTION = 1.2
"""Largest coefficient of friction that is believed if it is not known: rubber on rough ground."""

FIRM, STANDS = 0.15, 0.05
"""A foot that carries this part of the weight, before and after as well, for so long in s, stands:
it does not slide. What bounces does not stand."""

SLIDING = 0.01
"""A standing foot may slide this far from where it set down, m, half the radius of its ball,
unless friction holds against it: a foot whose friction is used up slides as it should."""

CREEP = 0.01
"""All standing feet together may slide this fast in the mean over the recording, m/s."""

USED = 0.3
"""Sideways force over normal force from which friction may be used up: ice has less, but no legs
walk there."""


def check_feet(
    record: RobotRecord, posture: Posture, floor: Floor, friction: float = FRICTION
) -> list[Violation]:
    """Feet that push in the air, sink in, pull, are held sideways by nothing, or slide."""
    result: list[Violation] = []
    bottom = posture.feet[..., 2] - posture.radius
    low, high = floor.range_at(posture.feet[..., :2], posture.radius)
    force = record.forces[1:]
    pressing, along = _parts(record, posture)
    clear = np.minimum((bottom - high)[1:], (bottom - high)[:-1])
    slid = slides(record, posture)
    for leg, name in enumerate(LEGS):
        robot, time = record.robot, record.time
        size = np.linalg.norm(force[:, leg], axis=1)
        pushing = np.where(size > TOUCHING, clear[:, leg], 0.0)
        words = f"pushes with its foot {name} {{value:.3f}} m above the ground"
        result += excesses("footing", robot, time[1:], pushing, 0.0, words, ABOVE)
        sunk = _lasting(time, (low - bottom)[:, leg])
        words = f"has its foot {name} {{value:.3f}} m below the ground"
        result += excesses("footing", robot, time, sunk, 0.0, words, BELOW)
        words = f"is pulled down by its foot {name} with {{value:.1f}} N"
        result += excesses("friction", robot, time[1:], -pressing[:, leg], 0.0, words, TOUCHING)
        sideways = np.linalg.norm(along[:, leg], axis=-1)
        words = f"is held sideways by its foot {name} with {{value:.1f}} N; {{limit:.1f}} would do"
        most = friction * np.maximum(pressing[:, leg], 0.0)
        slack = TOUCHING + floor.doubt * size
        result += excesses("friction", robot, time[1:], sideways, most, words, slack)
        words = f"slides {{value:.3f}} m on its standing foot {name}"
        result += excesses("slide", robot, time[1:], slid[:, leg], 0.0, words, SLIDING)
    return result + _creeping(record, posture)


def _lasting(time: Array, depth: Array) -> Array:
    """Depths `(T,)` without those of impacts."""
    result = np.where(depth > IMPACT, depth, 0.0)
    for begin, end in stretches(depth > BELOW):
        if time[end - 1] - time[begin] >= BRIEF - 1e-9:
            result[begin:end] = depth[begin:end]
    return result


def _creeping(record: RobotRecord, posture: Posture) -> list[Violation]:
    firm = standing(record, posture)
    if not firm.any():
        return []
    path = np.where(firm, np.linalg.norm(slips(record, posture), axis=2), 0.0)
    speed = float(path.sum() / (firm * record.steps[:, None]).sum())
    if speed <= CREEP:
        return []
    worst = float(record.time[int(path.sum(axis=1).argmax())])
    text = f"robot {record.robot} slides on its standing feet at {speed:.3f} m/s in the mean"
    return [Violation("slide", worst, (record.robot,), text, speed, CREEP)]


def standing(record: RobotRecord, posture: Posture) -> NDArray[np.bool_]:
    """Intervals `(T - 1, 4)` in which a foot stands."""
    firm = record.forces[1:, :, 2] > FIRM * posture.weight * GRAVITY
    inner = firm.copy()
    inner[1:] &= firm[:-1]
    inner[:-1] &= firm[1:]
    for leg in range(4):
        for begin, end in stretches(inner[:, leg]):
            if record.time[end] - record.time[begin] < STANDS - 1e-9:
                inner[begin:end, leg] = False
    return inner


def _parts(record: RobotRecord, posture: Posture) -> tuple[Array, Array]:
    """Forces of intervals across the ground `(T - 1, 4)` and along it `(T - 1, 4, 3)`.

    On an edge the normal is not known; there both are none.
    """
    even = posture.even[1:] & posture.even[:-1]
    normals = middles(posture.normals)
    force = np.where(even[..., None], record.forces[1:], 0.0)
    return (force * normals).sum(axis=-1), _along(force, normals)


def slips(record: RobotRecord, posture: Posture) -> Array:
    """What feet slide in each interval along the ground with nothing against it, `(T - 1, 4, 3)` m.

    A foot is a ball that rolls as its calf turns: its centre moves, what touches the ground does
    not. A foot whose friction is used up may slide against it; on an edge nothing is said.
    """
    normals = middles(posture.normals)
    rolled = np.cross(turns(posture.turn[:, CALVES]), posture.radius * normals)
    moved = _along(np.diff(posture.feet, axis=0) - rolled, normals)
    pressing, along = _parts(record, posture)
    braking = -(along * moved).sum(axis=-1)
    excused = braking > USED * pressing * np.linalg.norm(moved, axis=-1)
    excused |= ~(posture.even[1:] & posture.even[:-1])
    return np.where(excused[..., None], 0.0, moved)


def slides(record: RobotRecord, posture: Posture) -> Array:
    """Distances `(T - 1, 4)` in m of standing feet from where they set down, by slipping."""
    moved, firm = slips(record, posture), standing(record, posture)
    result = np.zeros(firm.shape)
    for leg in range(4):
        for begin, end in stretches(firm[:, leg]):
            path = np.cumsum(moved[begin:end, leg], axis=0)
            result[begin:end, leg] = np.linalg.norm(path, axis=1)
    return result


def _along(vectors: Array, normals: Array) -> Array:
    return vectors - (vectors * normals).sum(axis=-1, keepdims=True) * normals
