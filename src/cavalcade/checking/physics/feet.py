"""Feet: they push only where there is ground, do not sink into it, and do not slide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.physics.floor import Floor
from cavalcade.checking.physics.kinematics import CALVES, Posture
from cavalcade.checking.physics.momentum import GRAVITY
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.rotations import turns
from cavalcade.checking.physics.stretches import stretches
from cavalcade.checking.plans.stretches import excesses
from cavalcade.checking.report import Violation
from cavalcade.geometry import Array
from cavalcade.robots.description import LEGS

TOUCHING = 2.0
"""N; a smaller mean force is none."""

ABOVE = 0.01
"""A foot that pushes is no further from the ground than this, m, at one end of the interval."""

BELOW = 0.015
"""No foot is further below the ground than this, m: contacts give way a little."""

FRICTION = 1.2
"""Largest coefficient of friction that is believed, rubber on rough ground."""

FIRM = 0.1
"""A foot with this part of the weight, before and after as well, stands: it does not slide."""

SLIDING = 0.005
"""A standing foot may slide this far from where it set down, m, unless friction holds against it:
a foot whose friction is used up slides as it should."""

USED = 0.3
"""Sideways force over normal force from which friction may be used up: ice has less, but no legs
walk there."""

LEVEL = 0.005
"""Ground that differs by less, m, below a foot counts as level there."""


def check_feet(record: RobotRecord, posture: Posture, floor: Floor) -> list[Violation]:
    """Feet that push in the air, sink in, pull, are held sideways by nothing, or slide."""
    result: list[Violation] = []
    bottom = posture.feet[..., 2] - posture.radius
    low, high = floor.range_at(posture.feet[..., :2], posture.radius)
    force = record.forces[1:]
    level = np.maximum(high - low, 0.0)[1:] < LEVEL
    clear = np.minimum((bottom - high)[1:], (bottom - high)[:-1])
    slid = slides(record, posture)
    for leg, name in enumerate(LEGS):
        robot, time = record.robot, record.time
        size = np.linalg.norm(force[:, leg], axis=1)
        pushing = np.where(size > TOUCHING, clear[:, leg], 0.0)
        words = f"pushes with its foot {name} {{value:.3f}} m above the ground"
        result += excesses("footing", robot, time[1:], pushing, 0.0, words, ABOVE)
        words = f"has its foot {name} {{value:.3f}} m below the ground"
        result += excesses("footing", robot, time, (low - bottom)[:, leg], 0.0, words, BELOW)
        # On an edge the normal is not known; there nothing is said.
        upwards = np.where(level[:, leg], force[:, leg, 2], size)
        words = f"is pulled down by its foot {name} with {{value:.1f}} N"
        result += excesses("friction", robot, time[1:], -upwards, 0.0, words, TOUCHING)
        sideways = np.where(level[:, leg], np.hypot(*force[:, leg, :2].T), 0.0)
        words = f"is held sideways by its foot {name} with {{value:.1f}} N; {{limit:.1f}} would do"
        most = FRICTION * np.maximum(upwards, 0.0)
        result += excesses("friction", robot, time[1:], sideways, most, words, TOUCHING)
        words = f"slides {{value:.3f}} m on its standing foot {name}"
        result += excesses("slide", robot, time[1:], slid[:, leg], 0.0, words, SLIDING)
    return result


def standing(record: RobotRecord, posture: Posture) -> NDArray[np.bool_]:
    """Intervals `(T - 1, 4)` in which, and before and after which, a foot carries."""
    firm = record.forces[1:, :, 2] > FIRM * posture.weight * GRAVITY
    inner = firm.copy()
    inner[1:] &= firm[:-1]
    inner[:-1] &= firm[1:]
    return inner


def slides(record: RobotRecord, posture: Posture) -> Array:
    """Distances `(T - 1, 4)` in m that standing feet have slid with nothing that holds against it.

    Counted from where they set down. A foot is a ball that rolls as its calf turns: its centre
    moves, what touches the ground does not. Of the motion that is left only what is along the
    ground is looked at. A foot whose friction is used up may slide against it.
    """
    normals = 0.5 * (posture.normals[1:] + posture.normals[:-1])
    rolled = np.cross(turns(posture.turn[:, CALVES]), posture.radius * normals)
    moved = _along(np.diff(posture.feet, axis=0) - rolled, normals)
    force = record.forces[1:]
    pressing = (force * normals).sum(axis=-1)
    braking = -(_along(force, normals) * moved).sum(axis=-1)
    excused = braking > USED * pressing * np.linalg.norm(moved, axis=-1)
    moved = np.where(excused[..., None], 0.0, moved)
    firm = standing(record, posture)
    result = np.zeros(firm.shape)
    for leg in range(4):
        for begin, end in stretches(firm[:, leg]):
            path = np.cumsum(moved[begin:end, leg], axis=0)
            result[begin:end, leg] = np.linalg.norm(path, axis=1)
    return result


def _along(vectors: Array, normals: Array) -> Array:
    part: Array = vectors - (vectors * normals).sum(axis=-1, keepdims=True) * normals
    return part
