"""What a run in physics measured: how well forces carry, torques, slides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cavalcade.checking.physics.contacts import touched
from cavalcade.checking.physics.feet import slides
from cavalcade.checking.physics.floor import Floor
from cavalcade.checking.physics.kinematics import posture
from cavalcade.checking.physics.momentum import carried_part
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.report import PhysicsFigures
from cavalcade.robots.description import QuadrupedDescription


def measured(
    records: Sequence[RobotRecord], descriptions: Sequence[QuadrupedDescription], floor: Floor
) -> PhysicsFigures:
    """The figures of a team."""
    carried: list[float | None] = []
    torque, slide = 0.0, 0.0
    for record, description in zip(records, descriptions, strict=True):
        links = posture(record, description, floor=floor)
        nothing = np.zeros((len(record.time) - 1, 3))
        carried.append(carried_part(record, links, nothing, touched(record)))
        ratio = np.abs(record.torques) / description.torque_limits
        torque = max(torque, float(ratio.max(initial=0.0)))
        slide = max(slide, float(slides(record, links).max(initial=0.0)))
    return PhysicsFigures(tuple(carried), torque, slide)
